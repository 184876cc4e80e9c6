// The stated uncertainty is honest: over simulated sessions the 95 % intervals of the corrected point cover
// the truth in 95 % of the fresh states.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "compensation/compensator.h"
#include "known_plate.h"
#include "long_tests.h"
#include "simulation/simulate.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

struct Coverage {
  int inside = 0, asked = 0;
  double square = 0.0;  // of error over stated standard deviation
  double share() const { return static_cast<double>(inside) / asked; }
};

Coverage coverageOver(int sessions, const std::string& repeatability, const std::string& rough) {
  const Machine machine = Machine::load("three_axis");
  const Plan plan = Plan::parse(test::knownPlatePlan(repeatability), "plan.yaml", ".", machine);
  test::GeometryAndReversal known;
  ModelSpec& model = known.model;
  model.effects.push_back(EffectSpec("time_drift").set("direction", "z"));
  known.hidden.push_back("time_drift:z");

  Coverage coverage;
  for (int s = 0; s < sessions; ++s) {
    SimulationRequest request;
    request.seed = 1000 + static_cast<std::uint64_t>(s);
    request.rough = rough;
    request.hide = known.hidden;
    const Simulation simulation = simulate(machine, plan, request);
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    const Recalibration done = recalibrate(simulation.session, model, options);
    const Compensator compensator(done.calibration);
    std::mt19937_64 generator(request.seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 10; ++i) {
      TrueState at;
      at.time = unit(generator) * simulation.session.observations.back().time;
      for (std::size_t j = 0; j < 3; ++j) {
        const double low = done.calibration.domain.lower[j], high = done.calibration.domain.upper[j];
        at.position.push_back(low + unit(generator) * (high - low));
        at.travel.push_back(unit(generator) < 0.5 ? -1.0 : 1.0);
        at.velocity.push_back(0.0);
      }
      State state = compensator.blankState();
      state.time = at.time;
      state.position = at.position;
      state.travel = at.travel;
      compensator.model().place(state);
      const Correction c = compensator.apply(state);
      EXPECT_TRUE(c.valid) << c.reason;
      const Eigen::Vector3d missed = c.corrected.position - simulation.truth->position(at);
      for (int k = 0; k < 3; ++k) {
        const double z = missed[k] / std::sqrt(c.covariance(k, k));
        coverage.inside += std::abs(z) <= 1.959964;
        coverage.square += z * z;
        ++coverage.asked;
      }
    }
  }
  std::printf("%s %d sessions: %.2f %% of %d intervals cover the truth; RMS of error / sigma %.3f\n",
              rough.c_str(), sessions, 100.0 * coverage.share(), coverage.asked,
              std::sqrt(coverage.square / coverage.asked));
  return coverage;
}

// Within a session the errors at fresh states are linear in ten estimated parameters: about three independent
// trials a session, so that the pooled share scatters by 0.7 % over 300 sessions and by 1.6 % over 60.
void expectHonest(const std::string& repeatability, const std::string& rough = "") {
  const bool all = mm_test::longTests();
  const Coverage coverage = coverageOver(all ? 300 : 60, repeatability, rough);
  EXPECT_GE(coverage.share(), all ? 0.93 : 0.905);
  EXPECT_LE(coverage.share(), all ? 0.97 : 0.990);
}

TEST(HonestUncertainty, WithTheRepeatabilityDeclared) {
  MM_THOROUGH_ONLY("every day the noise that drifts stands for it");
  expectHonest("0.3");
}

// Noise with memory tells less than as much white noise would.
TEST(HonestUncertainty, WithCorrelatedNoise) {
  MM_THOROUGH_ONLY("every day the noise that drifts stands for it");
  expectHonest("0.3", "correlated");
}
TEST(HonestUncertainty, WithDrift) { expectHonest("0.3", "drift"); }

// The declared repeatability is half of the true one: the intervals go by the residuals.
TEST(HonestUncertainty, WithTheRepeatabilityUnderstated) {
  if (!mm_test::longTests()) GTEST_SKIP() << "set MM_LONG_TESTS=1";
  expectHonest("0.15");
}

}  // namespace
}  // namespace mm
