// The k = 2 interval covers what it says: for machines drawn from the calibration's own distribution, with
// draws and noise of this file's own (what is measured at a point follows the model, which is not what is
// tested); and for the simulated instrument, whose physics is its own.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdio>
#include <random>

#include "known_plate.h"
#include "long_tests.h"
#include "simulation/simulate.h"
#include "uncertainty/fitted_feature.h"
#include "uncertainty/task_shapes.h"
#include "uncertainty_support.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

constexpr double kTau = 900.0, kDriftStd = 0.3e-6, kNoise = 0.25e-6, kInterval = 5.0;

/// Scales, squarenesses, play and a periodic error, correlated at random.
Calibration correlatedCalibration() {
  Calibration c = test::bareCalibration({"{type: scale, axis: x}", "{type: scale, axis: y}",
                                         "{type: scale, axis: z}", "{type: squareness, axis: x, of: y}",
                                         "{type: squareness, axis: y, of: z}", "{type: backlash, axis: x}",
                                         "{type: straightness, axis: x, direction: z, degree: 2}",
                                         "{type: angular_motion, axis: y, about: x}"});
  const auto n = static_cast<Eigen::Index>(c.values.size());
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd mix = 1.5 * Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) mix(i, j) += 0.6 * normal(random);
  const Model model(Machine(c.urdf, c.machineName), c.domain, c.effects);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::string unit = c.values[static_cast<std::size_t>(i)].unit;
    mix.row(i) *= unit == "um" ? 0.2e-6 : 12e-6;
    c.values[static_cast<std::size_t>(i)].value = 3.0 * mix.row(i).norm() * normal(random);
  }
  c.covariance = mix * mix.transpose();
  test::setNoise(c, kNoise);
  c.heldOutRms = c.rms = std::sqrt(kNoise * kNoise + kDriftStd * kDriftStd);
  c.domain.features.clear();
  c.drift = {{"y", kDriftStd, kTau}};
  return c;
}

/// One machine of the distribution measures the points of a task: it goes where its own errors bring its tip
/// to them, and the calibration corrects what it reads.
std::vector<Eigen::Vector3d> measuredBy(const Calibration& truth, const Compensator& calibrated,
                                        const MeasurementTask& task, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Compensator machine(truth);
  std::vector<Eigen::Vector3d> measured;
  double drift = normal(random);
  for (const TaskPoint& p : task.points) {
    State state = machine.blankState();
    state.time = 0.0;
    state.temperature.assign(state.temperature.size(), 22.0);
    state.velocity.assign(3, 0.0);
    state.position.assign(3, 0.0);
    std::vector<double> side(3, 1.0);
    for (int j = 0; j < 3; ++j)
      if (p.normal[j] > 1e-6) side[static_cast<std::size_t>(j)] = -1.0;
    state.travel = side;
    machine.model().place(state);
    const TargetReadings reached = machine.correctTarget(p.place, state, side);
    EXPECT_TRUE(reached.reached) << reached.reason;
    state.position = reached.position;
    calibrated.model().place(state);
    Eigen::Vector3d at = calibrated.apply(state).corrected.position;
    at.y() += kDriftStd * drift;
    for (int k = 0; k < 3; ++k) at[k] += kNoise * normal(random);
    const double stays = std::exp(-kInterval / kTau);
    drift = stays * drift + std::sqrt(1.0 - stays * stays) * normal(random);
    measured.push_back(at);
  }
  return measured;
}

