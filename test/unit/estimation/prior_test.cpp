// What is known of a parameter before the session counts by its weight beside what the session says.
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/calibrate.h"
#include "model/observed_domain.h"
#include "session/plan.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

class PriorTest : public testing::Test {
 protected:
  PriorTest() {
    const Machine machine = Machine::load("three_axis");
    SimulationRequest request;
    request.hide = {"backlash:x=3um"};
    request.seed = 4;
    session_ = simulate(machine, Plan::load("config/demo_plan.yaml", machine), request).session;
  }
  CalibrationResult fitted(const std::vector<ParameterPrior>& prior,
                           Method method = Method::kLeastSquares) const {
    CalibrateOptions options;
    options.method = method;
    options.rejectOutliers = false;
    options.whiteNoise = true;
    options.repeatability = 0.3e-6;
    options.prior = prior;
    options.stagedMutation.population = 100;
    options.stagedMutation.generations = 40;
    const std::vector<EffectSpec> effects{EffectSpec("backlash").set("axis", "x"),
                                          EffectSpec("scale").set("axis", "x")};
    return calibrate(session_, Model(session_.machine, observedDomain(session_), effects), options);
  }
  Session session_{Machine::load("three_axis")};
};

TEST_F(PriorTest, countsByItsWeight) {
  const CalibrationResult data = fitted({});
  // the covariance is scaled by the residuals' variance, the prior stands beside the declared one
  const double declared = data.std(0) / std::sqrt(data.figures.chi2PerDof);
  const double mean = data.x[0] + 4.0 * declared;
  const CalibrationResult both = fitted({{0, mean, declared}});
  EXPECT_NEAR(both.x[0], 0.5 * (data.x[0] + mean), 0.02 * declared);
  EXPECT_LT(both.std(0), 0.85 * data.std(0));
  EXPECT_GT(both.std(0), 0.6 * data.std(0));
}

TEST_F(PriorTest, thatSaysNothingChangesNothing) {
  const CalibrationResult data = fitted({}), both = fitted({{0, 1.0, 1e3}});
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(both.x[i], data.x[i], 1e-3 * data.std(i));
}

TEST_F(PriorTest, thatIsSureIsBelieved) {
  const CalibrationResult sure = fitted({{1, 100e-6, 1e-12}});
  EXPECT_NEAR(sure.x[1], 100e-6, 1e-10);
}

TEST_F(PriorTest, isTheSameToTheGeneticAlgorithm) {
  const CalibrationResult data = fitted({});
  const std::vector<ParameterPrior> prior{{0, data.x[0] + 6.0 * data.std(0), data.std(0)}};
  const CalibrationResult descent = fitted(prior), genetic = fitted(prior, Method::kStagedMutation);
  EXPECT_NEAR(genetic.x[0], descent.x[0], 1e-3 * data.std(0));
}

}  // namespace
}  // namespace mm
