#include "posterior/sample.h"

#include <gtest/gtest.h>

#include "base/parallel.h"
#include "posterior/slots.h"
#include "posterior_support.h"

using namespace mm;

namespace {

PosteriorSample drawn(const PosteriorProblem& problem, unsigned threads) {
  PosteriorSample out;
  SampleOptions options;
  Threads(threads).run(
      [&] { out = samplePosterior(problem, Eigen::VectorXd::Ones(problem.rows.rows()), options); });
  return out;
}

}  // namespace

TEST(PosteriorSample, FindsWhatActsAndNothingElse) {
  const SmallProblem small(2, 1.0, 2);  // the one column of the second cause
  const PosteriorSample sample = drawn(small.problem, 2);
  EXPECT_TRUE(sample.settled) << sample.disagreement;
  EXPECT_GT(sample.inclusion[1], 0.99);
  EXPECT_LT(sample.inclusion[0], 0.3);
  EXPECT_LT(sample.inclusion[2], 0.3);
  EXPECT_EQ(shapeOf(sample, small.problem, 1).shape, 1);
}

TEST(PosteriorSample, TwoThatResembleEachOtherShareOneProbability) {
  const SmallProblem small(2, 1.0);  // a column that another cause nearly has
  const PosteriorSample sample = drawn(small.problem, 2);
  EXPECT_GT(sample.inclusion[0], 0.2);
  EXPECT_GT(sample.inclusion[2], 0.2);
  EXPECT_NEAR(sample.inclusion[0] + sample.inclusion[2], 1.0, 0.15);
}

TEST(PosteriorSample, TheBitsDoNotDependOnTheThreads) {
  const SmallProblem small(6, 0.4);
  const PosteriorSample one = drawn(small.problem, 1), two = drawn(small.problem, 2);
  ASSERT_EQ(one.visits.size(), two.visits.size());
  EXPECT_EQ(one.inclusion, two.inclusion);
  EXPECT_EQ(one.weights, two.weights);
}

TEST(PosteriorSample, ThePlainStatesOfTheNoiseAreInThePool) {
  const SmallProblem small(2);
  const std::vector<NoiseState> states =
      plainStates(small.problem, Eigen::VectorXd::Ones(SmallProblem::kRows));
  EXPECT_TRUE(states.front().drift.empty());
  std::size_t drifting = 0, scattering = 0;
  for (const NoiseState& s : states) drifting += !s.drift.empty(), scattering += s.scatter[0] > 0.0;
  EXPECT_EQ(drifting, 12u);  // six time constants, small and large
  EXPECT_GE(scattering, 2u);
}