TEST(Coverage, OfMachinesDrawnFromTheDistribution) {
  const Calibration c = correlatedCalibration();
  const Compensator calibrated(c);
  const Eigen::MatrixXd root = c.covariance.llt().matrixL();
  std::mt19937_64 random(2026);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(-10.0, 14.0);  // y goes down to -15 mm
  const int tasks = mm_test::thoroughTests() ? 10 : 4, machines = 50 * tasks;
  const double scatter = std::sqrt(0.95 * 0.05 / machines);
  int inside[2] = {0, 0}, asked[2] = {0, 0}, ofBall[4] = {0, 0, 0, 0};
  // Ten distances and ten balls, every day four, each measured by fifty machines.
  for (int task = 0; task < 2 * tasks; ++task) {
    const bool ball = task >= tasks;
    char text[160];
    if (ball)
      std::snprintf(text, sizeof text, "ball:%.3f,%.3f,%.3f,4", place(random), place(random), place(random));
    else
      std::snprintf(text, sizeof text, "distance:%.3f,%.3f,%.3f:%.3f,%.3f,%.3f", place(random), place(random),
                    place(random), place(random), place(random), place(random));
    const auto measured = test::taskOf(text, c);
    const TaskUncertainty u = test::uncertaintyFor(text, c, {}, 20000, 7);
    ASSERT_TRUE(u.outside.empty()) << u.outside.front();
    for (int m = 0; m < 50; ++m) {
      Calibration truth = c;
      Eigen::VectorXd z(root.cols());
      for (double& v : z) v = normal(random);
      const Eigen::VectorXd shift = root * z;
      for (std::size_t k = 0; k < truth.values.size(); ++k)
        truth.values[k].value += shift[static_cast<Eigen::Index>(k)];
      std::vector<double> values(u.quantities.size());
      measured->figures(measuredBy(truth, calibrated, *measured, random), values.data());
      for (std::size_t q = 0; q < (ball ? 4U : 1U); ++q) {
        const bool covers =
            std::abs(values[q] - u.quantities[q].quantity.nominal) <= 2.0 * u.quantities[q].std;
        if (q == 0) {
          inside[ball] += covers;
          ++asked[ball];
        }
        if (ball) ofBall[q] += covers;
      }
    }
  }
  for (const int ball : {0, 1}) {
    const double share = static_cast<double>(inside[ball]) / asked[ball];
    std::printf("%s: %.1f %% of %d measurements within k = 2\n",
                ball != 0 ? "diameter of balls" : "distances", 100.0 * share, asked[ball]);
    EXPECT_EQ(asked[ball], machines);
    EXPECT_NEAR(share, 0.95, 2.05 * scatter);
  }
  for (int q = 1; q < 4; ++q) {
    const double share = static_cast<double>(ofBall[q]) / machines;
    std::printf("centre of balls, %c: %.1f %%\n", "dxyz"[q], 100.0 * share);
    EXPECT_NEAR(share, 0.9525, 2.3 * scatter);
  }
}

struct InstrumentCoverage {
  int inside = 0, asked = 0;
  int ofFigure[4] = {0, 0, 0, 0};  // of a ball: diameter, x, y, z
  double share() const { return static_cast<double>(inside) / asked; }
};

