#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "effects/effect_spec.h"
#include "machine/iso230_axes.h"

namespace mm {

/// Errors of one machine's axes by their symbols of ISO 230-1:2012, 3.4. Of error motions E, the direction of
/// the error (X, Y, Z along; A, B, C about) and the axis that moves: EXX positioning, EYX straightness, EBX
/// tilt. Of errors of position and orientation of an axis average line the direction, 0 and the axis: X0C,
/// and C0Y for the squareness of Y to X. Directions and axes are those of the machine (Iso230Axis), in
/// `workpiece` at zero readings.
class ErrorSymbols {
 public:
  ErrorSymbols() = default;                       ///< of no machine: no effect has a symbol
  explicit ErrorSymbols(const Machine& machine);  ///< of its axes

  /// "EYX"; "EXC, EYC, ECC" of an effect with several; empty where the standard has none: an error that
  /// depends on more than the position and the direction of travel of one axis, or that acts in no direction
  /// of the machine's. An effect that is part of an error motion (a reversal, a periodic error, a sag) has
  /// its symbol.
  std::string of(const EffectSpec& effect) const;

  /// Of a squareness (see of()): the rotation of the axis average line, rad per m/m of the effect's slope; +1
  /// or -1. It is right-handed about the axis of `workpiece` that the symbol names, away from the other axis.
  /// 0: no squareness.
  int squarenessSign(const EffectSpec& effect) const;

 private:
  const Iso230Axis* axis(const std::string& joint) const;
  std::string letterOf(const std::string& direction, const Iso230Axis* moving) const;
  std::string motion(const std::string& direction, const std::string& joint) const;
  std::string rotations(const std::string& joint, bool tilts) const;

  std::vector<std::string> joints_;
  std::vector<Iso230Axis> axes_;
};

/// The effect as inWords() calls it, its symbol behind it: "straightness of x in y, degree 2 (EYX)".
std::string inWords(const EffectSpec& effect, const ErrorSymbols& symbols);

}  // namespace mm
