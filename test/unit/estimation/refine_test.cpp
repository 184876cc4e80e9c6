#include "estimation/refine.h"

#include <gtest/gtest.h>

#include "estimation/identifiability.h"
#include "mmt_session.h"

namespace mm {
namespace {

constexpr double kRefinedNoise = 0.5e-6;  // m

/// The contacts of MMT: 70 balls of unknown centre, made by the plain formula of the paper.
class Refine : public testing::Test {
 protected:
  RefineResult refined(const Eigen::VectorXd& weight, const RefineProgress& progress = {}) const {
    return refine(problem, start, fixed, sigma, weight, progress);
  }

  const mm_test::MmtContacts data{17, 40e-6, kRefinedNoise};
  const Session session = mm_test::mmtSession(data, kRefinedNoise);
  const Problem problem{session, mm_test::mmtModel(session)};
  const Eigen::VectorXd start = problem.start(), sigma = problem.sigmas(kRefinedNoise, kRefinedNoise);
  const std::vector<char> fixed = identify(problem, start, sigma.cwiseInverse(), true).fixed;
  const Eigen::VectorXd all = Eigen::VectorXd::Ones(problem.rowCount());
};

// Two rows of a ball whose three coordinates are free fit whatever they say: they tell nothing, and disturb
// nothing. Which of their rows have a weight, and whether those stand before or behind the others, is chance.
TEST_F(Refine, AFeatureWithTooFewRowsTellsNothingAndDisturbsNothing) {
  std::vector<int> ofBall;
  for (int i = 0; i < problem.rowCount(); ++i)
    if (session
            .observations[static_cast<std::size_t>(problem.rows()[static_cast<std::size_t>(i)].observation)]
            .feature == 0)
      ofBall.push_back(i);
  Eigen::VectorXd weight = all;
  for (const int i : ofBall) weight[i] = 0.0;
  const RefineResult without = refined(weight);
  ASSERT_TRUE(without.converged);
  const int ball = problem.find(UnknownKind::kFeature, 0);
  EXPECT_EQ(without.x.segment<3>(ball), start.segment<3>(ball));
  for (const std::size_t first : {std::size_t{0}, ofBall.size() - 2}) {
    Eigen::VectorXd two = weight;
    two[ofBall[first]] = two[ofBall[first + 1]] = 1.0;
    const RefineResult with = refined(two);
    EXPECT_TRUE(with.x.allFinite());
    const int count = problem.model().parameterCount();
    for (int p = 0; p < count; ++p) {
      const double scale = problem.unknowns()[static_cast<std::size_t>(p)].scale;
      EXPECT_NEAR(with.x[p] / scale, without.x[p] / scale, 1e-6) << p;
    }
    EXPECT_LT((with.x.segment<3>(ball) - start.segment<3>(ball)).norm(), 1e-3);
  }
}

TEST_F(Refine, StopsWhereItIsAsked) {
  const RefineResult stopped = refined(all, [](int iteration, double) { return iteration < 1; });
  EXPECT_TRUE(stopped.cancelled);
  EXPECT_FALSE(stopped.converged);
  EXPECT_EQ(stopped.stop, "cancelled");
  EXPECT_LT(problem.residuals(stopped.x).norm(), problem.residuals(start).norm());
}

}  // namespace
}  // namespace mm
