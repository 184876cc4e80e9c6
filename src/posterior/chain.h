#pragma once
#include <map>
#include <memory>
#include <vector>

#include "base/random.h"
#include "posterior/noise_view.h"

namespace mm {

using NoisePool = std::vector<std::shared_ptr<const NoiseView>>;

/// One state that a chain visited, and what it says of every cause.
struct Visit {
  double logWeight = 0.0;
  int noise = 0;  // of the pool
  ActingSet set;
  /// A cause: that it acts, and as more than a part of another that acts, given all else of the state
  /// (Rao-Blackwell).
  std::vector<double> inclusion;
  std::vector<int> acting;  // causes of the set, those that are more than a part of another
};

/// A state that a chain met, and its log density.
struct Place {
  double density = 0.0;
  int noise = 0;  // of the pool
  ActingSet set;
};

/// Of each set of causes the densest state.
using PlacesMet = std::map<std::vector<int>, Place>;
/// Keeps a state where it is the densest of its causes.
void keepDenser(PlacesMet& met, const std::vector<int>& causes, const Place& place);
const Place& densestOf(const PlacesMet& met);  ///< @param met not empty

/// A set of causes to which chains jump.
struct Mode {
  ActingSet set;
  std::vector<double> logNoise;  // log probability of each state of the pool beside the set
};

/// Tempered Gibbs sampling over sets of causes (Zanella & Roberts, J. R. Stat. Soc. B 81 (2019)): causes
/// whose state fits the rest badly are proposed more often, and then flipped; where the chain went too often
/// is weighted down by what is known, so that its samples are those of the posterior. The state of the noise
/// is drawn from a pool by Metropolis's rule under the same tempered density.
class PosteriorChain {
 public:
  /// @param pool may grow between runs; problem and pool must outlive it. @param firstFitted of the pool:
  /// from there on the noise was fitted beside causes. @param noise of the pool, and set, to begin with.
  PosteriorChain(const PosteriorProblem& problem, const NoisePool& pool, std::size_t firstFitted,
                 std::uint64_t seed, int number, int noise = 0, ActingSet set = {});

  /// Modes, no two of the same causes, between which the chain jumps, whatever acts beside them: what
  /// explains a session as well by other causes and another noise is not reached by exchanging one after the
  /// other.
  void setModes(std::vector<Mode> modes) { modes_ = std::move(modes); }
  /// Goes on from another state.
  void beginAt(int noise, ActingSet set);
  /// @param visits those of these steps are added; null: they are not kept.
  void run(int steps, std::vector<Visit>* visits);
  const PlacesMet& met() const { return met_; }
  const Place& best() const { return densestOf(met_); }  ///< the densest state that it met

 private:
  using Look = std::shared_ptr<const Conditionals>;
  struct Rates {                  // of the moves from a state
    double logSum = 0.0;          // the tempered density is the density times this
    std::vector<double> logRate;  // a cause: that it changes its state; then each member: that its shape does
  };
  Rates ratesOf(const Conditionals& look, const ActingSet& set) const;
  void stepNoise();
  void stepSet();
  void stepMode();
  /// Shapes and sizes of the causes of a mode, drawn one after the other, each beside those drawn, the mode's
  /// other ones and the others of the set. @param drawn those others; gets those of the mode. @param was not
  /// null: what was drawn. @return log probability of the draw.
  double drawAsMode(const Mode& mode, const NoiseView& noise, const ActingSet* was, ActingSet& drawn);
  /// The noise and one cause drawn together, beside all others: what drift or scatter explains, a cause may
  /// explain instead, and neither can go before the other has come.
  void stepTogether();
  double logDrawn(const Conditionals& look, Acting a) const;  // that drawShape gives it
  void moveTo(ActingSet set, Look look, Rates rates);
  int causeOf(Acting a) const;
  int memberOf(const ActingSet& set, int cause) const;  // its index, -1: it does not act
  Acting drawShape(const Conditionals& look, int cause);
  std::size_t drawFrom(const std::vector<double>& logWeights);
  const NoiseView& view() const { return *pool_[static_cast<std::size_t>(noise_)]; }
  void remember();
  std::vector<int> causesOf(const ActingSet& set) const;
  std::vector<double> sizesOfMembers() const;
  /// Log odds of a cause as a part of others that act, against its absence.
  double logPartOf(int cause, const std::vector<double>& sizes) const;

  const PosteriorProblem& problem_;
  const NoisePool& pool_;
  std::size_t firstFitted_;
  Random random_;
  int noise_ = 0;
  ActingSet set_;
  Look look_;
  Rates rates_;
  std::vector<Mode> modes_;
  PlacesMet met_;
};

}  // namespace mm
