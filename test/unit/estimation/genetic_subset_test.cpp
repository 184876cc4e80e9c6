#include "estimation/genetic_subset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>

#include "base/error.h"

namespace mm {
namespace {

using Subset = std::vector<std::size_t>;

/// A score in which items help and disturb each other in pairs.
class PairScore {
 public:
  PairScore(std::size_t items, unsigned seed) : items_(items), table_(items * items) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    for (double& value : table_) value = normal(generator);
  }
  double operator()(const Subset& chosen) const {
    double sum = 0.0;
    for (std::size_t a : chosen)
      for (std::size_t b : chosen) sum += table_[a * items_ + b];
    return sum;
  }

 private:
  std::size_t items_;
  std::vector<double> table_;
};

double bestOfAll(std::size_t items, std::size_t choose, const PairScore& score) {
  double best = -1e300;
  std::vector<bool> mask(items, false);
  std::fill(mask.begin(), mask.begin() + static_cast<std::ptrdiff_t>(choose), true);
  do {
    Subset subset;
    for (std::size_t i = 0; i < items; ++i)
      if (mask[i]) subset.push_back(i);
    best = std::max(best, score(subset));
  } while (std::prev_permutation(mask.begin(), mask.end()));
  return best;
}

TEST(Subset, findsTheBestOfBruteForce) {
  int found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const PairScore score(20, seed);
    SubsetSettings settings;
    settings.seed = seed;
    const SubsetResult result = bestSubset(20, 5, score, settings);  // of 15,504
    EXPECT_DOUBLE_EQ(score(result.items), result.score);
    if (result.score > bestOfAll(20, 5, score) - 1e-9) ++found;
  }
  EXPECT_GE(found, 18) << "of 20";
}

TEST(Subset, allItemsAreASubset) {
  EXPECT_EQ(bestSubset(6, 6, PairScore(6, 1)).items, (Subset{0, 1, 2, 3, 4, 5}));
}

TEST(Subset, scoresEachSubsetOnceAndOnlyValidOnes) {
  std::set<Subset> seen;
  std::size_t calls = 0;
  const PairScore inner(30, 5);
  const SubsetResult result = bestSubset(30, 6, [&](const Subset& subset) {
    ++calls;
    EXPECT_TRUE(seen.insert(subset).second);
    EXPECT_EQ(subset.size(), 6u);
    EXPECT_TRUE(std::is_sorted(subset.begin(), subset.end()));
    EXPECT_EQ(std::adjacent_find(subset.begin(), subset.end()), subset.end());
    EXPECT_LT(subset.back(), 30u);
    return inner(subset);
  });
  EXPECT_EQ(result.evaluations, calls);
  EXPECT_TRUE(std::is_sorted(result.curve.begin(), result.curve.end()));
}

TEST(Subset, sameSeedSameChoice) {
  const PairScore score(40, 8);
  SubsetSettings settings;
  settings.seed = 4;
  const SubsetResult a = bestSubset(40, 7, score, settings), b = bestSubset(40, 7, score, settings);
  EXPECT_EQ(a.items, b.items);
  EXPECT_EQ(a.evaluations, b.evaluations);
  EXPECT_EQ(a.curve, b.curve);
}

TEST(Subset, cancelKeepsTheBestSoFar) {
  const PairScore score(40, 8);
  std::size_t generations = 0;
  GeneticControl control;
  control.progress = [&](const GeneticProgress&) { ++generations; };
  control.cancelled = [&] { return generations == 3; };
  const SubsetResult result = bestSubset(40, 7, score, {}, control);
  EXPECT_TRUE(result.cancelled);
  EXPECT_EQ(result.curve.size(), 3u);
  EXPECT_EQ(result.items.size(), 7u);
}

TEST(Subset, badInputIsRefused) {
  const PairScore score(10, 1);
  EXPECT_THROW(bestSubset(10, 0, score), InputError);
  EXPECT_THROW(bestSubset(10, 11, score), InputError);
  SubsetSettings settings;
  settings.mutation = 2.0;
  EXPECT_THROW(bestSubset(10, 2, score, settings), InputError);
  EXPECT_THROW(bestSubset(10, 2, [](const Subset&) { return std::numeric_limits<double>::quiet_NaN(); }),
               NumericalError);
}

}  // namespace
}  // namespace mm
