#pragma once
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/evidence.h"
#include "diagnosis/groups.h"
#include "estimation/noise_fit.h"
#include "estimation/residual_space.h"

namespace mm {

/// What a session is, for the search: rows, the scatter that is always there, and the questions.
struct Questions {
  const ResidualSpace* space = nullptr;
  NoiseRows rows;
  std::vector<RandomBlock> scatter;  // always there, never a cause
  std::vector<std::string>
      scatterNames;  // "centres", "radii", "form", kDatum; empty: the shape of an effect of the model
  std::vector<std::string> directions;  // of drift
  std::vector<double> directionScale;   // m (rad) of a drift of ratio 1 over white noise of 1
  Groups groups;
  int asked = 0;            // causes
  int profiles = 0;         // profiles of one variable among the groups
  int pairs = 0;            // profiles of two
  double resolution = 0.0;  // m or rad: step of readings of which most agree; 0: finer than their noise
  bool many = false;        // rows: the noise is fitted as `fitManyRows` does
};

/// The same session without the questions, for what asks none.
inline Questions rowsOf(const Questions& q) {
  Questions rows;
  rows.space = q.space;
  rows.rows = q.rows;
  rows.scatter = q.scatter;
  rows.groups.columns.resize(q.rows.length(), 0);
  return rows;
}

/// Another cause in the place of a member, with the noise fitted again.
struct Rival {
  std::size_t member = 0;
  int group = 0, shape = 0;
  double behind = 0.0;  // nats
  double share = 1.0;   // of its odds that this name has
};

/// One explanation of the session: causes, drift, scatter, noise, and what all of it is worth.
struct Explanation {
  std::vector<Member> members;
  NoiseModel noise;
  std::vector<double> scatter;  // ratios of Questions::scatter
  double logEvidence = 0.0;     // less the prices of drift and scatter
  double worth = 0.0;           // less the prices of the members too
  double white = 1.0, whiteStd = 0.0;
  std::vector<Rival> rivals;  // those that were near at its noise
};

/// What the evidence of a cause must outweigh, beside the number of causes asked. Where nothing is hidden the
/// evidence for one cause exceeds e^g at most once in e^g sessions, so that of a hundred such sessions one at
/// the most claims something.
constexpr double kPriorOdds = 100.0;
/// A cause with a name that explains this share of what a free curve does is kept: the curve is for the rest.
constexpr double kMostOfIt = 0.9;
/// Standard deviation of a coefficient of a member, in units of the white noise, at the least: one that were
/// nothing could not grow again.
constexpr double kSmallestSize = 1e-3;
/// Nats below its price: what is worse at one model of the noise is not tried with another.
constexpr double kWorthTrying = 6.0;
/// Explanations whose log evidence differs by less are not separated (Kass & Raftery 1995: 20 to 1).
constexpr double kIndistinct = 3.0;
/// Nats of which a double holds the exponential and its inverse.
constexpr double kMostNats = 650.0;

/// The search for the explanation of greatest worth: forward, exchange and backward, drift always a rival.
/// What takes long throws Cancelled where the CancelScope of its thread says so.
class Search {
 public:
  explicit Search(const Questions& questions) : q_(questions) {}  ///< which must outlive it

  /// The whole search. @param variance of the white noise a row.
  Explanation run(const Eigen::VectorXd& variance) const;
  /// Nothing found, and the noise that is then there.
  Explanation none(const Eigen::VectorXd& variance) const;
  /// Whether drift or scatter are so large that they may be several causes together: one at a time, causes
  /// that act together would never get past a scatter that imitates them all. Then the other way is tried
  /// too: from `bare`, with neither, `causesAlone`, and the one that is `ofGreaterWorth`.
  bool couldHideSeveral(const Explanation& found) const;
  /// Nothing found, as if nothing drifted and the artifact were as its file says.
  Explanation bare(const Explanation& found) const;
  /// The search on from there, without drift and scatter.
  Explanation causesAlone(Explanation start) const;
  /// What was found, or what causes alone explain where that is worth more, once drift and scatter have
  /// earned their place beside all of them.
  Explanation ofGreaterWorth(Explanation found, const Explanation& causes) const;
  /// The search on from an explanation, whose noise, weights or questions have changed.
  Explanation improved(const Explanation& start) const;
  /// The same with every near rival of every member tried with the noise fitted again: what one model of the
  /// noise, fitted beside the member, says of its rivals is biased. Also fills in the rivals.
  Explanation settled(Explanation best) const;
  /// Two causes at once.
  struct Pair {
    double worth = 0.0;  // more than the members have that it is beside, or in the place of one of
    std::vector<Member> members;
    std::vector<std::size_t> leaving;  // of the members: those that went for it
  };
  /// Adds to the rivals two causes that together explain nearly as much as what they would take the place of.
  /// Where they explain more, they take its place.
  Explanation withPairsAsRivals(Explanation found) const;
  /// Settled, and with all rivals of what was found.
  Explanation settledWithPairs(Explanation found) const {
    return withPairsAsRivals(settled(std::move(found)));
  }
  /// What is left without one of its members, the noise fitted again.
  Explanation without(const Explanation& found, std::size_t member) const;
  /// Without the members that do not earn their price any more.
  Explanation pruned(Explanation best) const;
  /// The search at one model of the noise that stays, on some of the rows: from nothing, and from what of
  /// `found` these rows bear out; what is worth more to these rows alone.
  std::vector<Member> runHeld(const Explanation& found, const Evidence& evidence) const;

