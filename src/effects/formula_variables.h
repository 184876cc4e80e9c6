#pragma once
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "effects/domain.h"
#include "effects/state.h"

namespace mm {

/// What a formula may use, by name and in the units of people: linear joints in mm, rotary in rad,
/// `<joint>_velocity` in mm/s or rad/s, `<joint>_travel` 1 or -1 (its direction of travel), `t` in s,
/// temperatures in degC, covariates in their own unit, `reading` of a laser probe in mm. A name with
/// characters that a formula cannot hold is written with `_` in their place.
class FormulaVariables {
 public:
  explicit FormulaVariables(const Domain& domain);                  ///< all that the domain records
  const std::vector<std::string>& names() const { return names_; }  ///< as written in a formula
  /// Values of the variables with these indices; NaN: not known.
  void values(const State& state, const std::vector<int>& indices, double* out) const;
  /// A value of this variable drawn from (somewhat beyond) its observed range.
  double sample(int index, std::mt19937_64& random) const;

  enum class Kind { kPosition, kVelocity, kTravel, kTime, kTemperature, kCovariate, kReading };
  Kind kind(int index) const {
    return variables_[static_cast<std::size_t>(index)].kind;
  }  ///< of names()[index]
  /// Of a position, a velocity or a direction of travel.
  int joint(int index) const { return variables_[static_cast<std::size_t>(index)].index; }
  /// "mm", "rad", "mm/s", "rad/s", "s", "degC"; empty for a covariate or a direction of travel.
  std::string unit(int index) const;
  /// The range over which the session saw it, in that unit. @return false: it was not recorded or never
  /// changed.
  bool observed(int index, double& lower, double& upper) const;

 private:
  struct Variable {
    Kind kind;
    int index;
    double factor;                                          // from SI
    double lower, upper;                                    // to try a formula with
    double observedLower = kNever, observedUpper = kNever;  // SI
  };
  static constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
  void define(const std::string& name, const Variable& variable);

  std::vector<std::string> names_;
  std::vector<Variable> variables_;
};

}  // namespace mm
