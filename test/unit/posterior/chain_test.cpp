// The samples of a chain against sums over every state of a small problem.
#include "posterior/chain.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "base/error.h"
#include "posterior_support.h"

using namespace mm;

namespace {

/// Every set: of each cause nothing, or one of its shapes at one of the sizes.
std::vector<ActingSet> everySet(const PosteriorProblem& problem) {
  std::vector<ActingSet> all = {{}};
  for (const Cause& c : problem.causes) {
    std::vector<ActingSet> more;
    for (const ActingSet& set : all)
      for (int s = c.first; s < c.end; ++s)
        for (int k = 0; k < kSizes; ++k) {
          more.push_back(set);
          more.back().push_back({s, k});
        }
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

struct Exact {
  std::vector<double> inclusion;
  double walking = 0.0;  // probability of the second state of the noise
};

Exact exactOf(const PosteriorProblem& problem, const NoisePool& pool) {
  const std::vector<ActingSet> sets = everySet(problem);
  Exact exact;
  exact.inclusion.assign(problem.causes.size(), 0.0);
  double sum = 0.0, most = -1e300;
  for (const auto& view : pool) most = std::max(most, view->logDensity({}));
  for (std::size_t v = 0; v < pool.size(); ++v)
    for (const ActingSet& set : sets) {
      const double weight = std::exp(pool[v]->logDensity(set) - most);
      sum += weight;
      for (const Acting& a : set) exact.inclusion[problem.shapes[a.shape].cause] += weight;
      if (v == 1) exact.walking += weight;
    }
  for (double& p : exact.inclusion) p /= sum;
  exact.walking /= sum;
  return exact;
}

}  // namespace

TEST(NoiseView, DensityIsThatOfDenseMatrices) {
  const SmallProblem small(3);
  const ActingSet sets[] = {{}, {{0, 5}}, {{0, 7}, {2, 4}}, {{1, 2}, {3, 12}}};
  for (const NoiseState& noise : {small.plain(), small.walking()}) {
    const NoiseView view(small.problem, noise);
    const double offset = view.logDensity({}) - small.brute(noise, {});
    EXPECT_NEAR(offset, 0.0, 1e-5);
    for (const ActingSet& set : sets) EXPECT_NEAR(view.logDensity(set), small.brute(noise, set), 1e-5);
  }
}

TEST(NoiseView, ConditionalsSumShapesAndSizesGivenTheOthers) {
  const SmallProblem small(4);
  const NoiseView view(small.problem, small.walking());
  const ActingSet set = {{0, 6}, {3, 3}};
  const Conditionals look = *view.look(set);
  for (int c = 0; c < 3; ++c) {
    ActingSet others;
    for (const Acting& a : set)
      if (small.problem.shapes[a.shape].cause != c) others.push_back(a);
    double sum = 0.0;
    for (int s = small.problem.causes[c].first; s < small.problem.causes[c].end; ++s)
      for (int k = 0; k < kSizes; ++k) {
        ActingSet with = others;
        with.push_back({s, k});
        const double ratio = view.logDensity(with) - view.logDensity(others);
        EXPECT_NEAR(look.logWeights(s, k), ratio, 1e-8) << c << " " << s << " " << k;
        sum += std::exp(ratio);
      }
    EXPECT_NEAR(look.logOdds[c], std::log(sum), 1e-8);
  }
}

// So many causes that what is kept is given up again and again.
TEST(NoiseView, WhatIsKeptIsWhatAFreshViewSays) {
  constexpr int kMore = 100;
  const SmallProblem small(4);
  PosteriorProblem many = small.problem;
  many.columns.conservativeResize(Eigen::NoChange, 7 + kMore);
  many.columns.rightCols(kMore) = RowMatrix::Random(SmallProblem::kRows, kMore);
  for (int k = 0; k < kMore; ++k) {
    CauseShape shape = many.shapes.front();
    shape.cause = static_cast<int>(many.causes.size());
    shape.first = 7 + k;
    shape.count = 1;
    const auto at = static_cast<int>(many.shapes.size());
    many.shapes.push_back(shape);
    many.causes.push_back({std::log(0.3), at, at + 1});
  }
  const NoiseView view(many, small.walking());
  const std::vector<ActingSet> sets = everySet(small.problem);
  EXPECT_EQ(view.look(sets[1]), view.look(sets[1])) << "asked again it is the same answer";
  const auto before = view.look(sets[1]);
  for (std::size_t i = 0; i < 1000; ++i) view.look(sets[i]);
  EXPECT_NE(view.look(sets[1]), before) << "what was asked long ago is not kept";
  for (std::size_t i = 1; i < 1000; i += 90) {
    const auto kept = view.look(sets[i]), fresh = NoiseView(many, small.walking()).look(sets[i]);
    EXPECT_EQ(kept->logOdds, fresh->logOdds) << i;
    EXPECT_TRUE((kept->logWeights == fresh->logWeights).all()) << i;
  }
}

// One cause that is no number would make every probability of the sample none, and nothing be named.
TEST(NoiseView, ACauseWhoseEvidenceIsNoNumberEndsTheSample) {
  const SmallProblem small(5);
  PosteriorProblem broken = small.problem;
  broken.columns(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(NoiseView(small.problem, small.plain()).look({}));
  EXPECT_THROW(NoiseView(broken, small.plain()).look({}), NumericalError);
}

TEST(PosteriorChain, ItsSamplesAreThoseOfThePosterior) {
  const std::vector<double> often = {std::log(0.8), std::log(0.2)}, seldom = {std::log(0.3), std::log(0.7)};
  const std::vector<Mode> modes = {{{{0, 3}}, often}, {{{2, 5}}, seldom}, {{{0, 4}, {3, 6}}, often}};
  for (const unsigned seed : {1u, 2u, 5u, 8u}) {
    const SmallProblem small(seed, 0.35);
    const NoisePool pool = {std::make_shared<NoiseView>(small.problem, small.plain()),
                            std::make_shared<NoiseView>(small.problem, small.walking())};
    const Exact exact = exactOf(small.problem, pool);
    PosteriorChain chain(small.problem, pool, 0, 1, 0);
    if (seed > 2) chain.setModes(modes);
    std::vector<Visit> visits;
    chain.run(20000, &visits);
    double sum = 0.0, walking = 0.0;
    std::vector<double> inclusion(3, 0.0), visited(3, 0.0);
    for (const Visit& v : visits) {
      const double weight = std::exp(v.logWeight);
      sum += weight;
      walking += weight * v.noise;
      for (int c = 0; c < 3; ++c) inclusion[c] += weight * v.inclusion[c];
      for (const Acting& a : v.set) visited[small.problem.shapes[a.shape].cause] += weight;
    }
    EXPECT_NEAR(walking / sum, exact.walking, 0.02) << seed;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(inclusion[c] / sum, exact.inclusion[c], 0.01) << seed << " " << c;
      EXPECT_NEAR(visited[c] / sum, exact.inclusion[c], 0.03) << seed << " " << c;  // without Rao-Blackwell
    }
  }
}

// Two backlashes and two harmonics of a probe's lobing do the same together, and no one of one pair does what
// one of the other does: between them lies nothing that is likely.
TEST(PosteriorChain, JumpsBetweenSetsThatDoTheSameTogether) {
  SmallProblem small(2);
  PosteriorProblem& problem = small.problem;
  problem.columns.col(3) = problem.columns.col(0) + problem.columns.col(1) - problem.columns.col(2);
  problem.rows.target += 12.0 * (problem.columns.col(0) + problem.columns.col(1));
  problem.shapes.clear();
  problem.causes.clear();
  for (int c = 0; c < 4; ++c) {
    CauseShape shape;
    shape.cause = shape.first = c;
    shape.count = 1;
    shape.logPrior = Sizes::Constant(-std::log(double(kSizes)) - (c < 2 ? 0.3 : 0.0));
    problem.shapes.push_back(shape);
    problem.causes.push_back({-12.0, c, c + 1});
  }
  const NoisePool pool = {std::make_shared<NoiseView>(problem, small.plain())};
  const Exact exact = exactOf(problem, pool);
  ASSERT_GT(std::min(exact.inclusion[0], exact.inclusion[2]), 0.1) << "both pairs are likely";
  const ActingSet one = {{0, 9}, {1, 9}}, other = {{2, 9}, {3, 9}};
  PosteriorChain chain(problem, pool, 0, 1, 0, 0, one);
  chain.setModes({{one, {0.0}}, {other, {0.0}}});
  std::vector<Visit> visits;
  chain.run(2000, &visits);
  double sum = 0.0;
  std::vector<double> inclusion(4, 0.0);
  for (const Visit& v : visits) {
    sum += std::exp(v.logWeight);
    for (int c = 0; c < 4; ++c) inclusion[c] += std::exp(v.logWeight) * v.inclusion[c];
  }
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(inclusion[c] / sum, exact.inclusion[c], 0.03) << c;
}

// A guideway that pitches turns about a place of its own: the squareness beside it is no second cause, unless
// it is larger than such a place makes it.
TEST(PosteriorChain, WhatAnotherCauseHasAsAPartIsACauseOfItsOwnOnlyWhereItIsLarger) {
  const auto probabilityOf = [](double coefficient, bool isPart) {
    SmallProblem small(3, 3.0);  // the first cause, at three times the noise
    small.problem.rows.target += coefficient * small.problem.columns.col(2);
    if (isPart) small.problem.causes[1].partOf = {{0, 0.15}};
    const NoisePool pool = {std::make_shared<NoiseView>(small.problem, small.plain())};
    PosteriorChain chain(small.problem, pool, 0, 1, 0);
    std::vector<Visit> visits;
    chain.run(2000, &visits);
    double sum = 0.0, acts = 0.0;
    for (const Visit& v : visits) {
      sum += std::exp(v.logWeight);
      acts += std::exp(v.logWeight) * v.inclusion[1];
    }
    return acts / sum;
  };
  EXPECT_GT(probabilityOf(0.8, false), 0.9);
  EXPECT_LT(probabilityOf(0.8, true), 0.5);
  EXPECT_GT(probabilityOf(3.0, true), 0.95);
}