/// Sessions of the simulated instrument, calibrated; then distances and balls measured on it, one after the
/// other.
void instrumentCoverage(const std::vector<std::string>& unknown, const std::string& rough, int sessions,
                        bool fromResiduals, InstrumentCoverage& distances, InstrumentCoverage& balls) {
  const Machine machine = Machine::load("three_axis");
  const Plan plan = Plan::parse(test::knownPlatePlan(), "plan.yaml", ".", machine);
  test::GeometryAndReversal known;
  std::vector<std::string> hidden = unknown;
  hidden.insert(hidden.end(), known.hidden.begin(), known.hidden.end());
  for (int s = 0; s < sessions; ++s) {
    SimulationRequest request;
    request.seed = 500 + static_cast<std::uint64_t>(s);
    request.hide = hidden;
    request.rough = rough;
    const Simulation simulation = simulate(machine, plan, request);
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    const Recalibration done = recalibrate(simulation.session, known.model, options);
    const Calibration& c = done.calibration;
    TaskConditions conditions;
    if (fromResiduals) conditions.remainder = remainderOf(done.result, usualRemainderLength(c.domain));
    const Compensator compensator(c);
    std::mt19937_64 random(request.seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (const bool ball : {false, true}) {
      const auto coordinate = [&](int k) {
        const double low = c.domain.tipLower[k] + 5e-3, high = c.domain.tipUpper[k] - 5e-3;
        return (low + unit(random) * (high - low)) / kMillimetre;
      };
      char text[160];
      if (ball)
        std::snprintf(text, sizeof text, "ball:%.3f,%.3f,%.3f,4", coordinate(0), coordinate(1),
                      coordinate(2));
      else
        std::snprintf(text, sizeof text, "distance:%.3f,%.3f,%.3f:%.3f,%.3f,%.3f", coordinate(0),
                      coordinate(1), coordinate(2), coordinate(0), coordinate(1), coordinate(2));
      const auto task = test::taskOf(text, c);
      const TaskUncertainty u = test::uncertaintyFor(text, c, conditions, 4000);
      std::vector<Eigen::Vector3d> measured;
      double time = unit(random) * simulation.session.observations.back().time;
      for (const TaskPoint& p : task->points) {
        State state = compensator.blankState();
        state.position.assign(3, 0.0);
        state.velocity.assign(3, 0.0);
        state.time = time;
        std::vector<double> side(3, 1.0);
        for (int j = 0; j < 3; ++j)
          if (p.normal[j] > 1e-6) side[static_cast<std::size_t>(j)] = -1.0;
        state.travel = side;
        compensator.model().place(state);
        TrueState at;
        at.time = time;
        at.position = compensator.correctTarget(p.place, state, side).position;
        at.travel = side;
        at.velocity.assign(3, 0.0);
        // Where the probe says that it touched, less where it did.
        Eigen::Vector3d found = 2.0 * p.place - simulation.truth->position(at);
        for (int k = 0; k < 3; ++k) found[k] += 0.3e-6 * normal(random);
        measured.push_back(found);
        time += kInterval;
      }
      std::vector<double> values(u.quantities.size());
      task->figures(measured, values.data());
      InstrumentCoverage& coverage = ball ? balls : distances;
      const std::size_t last = ball ? 4 : 1;  // diameter and centre
      for (std::size_t q = 0; q < last; ++q) {
        const bool covers =
            std::abs(values[q] - u.quantities[q].quantity.nominal) <= 2.0 * u.quantities[q].std;
        coverage.inside += covers;
        coverage.ofFigure[q] += covers;
        ++coverage.asked;
      }
    }
  }
}

int sessions() { return mm_test::longTests() ? 200 : mm_test::thoroughTests() ? 40 : 12; }

void expectInstrumentCovered(const char* name, const std::vector<std::string>& unknown,
                             const std::string& rough, double atLeast, bool fromResiduals = false) {
  InstrumentCoverage distances, balls;
  instrumentCoverage(unknown, rough, sessions(), fromResiduals, distances, balls);
  std::printf(
      "simulated instrument, %s%s: k = 2 covers %.1f %% of %d distances, %.1f %% of %d figures of balls\n",
      name, fromResiduals ? ", remainder from residuals" : "", 100.0 * distances.share(), distances.asked,
      100.0 * balls.share(), balls.asked);
  const char* const figures[] = {"diameter", "x", "y", "z"};
  for (std::size_t q = 0; q < 4; ++q) {
    const double share = 4.0 * balls.ofFigure[q] / balls.asked;
    std::printf("  %s of balls: %.1f %%\n", figures[q], 100.0 * share);
  }
  EXPECT_GE(distances.share(), atLeast);
  EXPECT_GE(balls.share(), atLeast);
}

// One figure a session and kind: 40 sessions scatter by 3.4 %, and three times that below 95.4 % is 85 %; of
// 12, 77 %. Where a straightness is unknown, the centres of balls are covered in 90 % (docs/uncertainty.md):
// 80 %.
const double kRight = mm_test::thoroughTests() ? 0.85 : 0.77, kUnknown = 0.80;

TEST(Coverage, OfTheSimulatedInstrumentWithARightModel) {
  MM_THOROUGH_ONLY("every day the one that drifts stands for it");
  expectInstrumentCovered("right model", {}, "", kRight);
  if (mm_test::longTests()) expectInstrumentCovered("right model", {}, "", kRight, true);
}
TEST(Coverage, OfTheSimulatedInstrumentThatDrifts) {
  expectInstrumentCovered("drift", {}, "drift", kRight);
  if (mm_test::longTests()) expectInstrumentCovered("drift", {}, "drift", kRight, true);
}
TEST(Coverage, OfTheSimulatedInstrumentWithWhatTheModelDoesNotKnow) {
  MM_THOROUGH_ONLY("every day the one that drifts stands for it");
  const std::vector<std::string> straightness = {"straightness:x/z=1.5um"};
  expectInstrumentCovered("straightness that the model does not know", straightness, "", kUnknown);
  expectInstrumentCovered("straightness that the model does not know", straightness, "", kUnknown, true);
}

// A straightness of z that the model does not know lies in z.
TEST(Coverage, TheRemainderIsFoundWhereItLies) {
  const Machine machine = Machine::load("three_axis");
  const Plan plan = Plan::parse(test::knownPlatePlan(), "plan.yaml", ".", machine);
  test::GeometryAndReversal known;
  const auto found = [&](const std::vector<std::string>& more) {
    SimulationRequest request;
    request.seed = 77;
    request.hide = known.hidden;
    request.hide.insert(request.hide.end(), more.begin(), more.end());
    const Simulation simulation = simulate(machine, plan, request);
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    const Recalibration done = recalibrate(simulation.session, known.model, options);
    const auto remainder = remainderOf(done.result, usualRemainderLength(done.calibration.domain));
    EXPECT_TRUE(remainder);
    EXPECT_FALSE(remainderOf(done.result, 0.0)) << "no length, no field";
    return *remainder;
  };
  const Remainder straight = found({"straightness:x/z=6um"});
  EXPECT_GT(straight.smooth.z(), 0.5e-6);
  EXPECT_LT(straight.smooth.x(), 0.4 * straight.smooth.z());
  EXPECT_LT(straight.smooth.y(), 0.4 * straight.smooth.z());
  EXPECT_GT(straight.places, 2.0);
  EXPECT_LT(straight.places, 60.0) << "nine balls are no hundred independent places";
  // A right model leaves noise of 0.3 um, and nothing beside it that is large.
  const Remainder right = found({});
  EXPECT_LT(right.smooth.norm(), 0.2e-6);
}

}  // namespace
}  // namespace mm
