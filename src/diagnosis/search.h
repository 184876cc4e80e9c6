#pragma once
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/evidence.h"
#include "diagnosis/groups.h"
#include "estimation/noise_fit.h"
#include "estimation/residual_space.h"

namespace mm {

/// What a session is, for the posterior: rows, the scatter that is always there, and the questions.
struct Questions {
  const ResidualSpace* space = nullptr;
  NoiseRows rows;
  std::vector<RandomBlock> scatter;       // always there, never a cause
  std::vector<std::string> scatterNames;  // "centres", "radii", "form", kDatum, kPositionsOf …; empty: the
                                          // shape of an effect of the model
  std::vector<std::string> directions;    // of drift
  std::vector<double> directionScale;     // m (rad) of a drift of ratio 1 over white noise of 1
  Groups groups;
  int asked = 0;            // causes
  double resolution = 0.0;  // m or rad: step of readings of which most agree; 0: finer than their noise
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

/// One explanation of the session: causes, drift, scatter and noise.
struct Explanation {
  std::vector<Member> members;
  NoiseModel noise;
  std::vector<double> scatter;  // ratios of Questions::scatter
  double logEvidence = 0.0;     // less the prices of drift and scatter
  double white = 1.0, whiteStd = 0.0;
};

/// A cause with a name that explains this share of what a free curve does is kept: the curve is for the rest.
constexpr double kMostOfIt = 0.9;
/// Standard deviation of a coefficient of a member, in units of the white noise, at the least.
constexpr double kSmallestSize = 1e-3;
/// Explanations whose log evidence differs by less are not separated (Kass & Raftery 1995: 20 to 1).
constexpr double kIndistinct = 3.0;
/// Nats of which a double holds the exponential and its inverse.
constexpr double kMostNats = 650.0;

/// What an explanation says of the session: at its noise, or with the noise fitted again.
/// What takes long throws Cancelled where the CancelScope of its thread says so.
class Search {
 public:
  explicit Search(const Questions& questions) : q_(questions) {}  ///< which must outlive it

  /// The evidence at the noise of an explanation.
  std::shared_ptr<const Evidence> evidenceAt(const Explanation& at,
                                             const std::vector<char>* heldOut = nullptr) const;
  /// Variances fitted again for other members, from a start.
  Explanation refitted(const std::vector<Member>& members, const Explanation& start) const;
  /// Standard uncertainty of its white noise, in units of the stated one, beside drift that is not known
  /// well.
  double whiteStdOf(const Explanation& found) const;
  Member memberOf(const Gain& gain) const;
  /// The size that a member has beside others.
  static void takeSize(Member& member, const Gain& gain);
  /// The other members, without the curves of which this one, which has a name, does most: beside them it
  /// would seem to do nothing.
  std::vector<Member> beside(const Evidence& evidence, const std::vector<Member>& members,
                             std::size_t j) const;
  /// Whether a curve stands beside this member, which has a name, for what it leaves: asked beside that curve
  /// any other would do as well.
  bool hasCurve(const Evidence& evidence, const std::vector<Member>& members, std::size_t j) const;
  /// Nonlinear parameters and size at their best, beside the others.
  Member refined(const Evidence& evidence, const std::vector<Member>& others, const Member& member) const;
  const Questions& questions() const { return q_; }

 private:
  /// What scatters and the members, as the noise is fitted beside them. @param ofBlock filled with what
  /// scatters, a block; those of the members follow.
  std::vector<RandomBlock> blocksOf(const std::vector<Member>& members, const std::vector<double>& scatter,
                                    std::vector<int>& ofBlock) const;

  struct Known {
    NoiseModel noise;
    std::vector<double> scatter;
    std::shared_ptr<const Evidence> evidence;
  };
  const Questions& q_;
  mutable std::vector<Known> known_;  // the last few: the same noise is asked again and again
};

/// The scatter that a session of balls always has, and what the effects of the model leave of their shape.
void addScatter(Questions& questions);

}  // namespace mm
