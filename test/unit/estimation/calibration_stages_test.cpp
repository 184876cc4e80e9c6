// Each stage of a calibration alone: what it is given, and what it gives.
#include "estimation/calibration_stages.h"

#include <gtest/gtest.h>

#include <cmath>

#include "deviations.h"
#include "effects/effect.h"
#include "estimation/robust.h"
#include "model/observed_domain.h"
#include "random_numbers.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

struct Plate {
  Machine machine = Machine::load("three_axis");
  int gross = 100;  // the contact with a gross error: one along x
  Simulation simulation = [this] {
    Simulation s = simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), {{}, 5, ""});
    auto& contacts = s.session.observations;
    while (!(std::abs(contacts[gross].approach.x()) > 0.7)) ++gross;
    contacts[gross].position[0] += 50e-6;
    return s;
  }();
  CalibrateOptions options = [] {
    CalibrateOptions o;
    o.method = Method::kLeastSquares;
    return o;
  }();
  Model model{machine, observedDomain(simulation.session),
              std::vector<EffectSpec>{EffectSpec("scale").set("axis", "x")}};
  Statement statement =
      stated(simulation.session, withNetworks(simulation.session, model, options, {}), options, Datum::kFree);
  FitTask task{*statement.problem, statement.identifiability.fixed, options};
  Fit start = fitFrom(task, startValues(statement, options, false).x, statement.noise);
};

TEST(CalibrationStages, TheStatementUsesEveryRowAndTheDeclaredNoise) {
  const Plate plate;
  EXPECT_EQ(plate.statement.weight.minCoeff(), 1.0);
  EXPECT_EQ(plate.statement.noise.from, "declared");
  EXPECT_EQ(plate.statement.sigma.maxCoeff(), plate.simulation.session.artifact.repeatability);
  EXPECT_EQ(plate.statement.identifiability.rank, 1);
}

TEST(CalibrationStages, RefiningAloneIsBentByAGrossErrorAndTheOutliersStageLeavesItOut) {
  const Plate plate;
  const int row = plate.statement.problem->firstRow(plate.gross);
  const Fit bent = refined(plate.task, plate.start);
  EXPECT_TRUE(bent.converged);
  EXPECT_EQ(bent.weight[row], 1.0);
  const Fit soft = softened(plate.task, bent);
  EXPECT_GT(soft.weight[row], 0.0);
  EXPECT_LT(soft.weight[row], 0.1);
  EXPECT_GT(std::abs(soft.residuals[row]), std::abs(bent.residuals[row]));
  const Eigen::VectorXd weight = weightsWithoutOutliers(plate.task, soft);
  EXPECT_EQ(weight[row], 0.0);
  EXPECT_EQ(weight.sum(), static_cast<double>(weight.size() - 1));
  const Fit all = fitted(plate.task, plate.start);
  EXPECT_EQ(all.weight, weight);
}

TEST(CalibrationStages, AStageDoesNotChangeWhatItWasGiven) {
  const Plate plate;
  const Eigen::VectorXd x = plate.start.x;
  const Fit after = refined(plate.task, plate.start);
  EXPECT_EQ(plate.start.x, x);
  EXPECT_EQ(plate.start.residuals.size(), 0);
  bool moved = true;
  const Noise noise = estimatedNoise(plate.task, after, &moved);
  EXPECT_FALSE(moved);  // one kind of rows, its noise declared
  EXPECT_EQ(noise.linear, after.noise.linear);
}

TEST(CalibrationStages, TogetherTheyAreTheCalibration) {
  const Plate plate;
  const CalibrationResult result = calibrate(plate.simulation.session, plate.model, plate.options);
  const Fit fit = fitted(plate.statement, startValues(plate.statement, plate.options, false), plate.options);
  EXPECT_EQ(result.x, fit.x);
  EXPECT_EQ(result.weight, fit.weight);
  const Uncertainty u = uncertaintyOf(*plate.statement.problem, fit, plate.task.fixed, false);
  EXPECT_EQ(result.covariance, u.covariance);
  EXPECT_EQ(result.heldOut, u.heldOut);
  EXPECT_EQ(repeatabilityOf(*plate.statement.problem, fit, u.dof).value, result.repeatability);
}

TEST(OutlyingLimit, IsNineAndStudentsQuantileWhereFewFreedomsSayHowLargeTheBulkIs) {
  EXPECT_EQ(outlyingLimit(600), 9.0);
  EXPECT_NEAR(outlyingLimit(5), 113.655, 0.001);  // two-sided 1e-9
  EXPECT_GT(outlyingLimit(1), 1e8);
  EXPECT_NEAR(robustSigma({-1.0, 1.0, 1.0, -1.0}), 1.4826, 1e-4);
  EXPECT_EQ(robustSigma({}), 0.0);
}

/// An instrument that reads to 1 um, of deviations that are mostly smaller than half of it: the bulk reads 0.
/// Every reading that was not 0 was an outlier, and the noise nothing.
TEST(Outliers, AreNotWhatTheResolutionShows) {
  Session session(Machine::load("three_axis"));
  session.source = "test";
  test_support::RandomNumbers random(7);
  for (int i = 0; i < 90; ++i) {
    Observation o = test_support::deviationOfX((i % 15 - 7) * 2.5e-3, i / 15 % 2 == 0 ? 5e-3 : -5e-3, i,
                                               std::round(random.normal(0.35)) * 1e-6);
    o.row = i + 2;
    session.observations.push_back(o);
  }
  session.prepare();
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  const Model model(session.machine, observedDomain(session), std::vector<EffectPtr>());
  const CalibrationResult fit = calibrate(session, model, options);
  EXPECT_TRUE(fit.outliers.empty()) << fit.outliers.size();
  EXPECT_GT(fit.repeatability, 0.2e-6);
  EXPECT_NEAR(resolutionSigma(*fit.problem)[0], 1e-6 / std::sqrt(12.0), 1e-12);

  session.observations[40].deviation[0] = 30e-6;  // one is
  EXPECT_EQ(calibrate(session, model, options).outliers.size(), 1u);
}

}  // namespace
}  // namespace mm