  /// What a group must gain to be named.
  double priceOf(int group) const { return priceOfOne(q_.groups.groups[group]); }
  double priceOfOne(const Group& group) const;
  double priceOf(const Member& member) const;
  /// The evidence at the noise of an explanation.
  std::shared_ptr<const Evidence> evidenceAt(const Explanation& at,
                                             const std::vector<char>* heldOut = nullptr) const;
  /// Variances fitted again for other members, from a start. @param add look for further drift, too, @param
  /// along one direction only, or along all (-1).
  Explanation refitted(const std::vector<Member>& members, const Explanation& start, bool add,
                       int along = -1) const;
  /// Standard uncertainty of its white noise, in units of the stated one, beside drift that is not known
  /// well.
  double whiteStdOf(const Explanation& found) const;
  Member memberOf(const Gain& gain) const;
  /// The size that a member has beside others, and what it costs where it is not usual.
  void takeSize(Member& member, const Gain& gain) const;
  /// A cause is there already, and no key of its effect could say that it is there once more.
  bool isThere(const std::vector<Member>& members, const Gain& gain) const;
  /// A member whose group has another place in the list now.
  Member moved(Member member, int group) const;
  /// The other members, without the curves of which this one, which has a name, does most: beside them it
  /// would seem to do nothing.
  std::vector<Member> beside(const Evidence& evidence, const std::vector<Member>& members,
                             std::size_t j) const;
  /// Whether a curve stands beside this member, which has a name, for what it leaves: asked beside that curve
  /// any other would do as well.
  bool hasCurve(const Evidence& evidence, const std::vector<Member>& members, std::size_t j) const;
  /// Two causes have the same column in this session: what their evidence differs by is the freedom of their
  /// shapes.
  bool actAlike(int group, int shape, int otherGroup, int otherShape) const;
  /// Nonlinear parameters and size at their best, beside the others.
  Member refined(const Evidence& evidence, const std::vector<Member>& others, const Member& member) const;
  const Questions& questions() const { return q_; }

 private:
  /// Of causes that act alike in this session (one speed: play and a late trigger) one of a usual size that
  /// comes first in the catalogue, which goes from the common to the rare: their evidence differs by the
  /// freedom of their shapes alone.
  Gain commoner(const Gain& best, const std::vector<Gain>& gains, const std::vector<Member>& there) const;
  /// @param bare with neither drift nor scatter.
  Explanation grown(Explanation best, bool bare = false) const;
  bool driftsOrScatters(const Explanation& found) const;
  Explanation withoutDriftAndScatter(Explanation found) const;
  /// Grown and pruned, with what comes in pairs.
  Explanation whole(Explanation start) const;
  /// Two causes at once, of which neither alone would come: in the place of one that imitates both, or two
  /// laws of one joint that mostly cancel (pitch about the carriage: an angle about a far origin, and the
  /// straightness that this is not). @return what was given where there are none.
  Explanation paired(const Explanation& best) const;
  /// The best few, at one model of the noise.
  std::vector<Pair> likelyPairs(const Evidence& evidence, const std::vector<Member>& members) const;
  std::vector<Member> grownHeld(const Evidence& evidence, std::vector<Member> members) const;
  /// What came with a partner that is not among them any more has its whole price.
  void payInFullAlone(std::vector<Member>& members) const;
  double worthAt(const Evidence& evidence, const std::vector<Member>& members) const;
  Explanation exchanged(Explanation best) const;
  std::vector<Member> exchangedAt(const Evidence& evidence, std::vector<Member> members, bool* changed) const;

  /// What scatters and the members, as the noise is fitted beside them. @param all what scatters by nothing,
  /// too. @param ofBlock filled with what scatters, a block; those of the members follow.
  std::vector<RandomBlock> blocksOf(const std::vector<Member>& members, const std::vector<double>& scatter,
                                    bool all, std::vector<int>& ofBlock) const;

  struct Known {
    NoiseModel noise;
    std::vector<double> scatter;
    std::shared_ptr<const Evidence> evidence;
  };
  const Questions& q_;
  mutable std::vector<Known> known_;  // the last few: the same noise is asked again and again
};

/// Name of what displaces an artifact of known pose as a whole.
constexpr const char* kDatum = "datum";

/// The scatter that a session of balls always has, and what the effects of the model leave of their shape.
void addScatter(Questions& questions);

}  // namespace mm
