#pragma once
#include <cstdint>
#include <vector>

#include "posterior/chain.h"

namespace mm {

/// Where a chain may begin.
struct PosteriorStart {
  ActingSet set;
  NoiseState noise;
};

struct SampleOptions {
  int chains = 2;       // beside each other
  int warmUp = 25;      // steps before each fit of the noise beside what was found
  int fits = 2;         // of the noise beside what was found
  int steps = 120;      // of a chain, that are read
  int mostRounds = 32;  // of so many steps, until the chains agree
  std::uint64_t seed = 1;
  std::vector<PosteriorStart> starts;  // chains begin at the last ones; of none: where nothing acts
};

/// What was drawn from the posterior. Everything that a diagnosis says is a marginal of it.
struct PosteriorSample {
  NoisePool pool;
  std::vector<Visit> visits;      // of all chains
  std::vector<double> weights;    // a visit, of sum 1; each chain has the same in all
  std::vector<double> inclusion;  // a cause: probability that it acts
  double disagreement = 0.0;      // largest difference of an inclusion between two chains
  bool settled = false;           // it is small

  /// The set and noise of greatest density that were visited.
  ActingSet best;
  int bestNoise = 0;
};

/// Chains agree where no inclusion differs by more.
constexpr double kAgree = 0.02;

/// Draws from the posterior of a problem. The same seed gives the same bits, on any number of threads.
PosteriorSample samplePosterior(const PosteriorProblem& problem, const Eigen::VectorXd& variance,
                                const SampleOptions& options);

/// States of the noise with which a pool begins: none, each kind alone, small and large; what is not in the
/// pool cannot win. @param variance a data row.
std::vector<NoiseState> plainStates(const PosteriorProblem& problem, const Eigen::VectorXd& variance);
/// Which terms of the noise there are, and their sizes, or the sizes of the scatter alone.
enum class NoiseTerms { kFitted, kAsTheyAre };
/// The noise fitted beside a set, from a state.
NoiseState fittedBeside(const PosteriorProblem& problem, const ActingSet& set, const NoiseState& start,
                        NoiseTerms terms = NoiseTerms::kFitted);
/// Smooth where the drift was rough, and rough where it was smooth: a fit takes one of them, and beside other
/// causes the other may be the likelier.
NoiseState ofOtherKernel(NoiseState state);

}  // namespace mm
