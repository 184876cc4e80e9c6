#include "estimation/repeatability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "estimation/calibrate.h"
#include "fitted_model.h"
#include "model/observed_domain.h"
#include "read_contacts.h"
#include "session_files.h"

namespace mm {
namespace {

using test::fitted;

/// Runs of an ISO 230-2 measurement with noise of `sigma` (m).
struct Runs {
  int runs = 5, targets = 9;
  double sigma = 1e-6;
  double shift = 0.0;    // m a run, and more in the first
  double outlier = 0.0;  // m, of one reading
  bool directed = true;
};

Session session(const Runs& r, unsigned seed) {
  Session s(Machine::load("three_axis"));
  s.source = "runs.csv";
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  for (int run = 0; run < r.runs; ++run)
    for (const double sign : {1.0, -1.0})
      for (int i = 0; i < r.targets; ++i) {
        Observation o;
        o.kind = ObservationKind::kDeviation;
        o.time = 10.0 * static_cast<double>(s.observations.size());
        o.row = static_cast<std::int64_t>(s.observations.size()) + 2;
        const double x = sign * (-20e-3 + 40e-3 * i / (r.targets - 1));
        o.position = {x + 2e-6 * normal(generator), 0.0, 0.0};
        if (r.directed) o.velocity = {sign * 1e-3, 0.0, 0.0};
        o.deviation = {
            30e-6 * std::sin(200.0 * x) + 10e-6 * sign + r.shift * run + r.sigma * normal(generator),
            kNotMeasured, kNotMeasured};
        s.observations.push_back(o);
      }
  if (r.outlier != 0.0) s.observations[40].deviation[0] += r.outlier;
  s.prepare();
  return s;
}

// A table that was computed: one shift a run, and nothing else but the rounding of its numbers.
TEST(Repeatability, OfRunsThatDifferByRoundingOnlyIsNotKnown) {
  const CalibrationResult r = fitted(session({5, 9, 0.0, 0.3e-6}, 1));
  EXPECT_EQ(r.repeatabilityFrom, "estimated");
  EXPECT_GT(r.repeatability, 1e-6) << "the wave that no effect explains";
}

TEST(Repeatability, OfRunsIsTheScatterWithinTheTargets) {
  double sum = 0.0, squares = 0.0;
  constexpr int kTrials = 60;
  Repeatability one;
  for (int k = 0; k < kTrials; ++k) {
    const Session s = session({5, 9, 1e-6, 4e-6}, 100 + k);
    const CalibrationResult r = fitted(s);
    ASSERT_EQ(r.repeatabilityFrom, "repeated");
    one = r.repeated;
    EXPECT_EQ(r.repeatability, one.value);
    sum += one.value * one.value;
    squares += std::pow(one.value / 1e-6 - 1.0, 2);
  }
  EXPECT_NEAR(std::sqrt(sum / kTrials), 1e-6, 0.03e-6) << "a shift of 4 um a run is no repeatability";
  // two directions, eight independent targets, four differences of which neighbours share a run
  EXPECT_NEAR(one.dof, 2 * 8 * 2.0 * 16 / 11, 0.5);
  EXPECT_NEAR(std::sqrt(squares / kTrials) / one.relativeStd(), 1.0, 0.3);
  EXPECT_EQ(one.from, "runs");
  EXPECT_EQ(
      one.inWords,
      "from 5 runs over 18 targets, excluding shifts of a whole run: 46.5 degrees of freedom, ± 21 % (k "
      "= 2)");
}

TEST(Repeatability, IsNotBentByOneBadReading) {
  const double clean = fitted(session({}, 7)).repeatability;
  EXPECT_NEAR(fitted(session({5, 9, 1e-6, 0.0, 50e-6}, 7)).repeatability, clean, 0.1e-6);
}

/// There and back are different targets; where that was not recorded, nothing is claimed.
TEST(Repeatability, OfTargetsThatAreReachedFromManySidesIsNoSmaller) {
  // as a tracker sees them: half of the targets are the only ones that are reached in their way, and a shift
  // of the run takes all that they tell
  double sum = 0.0;
  constexpr int kTrials = 20;
  for (unsigned k = 0; k < kTrials; ++k) {
    Session s(Machine::load("three_axis"));
    s.source = "tracker.csv";
    std::mt19937 generator(k);
    std::normal_distribution<double> normal;
    for (int run = 0; run < 5; ++run)
      for (int i = 0; i < 16; ++i) {
        Observation o;
        o.kind = ObservationKind::kDeviation;
        o.time = 10.0 * static_cast<double>(s.observations.size());
        o.row = static_cast<std::int64_t>(s.observations.size()) + 2;
        o.position = {1e-3 * i, 1e-3 * ((7 * i) % 16), 1e-3 * ((3 * i) % 16)};
        const int way = std::min(i, 7);
        for (int j = 0; j < 3; ++j) {
          o.velocity.push_back((way >> j) % 2 == 0 ? 1e-3 : -1e-3);
          o.deviation.push_back(1e-6 * normal(generator));
        }
        s.observations.push_back(o);
      }
    s.prepare();
    const Repeatability found = fitted(s).repeated;
    EXPECT_EQ(found.from, "runs");
    sum += found.value * found.value;
  }
  EXPECT_NEAR(std::sqrt(sum / kTrials), 1e-6, 0.05e-6);
}

TEST(Repeatability, IsWhatTheReadingsStateOfThemselves) {
  Session s = session({5, 9, 0.3e-6}, 3);
  for (std::size_t i = 0; i < s.observations.size(); ++i)
    s.observations[i].deviationStd = {i % 2 == 0 ? 0.3e-6 : 0.4e-6, kNotMeasured, kNotMeasured};
  const CalibrationResult r = fitted(s);
  EXPECT_EQ(r.repeatabilityFrom, "declared");
  EXPECT_NEAR(r.repeatability, std::sqrt(0.5 * (0.09 + 0.16)) * 1e-6, 1e-12);
  s.artifact.repeatability = 2e-6;
  EXPECT_EQ(fitted(s).repeatability, r.repeatability) << "a reading that states its own is weighed by that";
  s.observations[7].deviationStd = {kNotMeasured, kNotMeasured, kNotMeasured};
  EXPECT_EQ(fitted(s).repeatability, 2e-6) << "the others are as good as is declared for all";
}

TEST(Repeatability, NeedsTheDirectionOfTravel) {
  const CalibrationResult r = fitted(session({5, 9, 1e-6, 0.0, 0.0, false}, 3));
  EXPECT_EQ(r.repeatabilityFrom, "estimated");
  EXPECT_EQ(r.repeated.dof, 0.0);
  EXPECT_EQ(fitted(session({2, 3}, 3)).repeatabilityFrom, "estimated") << "four differences say too little";
}

/// Five readings a target, one after the other, on a machine that drifts by a micrometre between two.
TEST(Repeatability, OfReadingsOneAfterTheOtherIsWithoutTheirDrift) {
  Session s(Machine::load("three_axis"));
  s.source = "repeats.csv";
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = i;
    o.row = i + 2;
    o.position = {1e-3 * (i / 5), 0.0, 0.0};
    o.deviation = {1e-6 * i + 0.5e-6 * normal(generator), kNotMeasured, kNotMeasured};
    s.observations.push_back(o);
  }
  s.prepare();
  const CalibrationResult r = fitted(s);
  EXPECT_EQ(r.repeated.from, "consecutive");
  EXPECT_NEAR(r.repeatability, 0.5e-6, 4 * r.repeated.relativeStd() * 0.5e-6);
  EXPECT_NEAR(r.repeated.dof, 40 * 36.0 * 9 / (36 * 3 + 32 * 2 + 2), 3.0);
}

/// By other means from the files themselves: differences between runs of each target and direction, less
/// their mean over the targets, beyond four times 1.4826 of their median left out: 1.338, 1.505 and 0.310 um.
TEST(Repeatability, OfRealInterferometerRuns) {
  const std::filesystem::path data = test::sharedData();
  if (data.empty()) GTEST_SKIP() << "the shared data are not there";
  const Machine machine = Machine::load("three_axis");
  const auto found = [&](const char* axis) {
    const Session s =
        readContactsCsv(data / "iso230_interferometer" / (std::string(axis) + "_axis.csv"), machine, nullptr);
    const CalibrationResult plain = fitted(s);
    EXPECT_EQ(plain.repeatabilityFrom, "repeated");
    EXPECT_GT(plain.repeated.dof, axis[0] == 'z' ? 20.0 : 40.0);
    const CalibrationResult modelled =
        fitted(s, {EffectSpec("backlash").set("axis", axis), EffectSpec("scale").set("axis", axis)});
    EXPECT_NEAR(modelled.repeatability, plain.repeatability, 1e-9) << "no matter what the model knows";
    std::cout << axis << ": " << plain.repeatability * 1e6 << " um " << plain.repeated.inWords << "\n";
    return plain.repeatability * 1e6;
  };
  EXPECT_NEAR(found("x"), 1.338, 1e-3);
  EXPECT_NEAR(found("y"), 1.505, 1e-3);
  EXPECT_NEAR(found("z"), 0.310, 1e-3);
}

/// A reading every 20 s at one place while the bed heats; its owner says 1.2 um, its display has steps of 2.5
/// um.
TEST(Repeatability, OfARealNozzleHeight) {
  const std::filesystem::path data = test::sharedData();
  if (data.empty()) GTEST_SKIP() << "the shared data are not there";
  const Session s = readContactsCsv(data / "frame_thermal" / "z_against_temperatures.csv",
                                    Machine::load("three_axis"), nullptr);
  const CalibrationResult r =
      fitted(s, {EffectSpec("thermal_growth").set("direction", "z").set("sensor", "bed"),
                 EffectSpec("thermal_growth").set("direction", "z").set("sensor", "frame")});
  std::cout << r.repeatability * 1e6 << " um " << r.repeated.inWords << "\n";
  EXPECT_EQ(r.repeatabilityFrom, "repeated");
  EXPECT_NEAR(r.repeatability, std::hypot(1.2e-6, 2.5e-6 / std::sqrt(12.0)), 0.25e-6);
}

// 0.6 of a standard deviation is what two random walks of a run have in common by chance
TEST(Repeatability, RunsShareWhatFollowsThePlaceAndNotWhatFollowsTheTime) {
  const Session s = session({}, 5);
  const CalibrationResult result = fitted(s);
  std::mt19937 generator(9);
  std::normal_distribution<double> normal;
  const int rows = static_cast<int>(result.problem->rows().size());
  Eigen::VectorXd place(rows), time(rows);
  double walk = 0.0;
  for (int i = 0; i < rows; ++i) {
    const double x = result.problem->state(result.problem->rows()[i].observation).position[0];
    place[i] = std::sin(200.0 * x) + 0.1 * normal(generator) + 5.0 * (i / 18);  // and each run is shifted
    time[i] = walk += normal(generator);
  }
  const SharedByRuns ofPlace = sharedByRuns(*result.problem, place, false),
                     ofTime = sharedByRuns(*result.problem, time, false);
  EXPECT_EQ(ofPlace.pairs, 8);  // five runs, both ways
  EXPECT_GT(ofPlace.share, 0.95);
  EXPECT_LT(std::abs(ofTime.share), 0.6);
}

}  // namespace
}  // namespace mm
