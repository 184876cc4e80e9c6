// Where the uncertainty of a task is known in closed form, the virtual machine finds it.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "effects/effect_words.h"
#include "uncertainty/task_shapes.h"
#include "uncertainty_support.h"

namespace mm {
namespace {

using test::bareCalibration, test::quantity, test::setNoise, test::shareOf, test::uncertaintyFor;

constexpr double kClose = 0.015;  // of a standard deviation from 40 000 trials: 0.35 % is its own scatter

void expectStd(const TaskUncertainty& u, double expected, const std::string& name = {}) {
  const QuantityUncertainty& q = name.empty() ? u.quantities[u.headline] : quantity(u, name);
  EXPECT_NEAR(q.std, expected, kClose * expected) << u.task << " " << q.quantity.name;
}

TEST(ClosedForm, ScaleAloneMakesALengthUncertainByLengthTimesItsUncertainty) {
  Calibration c = bareCalibration({"{type: scale, axis: x}"});
  c.covariance(0, 0) = std::pow(20e-6, 2);
  expectStd(uncertaintyFor("distance:-5,0,0:5,0,0", c), 10e-3 * 20e-6);
  expectStd(uncertaintyFor("distance:-15,1,2:15,1,2", c), 30e-3 * 20e-6);
  EXPECT_LT(uncertaintyFor("distance:3,-5,0:3,5,0", c).quantities[0].std, 1e-12);
  // A calibrated value changes where the machine goes, and not how well that is known.
  c.values[0].value = 300e-6;
  expectStd(uncertaintyFor("distance:-5,0,0:5,0,0", c), 10e-3 * 20e-6);
}

TEST(ClosedForm, SquarenessAloneActsOnADiagonal) {
  Calibration c = bareCalibration({"{type: squareness, axis: x, of: y}"});
  c.covariance(0, 0) = std::pow(30e-6, 2);
  // dL = c * y * dx / L
  expectStd(uncertaintyFor("distance:0,0,0:8,6,0", c), 30e-6 * 6e-3 * 0.8);
  EXPECT_LT(uncertaintyFor("distance:0,0,0:0,0,6", c).quantities[0].std, 1e-12);
}

TEST(ClosedForm, WhiteProbeNoiseOnADistanceAndOnABall) {
  Calibration c = bareCalibration({});
  setNoise(c, 0.4e-6);
  expectStd(uncertaintyFor("distance:0,0,0:10,5,0", c), std::sqrt(2.0) * 0.4e-6);
  for (const int points : {5, 25, 60}) {
    Eigen::MatrixXd design(points, 4);
    for (int i = 0; i < points; ++i)
      design.row(i) << ballDirections(points)[static_cast<std::size_t>(i)].transpose(), 1.0;
    const Eigen::Matrix4d covariance = (design.transpose() * design).inverse() * 0.4e-6 * 0.4e-6;
    const auto task = test::taskOf("ball:0,0,0,4", c, points);
    MonteCarloOptions options;
    options.trials = 40000;
    const TaskUncertainty u = taskUncertainty(*task, VirtualMachine(c, *task, {}), options);
    expectStd(u, 2.0 * std::sqrt(covariance(3, 3)));
    expectStd(u, std::sqrt(covariance(0, 0)), "x");
    expectStd(u, std::sqrt(covariance(2, 2)), "z");
    EXPECT_NEAR(u.quantities[0].mean, 8e-3, 0.03e-6);
  }
}

TEST(ClosedForm, ARingOfContactsAveragesTheirNoise) {
  Calibration c = bareCalibration({});
  setNoise(c, 0.4e-6);
  const TaskUncertainty u = uncertaintyFor("circle:0,0,0:0,0,1:8", c);  // 24 contacts
  expectStd(u, 2.0 * 0.4e-6 / std::sqrt(24.0), "diameter");
  expectStd(u, 0.4e-6 * std::sqrt(2.0 / 24.0), "x");
  EXPECT_THROW(quantity(u, "z"), std::logic_error);  // a circle in its own plane has no place along z
  // Range of 24 normal values about 21 degrees of freedom: 3.895 sigma (Tippett 1925, n = 24) less the fit's
  // part.
  EXPECT_NEAR(quantity(u, "roundness").mean, 3.895 * 0.4e-6 * std::sqrt(21.0 / 24.0), 0.03e-6);
}

TEST(ClosedForm, DriftBetweenTwoPointsIsWhatAnOrnsteinUhlenbeckProcessForgets) {
  Calibration c = bareCalibration({});
  c.drift = {{"x", 0.5e-6, 120.0}};
  TaskConditions conditions;
  conditions.interval = 30.0;
  expectStd(uncertaintyFor("distance:0,0,0:10,0,0", c, conditions),
            0.5e-6 * std::sqrt(2.0 * (1.0 - std::exp(-0.25))));
  const TaskUncertainty at = uncertaintyFor("position:1,2,3", c, conditions);
  EXPECT_EQ(at.quantities[at.headline].quantity.name, "x");
  expectStd(at, 0.5e-6);
  EXPECT_LT(quantity(at, "y").std, 1e-12);
}

TEST(ClosedForm, ASmoothDriftForgetsLessAtFirst) {
  Calibration c = bareCalibration({});
  c.drift = {{"x", 0.5e-6, 120.0, true}};
  TaskConditions conditions;
  conditions.interval = 30.0;
  const double a = std::sqrt(3.0) * 0.25;  // Matern 3/2 (Rasmussen & Williams 2006, 4.17)
  expectStd(uncertaintyFor("distance:0,0,0:10,0,0", c, conditions),
            0.5e-6 * std::sqrt(2.0 * (1.0 - (1.0 + a) * std::exp(-a))));
}

TEST(ClosedForm, TheRemainderOfFarPointsIsIndependentAndOfNearOnesShared) {
  Calibration c = bareCalibration({});
  c.rms = 0.5e-6;
  c.heldOutRms = 0.5e-6;
  c.repeatability = 0.3e-6;  // 0.4 um are left
  TaskConditions conditions;
  conditions.repeatability = 0.0;
  conditions.remainderLength = 0.0;
  expectStd(uncertaintyFor("distance:-15,0,0:15,0,0", c, conditions), std::sqrt(2.0) * 0.4e-6);
  conditions.remainderLength = 1e3;  // half of the variance is common and drops out
  expectStd(uncertaintyFor("distance:-15,0,0:15,0,0", c, conditions), 0.4e-6);
}

TEST(ClosedForm, ArtifactAndTemperature) {
  Calibration c = bareCalibration({"{type: thermal_expansion, axis: x, sensor: bed}"});
  c.values[0].value = 12e-6;
  TaskConditions conditions;
  conditions.artifactScale = 3e-6;
  expectStd(uncertaintyFor("distance:0,0,0:8,6,0", c, conditions), 10e-3 * 3e-6);
  conditions.artifactScale = 0.0;
  conditions.temperatures = {{"bed", 22.0, 0.5}};
  expectStd(uncertaintyFor("distance:-10,0,0:10,0,0", c, conditions), 20e-3 * 12e-6 * 0.5);
  conditions.temperatures = {};
  conditions.artifactRadius = 0.2e-6;
  expectStd(uncertaintyFor("ball:0,0,0,4", c, conditions), 0.4e-6);
  EXPECT_LT(quantity(uncertaintyFor("ball:0,0,0,4", c, conditions), "x").std, 1e-12);
}

TEST(ClosedForm, CorrelatedParametersAddAndTheSharesSumToOne) {
  Calibration c = bareCalibration({"{type: scale, axis: x}", "{type: scale, axis: y}"});
  const double sx = 20e-6, sy = 10e-6, rho = 0.9;
  c.covariance << sx * sx, rho * sx * sy, rho * sx * sy, sy * sy;
  setNoise(c, 0.1e-6);
  const TaskUncertainty u = uncertaintyFor("distance:0,0,0:10,10,0", c);
  const double jx = 10e-3 * std::sqrt(0.5), jy = jx, noise = std::sqrt(2.0) * 0.1e-6;
  const double ofScales = jx * jx * sx * sx + jy * jy * sy * sy + 2.0 * rho * jx * jy * sx * sy;
  expectStd(u, std::sqrt(ofScales + noise * noise));
  const QuantityUncertainty& q = u.quantities[0];
  double sum = 0.0;
  for (const UncertaintyShare& s : q.budget) sum += s.share;
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_NEAR(shareOf(q, "repeatability of the probe"), noise * noise / (ofScales + noise * noise), 0.01);
  // CAR scores: squares of P^1/2 D J', for two parameters in closed form.
  const double a = 0.5 * (std::sqrt(1.0 + rho) + std::sqrt(1.0 - rho)),
               b = 0.5 * (std::sqrt(1.0 + rho) - std::sqrt(1.0 - rho));
  const double ofX = std::pow(a * jx * sx + b * jy * sy, 2) / (ofScales + noise * noise);
  EXPECT_NEAR(shareOf(q, inWords(c.effects[0])), ofX, 0.02);
}

TEST(ClosedForm, IndependentCausesHaveTheSharesOfTheirVariances) {
  Calibration c = bareCalibration({"{type: scale, axis: x}"});
  c.covariance(0, 0) = std::pow(30e-6, 2);  // 0.3 um over 10 mm
  c.drift = {{"x", 1e-6, 5.0}};
  TaskConditions conditions;
  conditions.interval = 1e5;  // forgotten: 1.414 um
  const QuantityUncertainty q = uncertaintyFor("distance:0,0,0:10,0,0", c, conditions).quantities[0];
  EXPECT_EQ(q.budget.front().source, "drift of x");
  EXPECT_NEAR(q.budget.front().share, 2.0 / 2.09, 0.01);
}

TEST(ClosedForm, FewDegreesOfFreedomMakeItStudentsT) {
  Calibration c = bareCalibration({"{type: scale, axis: x}"});
  c.covariance(0, 0) = std::pow(20e-6, 2);
  c.degreesOfFreedom = 8;
  const TaskUncertainty u = uncertaintyFor("distance:-5,0,0:5,0,0", c);
  EXPECT_NEAR(u.quantities[0].std, 0.2e-6 * std::sqrt(8.0 / 6.0), 0.03 * 0.2e-6);
  EXPECT_NEAR(u.quantities[0].upper - 10e-3, 2.306 * 0.2e-6, 0.03 * 0.4e-6);  // t of 8, 97.5 %
}

// An effect that is not linear goes through the whole model in every trial.
TEST(ClosedForm, ANonlinearEffectIsNotLinearised) {
  Calibration c = bareCalibration({"{type: lead_screw_periodic, axis: x, period_mm: unknown}"});
  for (Calibration::Value& v : c.values)
    if (v.name == "S") v.value = 5e-6;
  for (std::size_t k = 0; k < c.values.size(); ++k)
    if (c.values[k].name == "period") {
      c.values[k].value = 4e-3;
      c.covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)) = std::pow(1e-6, 2);
    }
  // S sin(2 pi x / p) at x = 0 and 8 mm: slope by p is -S 2 pi x / p^2
  expectStd(uncertaintyFor("distance:0,0,0:8,0,0", c), 5e-6 * 2.0 * kPi * 8e-3 / std::pow(4e-3, 2) * 1e-6);
}

