#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "diagnosis/structure.h"
#include "effects/domain.h"

namespace mm {

/// A quantity as formulas write it: a variable of the session, or a physical combination of some (the speed
/// of the tip, the difference of two temperatures).
struct Symbol {
  enum class Kind { kPosition, kSpeed, kTime, kTemperature, kDifference, kCovariate, kTipSpeed, kWay };
  Kind kind = Kind::kCovariate;
  std::string text;            // "x", "x_velocity", "(bed-20)", "(air-bed)"
  std::string bare;            // the same before a constant is taken off: "bed"
  double zero = 0.0;           // and what is taken off in any case
  std::vector<int> variables;  // indices of `variablesOf`
  Eigen::ArrayXd values;       // a used row, in the units of formulas
  std::string unit;            // "mm", "rad", "degC", …; sums are made of equal units only
  double low = 0.0, high = 0.0;
  int distinct = 0;  // different values

  double range() const { return high - low; }
  double middle() const { return 0.5 * (low + high); }
};

/// @param variables of the same session.
std::vector<Symbol> symbolsOf(const std::vector<Variable>& variables, const Domain& domain);

}  // namespace mm
