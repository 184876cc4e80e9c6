// Decisions by ISO 14253-1 and test values of ISO 10360-2, held against examples that were worked by hand.
#include "uncertainty/conformity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uncertainty/positioning_figures.h"
#include "uncertainty/task_verdict.h"
#include "uncertainty_support.h"

namespace mm {
namespace {

// Tolerance 10.000 to 10.020 mm, u = 1 um: guard band 1.645 um, zone of conformance 10.001645 to 10.018355
// mm.
TEST(Conformity, AHandWorkedToleranceZone) {
  const Specification s{10.000, 10.020};
  const double u = 0.001;
  const AcceptanceZone zone = acceptanceZone(u, s);
  ASSERT_TRUE(zone.exists);
  EXPECT_NEAR(zone.lower, 10.001645, 1e-6);
  EXPECT_NEAR(zone.upper, 10.018355, 1e-6);
  EXPECT_EQ(judge(10.010, u, s), Conformity::kConforms);
  EXPECT_EQ(judge(10.0183, u, s), Conformity::kConforms);
  EXPECT_EQ(judge(10.0190, u, s), Conformity::kUndecided);
  EXPECT_EQ(judge(10.0210, u, s), Conformity::kUndecided);
  EXPECT_EQ(judge(10.0217, u, s), Conformity::kDoesNotConform);
  EXPECT_EQ(judge(9.9983, u, s), Conformity::kDoesNotConform);
  EXPECT_NEAR(probabilityWithin(10.020, u, s), 0.5, 1e-12);
}

// One limit: a form of 2 um against 3 um. Phi(1.645) = 0.95.
TEST(Conformity, OneLimitHasOneGuardBand) {
  const Specification s{-std::numeric_limits<double>::infinity(), 3.0};
  EXPECT_EQ(judge(2.0, 0.60, s), Conformity::kConforms);   // 2 + 1.645 * 0.60 = 2.99
  EXPECT_EQ(judge(2.0, 0.62, s), Conformity::kUndecided);  // 3.02
  EXPECT_EQ(judge(4.0, 0.60, s), Conformity::kDoesNotConform);
  EXPECT_EQ(judge(4.0, 0.62, s), Conformity::kUndecided);
  EXPECT_NEAR(acceptanceZone(0.6, s).upper, 3.0 - 0.987, 1e-3);
}

// A tolerance of +-1 needs u below 1 / 1.96: else not even its middle conforms.
TEST(Conformity, AnUncertaintyTooLargeForTheTolerance) {
  const Specification s{-1.0, 1.0};
  EXPECT_TRUE(acceptanceZone(0.50, s).exists);
  EXPECT_NEAR(acceptanceZone(0.50, s).upper, 0.103, 0.005);  // both limits matter: Phi(1.794) - Phi(-2.206)
  EXPECT_FALSE(acceptanceZone(0.52, s).exists);
  EXPECT_EQ(judge(0.0, 0.52, s), Conformity::kUndecided);
  EXPECT_EQ(judge(0.0, 2000.0, s), Conformity::kUndecided) << "a value within is never shown not to conform";
  EXPECT_EQ(judge(0.3, 0.0, s), Conformity::kConforms);
  EXPECT_EQ(judge(1.3, 0.0, s), Conformity::kDoesNotConform);
}

// MPE = 1.5 um + L/250 with L in mm: 1.9 um at 100, 2.7 at 300, 3.5 at 500 mm. u = 0.2 um: guard band 0.33
// um.
TEST(Iso10360, HandWorkedLengths) {
  PermissibleError mpe;
  mpe.a = 1.5;
  mpe.k = 250.0;
  EXPECT_DOUBLE_EQ(mpe.at(100.0), 1.9);
  EXPECT_DOUBLE_EQ(mpe.at(500.0), 3.5);
  EXPECT_EQ(mpe.inWords(), "1.5 um + L/250");
  const auto judged = [&](double length, double error) {
    return judge(error, 0.2, {-mpe.at(length), mpe.at(length)});
  };
  EXPECT_EQ(judged(100, 1.5), Conformity::kConforms);        // 1.50 < 1.9 - 0.33
  EXPECT_EQ(judged(100, -1.6), Conformity::kUndecided);      // 1.60 > 1.57
  EXPECT_EQ(judged(300, 2.3), Conformity::kConforms);        // 2.30 < 2.37
  EXPECT_EQ(judged(300, -3.0), Conformity::kUndecided);      // 3.00 < 2.7 + 0.33
  EXPECT_EQ(judged(500, 3.9), Conformity::kDoesNotConform);  // 3.90 > 3.5 + 0.33
  mpe.b = 2.0;
  EXPECT_DOUBLE_EQ(mpe.at(500.0), 2.0);
}

// White noise of a length of 1 um, 105 times: with MPE = 2.5 um each length passes with 98.76 %, the whole
// test with 0.9876^105 = 27 %; where the lengths of a line share their first points, a little oftener.
TEST(Iso10360, TheWholeTestIsJudgedAtOnce) {
  Calibration c = test::bareCalibration({});
  test::setNoise(c, 1e-6 / std::sqrt(2.0));
  const Model model(Machine(c.urdf, c.machineName), c.domain, c.effects, c.networks);
  const auto passing = [&](double most) {
    TaskOptions options;
    options.permissible = PermissibleError{};
    options.permissible->a = most;
    const auto task = makeTask("iso10360-2", options, model);
    MonteCarloOptions trials;
    trials.trials = 4000;
    const TaskUncertainty u = taskUncertainty(*task, VirtualMachine(c, *task, {}), trials);
    ToleranceAsked asked;
    asked.permissible = options.permissible;
    return std::pair(u.passes, verdictsOf(u, asked).at(0));
  };
  const auto [share, verdict] = passing(2.5);
  EXPECT_NEAR(share, std::pow(std::erf(2.5 / std::sqrt(2.0)), 105), 0.03);
  EXPECT_EQ(verdict.conformity, Conformity::kUndecided) << "though every length for itself conforms";
  EXPECT_NE(verdict.inWords.find("would pass with a probability of"), std::string::npos) << verdict.inWords;
  EXPECT_EQ(passing(4.5).second.conformity, Conformity::kConforms);
  EXPECT_EQ(passing(1.5).second.conformity, Conformity::kDoesNotConform);
}

TEST(Iso10360, TheSmallestPermissibleErrorThatHolds) {
  const PermissibleError least = permissibleFor({{100, 0.5, 0.25}, {200, -1.0, 0.25}, {300, 1.5, 0.25}});
  EXPECT_NEAR(least.k, 200.0, 1e-9);  // |E| + 2u = 1.0, 1.5, 2.0: 0.5 um + L/200
  EXPECT_NEAR(least.a, 0.5, 1e-12);
  const PermissibleError flat = permissibleFor({{100, 2.0, 0.0}, {300, 1.0, 0.0}});
  EXPECT_TRUE(std::isinf(flat.k));
  EXPECT_NEAR(flat.a, 2.0, 1e-12);
}

// Scale alone: the error of a length along x is L times that of the scale, and of nothing else.
TEST(Iso10360, LengthsOfAMachineWithAnUncertainScale) {
  Calibration c = test::bareCalibration({"{type: scale, axis: x}"});
  c.covariance(0, 0) = std::pow(20e-6, 2);
  EXPECT_EQ(probingOf(test::uncertaintyFor("iso10360-2", c, {}, 100)), nullptr)
      << "no contacts, no probing error";
  c.domain.features = {"b0"};
  c.domain.featureRadius = {4e-3};
  const TaskUncertainty u = test::uncertaintyFor("iso10360-2", c, {}, 4000);
  EXPECT_EQ(u.quantities.size(), 2U + 35U);
  ASSERT_NE(probingOf(u), nullptr);
  // x stretched by s: the range of the radius over a half ball is about R s / 2, less what its centre takes.
  EXPECT_GT(probingOf(u)->mean, 1e-9);
  EXPECT_LT(probingOf(u)->mean, 4e-3 * 20e-6);
  for (const QuantityUncertainty& q : u.quantities) {
    const std::string& name = q.quantity.name;
    const bool alongX = name.size() > 3 && name.substr(name.size() - 3) == ", x";
    const bool alongY = name.size() > 3 && name.substr(name.size() - 3) == ", y";
    if (alongX) {
      EXPECT_NEAR(q.std, q.quantity.length * 20e-6, 0.05 * q.std);
    } else if (alongY) {
      EXPECT_LT(q.std, 1e-12);
    } else if (name.find("diagonal") != std::string::npos) {  // along (1, 1, 1): a third of it
      EXPECT_NEAR(q.std, q.quantity.length * 20e-6 / 3.0, 0.05 * q.std);
    }
  }
  const std::vector<TestLength> lengths = testLengthsOf(u);
  const PermissibleError least = permissibleFor(lengths);
  for (const TestLength& l : lengths) EXPECT_LE(std::abs(l.error) + 2.0 * l.std, least.at(l.length) + 1e-9);
  ToleranceAsked asked;
  asked.permissible = PermissibleError{};
  asked.permissible->a = 0.05;
  asked.permissible->k = 25.0;  // 2 u(scale) = 1/25 um a mm
  EXPECT_EQ(verdictsOf(u, asked).at(0).conformity, Conformity::kConforms);
  asked.permissible->a = 0.0;
  asked.permissible->k = 200.0;
  EXPECT_EQ(verdictsOf(u, asked).at(0).conformity, Conformity::kUndecided);
}

// Two targets, two runs: means 1 and 3 um upwards, 0 and 2 um downwards, no scatter: E = 3, B = 1, A = 3.
TEST(Iso230, PositioningFiguresByHand) {
  std::vector<PositioningRun> runs;
  for (int r = 0; r < 2; ++r)
    for (const auto& [at, up, down] : {std::tuple(0.0, 1.0, 0.0), std::tuple(100.0, 3.0, 2.0)}) {
      runs.push_back({at, up, true});
      runs.push_back({at, down, false});
    }
  const PositioningFigures f = positioningTest(runs).figures;
  EXPECT_DOUBLE_EQ(f.systematic, 3.0);
  EXPECT_DOUBLE_EQ(f.accuracy, 3.0);
  EXPECT_DOUBLE_EQ(f.reversal, 1.0);
  EXPECT_DOUBLE_EQ(f.repeatability, 1.0);
}

// Equal spacing would meet a screw at one phase where its pitch divides the spacing.
TEST(Iso230, TargetsMeetAScrewAtDifferentPhases) {
  const Calibration c = test::bareCalibration({});
  const auto task = test::taskOf("iso230-2:x", c);
  std::vector<double> at;
  for (int i = 0; i < 5; ++i) at.push_back(task->points[static_cast<std::size_t>(i)].place.x());
  const double spacing = (at.back() - at.front()) / 4.0;
  double lowest = 1.0, highest = -1.0;
  for (int i = 0; i < 5; ++i) {
    const double phase = (at[static_cast<std::size_t>(i)] - at.front()) / spacing - i;
    lowest = std::min(lowest, phase);
    highest = std::max(highest, phase);
  }
  EXPECT_GT(highest - lowest, 0.1);
  EXPECT_TRUE(std::is_sorted(at.begin(), at.end()));
  const double range = c.domain.upper[0] - c.domain.lower[0];
  EXPECT_GT(at.back() - at.front(), 0.85 * range);
  EXPECT_LT(at.back() - at.front(), range);
}

// An uncertain play of u = 0.6 um is a reversal of its absolute value: mean 0.6 sqrt(2 / pi).
TEST(Iso230, ReversalOfAnUncertainPlay) {
  Calibration c = test::bareCalibration({"{type: backlash, axis: x}"});
  c.covariance(0, 0) = std::pow(0.6e-6, 2);
  const TaskUncertainty u = test::uncertaintyFor("iso230-2:x", c, {}, 20000);
  EXPECT_NEAR(test::quantity(u, "reversal B").mean, 0.6e-6 * std::sqrt(2.0 / kPi), 0.01e-6);
  EXPECT_NEAR(test::quantity(u, "accuracy A").mean, 0.6e-6 * std::sqrt(2.0 / kPi), 0.01e-6);
  ToleranceAsked asked;
  asked.tolerance = 2.0e-6;
  EXPECT_EQ(verdictsOf(u, asked).at(0).conformity, Conformity::kConforms);
  asked.tolerance = 0.5e-6;
  EXPECT_EQ(verdictsOf(u, asked).at(0).conformity, Conformity::kUndecided);
}

TEST(Verdict, AMeasuredValueAgainstItsTolerance) {
  Calibration c = test::bareCalibration({});
  test::setNoise(c, 1e-6 / std::sqrt(2.0));  // of a distance: 1 um
  const TaskUncertainty u = test::uncertaintyFor("distance:0,0,0:10,0,0", c);
  ToleranceAsked asked;
  asked.tolerance = 5e-6;
  asked.measured = 10.003e-3;
  EXPECT_EQ(verdictsOf(u, asked).at(0).conformity, Conformity::kConforms);  // 3 < 5 - 1.645
  asked.measured = 10.004e-3;
  EXPECT_EQ(verdictsOf(u, asked).at(0).conformity, Conformity::kUndecided);
  asked.measured = 9.990e-3;
  EXPECT_EQ(verdictsOf(u, asked).at(0).conformity, Conformity::kDoesNotConform);
  EXPECT_NE(verdictsOf(u, asked).at(0).inWords.find("does not conform"), std::string::npos);
  asked.tolerance = kNotMeasured;
  EXPECT_THROW(verdictsOf(u, asked), std::exception);
}

}  // namespace
}  // namespace mm