TEST(ClosedForm, DirectionOfTravelCountsWhereThereIsPlay) {
  Calibration c = bareCalibration({"{type: backlash, axis: x}"});
  c.covariance(0, 0) = std::pow(0.6e-6, 2);
  EXPECT_LT(uncertaintyFor("distance:0,0,0:10,0,0", c).quantities[0].std, 1e-12);  // both from the same side
  expectStd(uncertaintyFor("position:1,0,0", c), 0.3e-6);
  // A length between outer faces is approached from both sides.
  const TaskUncertainty ring = uncertaintyFor("circle:0,0,0:0,0,1:8", c);
  EXPECT_GT(quantity(ring, "diameter").std, 0.2e-6);
}

TEST(Trials, AreStableInTheDigitsThatWereAskedAndDoNotDependOnThreads) {
  Calibration c = bareCalibration({"{type: scale, axis: x}"});
  c.covariance(0, 0) = std::pow(20e-6, 2);
  setNoise(c, 0.1e-6);
  const auto task = test::taskOf("distance:0,0,0:10,0,0", c);
  const VirtualMachine machine(c, *task, {});
  MonteCarloOptions options;
  TaskUncertainty one, two, other;
  Threads(1).run([&] { one = taskUncertainty(*task, machine, options); });
  Threads(2).run([&] { two = taskUncertainty(*task, machine, options); });
  EXPECT_TRUE(one.stable);
  EXPECT_EQ(one.trials % 10000, 0U);
  EXPECT_GE(one.trials, 50000U);
  EXPECT_EQ(one.trials, two.trials);
  EXPECT_EQ(one.quantities[0].std, two.quantities[0].std);
  EXPECT_EQ(one.quantities[0].mean, two.quantities[0].mean);
  options.seed = 2;
  Threads(2).run([&] { other = taskUncertainty(*task, machine, options); });
  EXPECT_NE(one.quantities[0].std, other.quantities[0].std);
  EXPECT_NEAR(one.quantities[0].std, std::sqrt(0.2 * 0.2 + 0.02) * 1e-6, 0.005e-6);
  options.most = 20000;  // not enough for two digits of 0.24
  EXPECT_FALSE(taskUncertainty(*task, machine, options).stable);
}

