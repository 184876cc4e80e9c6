#pragma once
#include <set>
#include <vector>

#include "posterior/sample.h"

namespace mm {

/// A place in the answer: causes of which one acts, likeliest first.
struct Slot {
  std::vector<int> causes;
  std::vector<double> shares;  // a cause: probability that it acts
  double probability = 0.0;    // that one of them acts
  bool named = false;          // it is sure enough to be said
};

constexpr double kNamed = 0.99;  // probability at which a cause, or a set of rivals, is named

/// A cause that is not named and has at least this probability is told: it cannot be excluded.
constexpr double kPossible = 0.1;

/// Share of named causes that were right: no catalogue has every law. Of 834 causes that were named at
/// the then bound in 800 sessions by other physics 794 were hidden (scripts/judge; 0.952, 95 % interval 0.935
/// to 0.966).
constexpr double kOfThisWorld = 0.95;

/// Which causes are named (the verdict that follows is diagnosis/verdict.h). The likeliest cause that is not
/// used gets rivals, each the one that acts in most of what is left, until one of them is sure to act; where
/// that is not reached its causes may act. @param doubted causes that get no slot and are nobody's rival.
std::vector<Slot> slotsOf(const PosteriorSample& sample, const std::set<int>& doubted = {});

/// The shape of a cause that has most of its probability, and its size there. @return shape -1: it was never
/// visited.
Acting shapeOf(const PosteriorSample& sample, const PosteriorProblem& problem, int cause);

/// A probability of the sample as it is printed: bounded by the number of samples, and times the share of
/// named causes that were right.
double odds(const PosteriorSample& sample, double probability);

}  // namespace mm
