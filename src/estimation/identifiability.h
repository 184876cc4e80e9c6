#pragma once
#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// One direction in the space of the unknowns that the session does not determine.
struct LostDirection {
  std::vector<std::pair<int, double>>
      direction;              // unknown, component (of the unit vector, in units of the bounds)
  int fixedUnknown = -1;      // held at its start value so that the rest is determined
  bool byConvention = false;  // a choice of frame: nothing that can be measured depends on it
  bool ofTheModel = false;    // involves the effects' parameters
  bool noInfluence = false;  // within one effect that is determined but for it: nothing measured here depends
                             // on it (a displacement where only angles were measured)
  std::string inWords;
  std::string wouldShow;  // the measurement that would determine it

  /// True when the calibration lacks it: a parameter is lost that no convention fixes.
  bool lacking() const { return ofTheModel && !byConvention && !noInfluence; }
};

/// What a session determines of a model: found from the scaled Jacobian before the first step.
struct Identifiability {
  int rank = 0;  // of the effects' parameters
  int parameters = 0;
  std::vector<LostDirection> lost;
  std::vector<char> fixed;  // an unknown
  /// True when a direction is lacking.
  bool incomplete() const;
};

/// A direction is lost when its standard deviation exceeds the parameters' declared bounds: no numerical
/// threshold. The gauge is fixed by convention: for MMT alpha_xy = alpha_xz = alpha_yz = 0 in whatever order
/// the axes are listed; else, of a lost direction, the last listed parameter is held.
/// @param x point of linearisation. @param inverseSigma a data row, 1/m or 1/rad, 0: left out.
/// @param beforeFit effects that are not linear in their parameters are left alone: only a fit can tell.
/// @param held unknowns that are not estimated (empty: none): they are fixed, and neither lost nor counted.
Identifiability identify(const Problem& problem, const Eigen::VectorXd& x,
                         const Eigen::VectorXd& inverseSigma, bool beforeFit,
                         const std::vector<char>& held = {});

/// "alpha_yx" when only one effect has a parameter of that name, else "gap of {type: backlash, axis: x}".
std::string displayName(const Problem& problem, int unknown);

}  // namespace mm