TEST(Task, OutsideTheCalibratedVolumeItIsSaid) {
  const Calibration c = bareCalibration({"{type: scale, axis: x}"});
  const TaskUncertainty u = uncertaintyFor("distance:0,0,0:30,0,0", c, {}, 1000);
  ASSERT_EQ(u.outside.size(), 1U);
  EXPECT_NE(u.outside[0].find("x = 30 mm"), std::string::npos) << u.outside[0];
  EXPECT_TRUE(uncertaintyFor("distance:0,0,0:20,0,0", c, {}, 1000).outside.empty());
}

TEST(Task, AParameterThatIsNotDeterminedIsRefusedByName) {
  Calibration c = bareCalibration({"{type: scale, axis: x}"});
  c.covariance(0, 0) = std::numeric_limits<double>::infinity();
  try {
    uncertaintyFor("distance:0,0,0:10,0,0", c);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("'scale' has no finite standard uncertainty"), std::string::npos)
        << e.what();
  }
}

TEST(Task, MalformedTasksAreRefusedInOneLine) {
  const Calibration c = bareCalibration({});
  const std::pair<const char*, const char*> cases[] = {
      {"distance:0,0,0:0,0,0", "the length is zero"},
      {"distance:0,0,0", "needs 2"},
      {"distance:0,0:1,1,1", "needs 3"},
      {"distance:0,0,nan:1,1,1", "'nan'"},
      {"distance:0,0,inf:1,1,1", "'inf'"},
      {"distance:0,0,:1,1,1", "''"},
      {"distanz:0,0,0:1,1,1", "did you mean 'distance'"},
      {"", "is not a task"},
      {"ball:0,0,0,-1", "not above zero"},
      {"ball:0,0,0,1,2", "needs 3 or 4"},
      {"plane:0,0,0:0,0,0:5", "not a direction"},
      {"roundness:0,0,0:0,0,1", "needs 3"},
      {"straightness:0,0,0:1,0,0:1,0,0", "lies along the line"},
      {"iso10360-2:x", "needs 0"},
      {"iso230-2:w", "is not a linear axis"},
      {"position:1e9,0,0", "'1e9'"}};
  for (const auto& [text, part] : cases) {
    try {
      test::taskOf(text, c);
      ADD_FAILURE() << text;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace mm
