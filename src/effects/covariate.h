#pragma once
#include <cmath>

#include "effects/domain.h"

namespace mm {

/// Observed width of a covariate's range, in its unit; 1 where it did not change or was not logged.
inline double covariateRange(const Domain& domain, int covariate) {
  const auto i = static_cast<std::size_t>(covariate);
  if (i >= domain.covariateLower.size() || i >= domain.covariateUpper.size()) return 1.0;
  const double range = domain.covariateUpper[i] - domain.covariateLower[i];
  return range > 0.0 ? range : 1.0;
}

/// The value at which a covariate does nothing: zero, or, where zero is further from the observed range than
/// that is wide (a pressure, a humidity), the middle of the range.
inline double covariateReference(const Domain& domain, int covariate) {
  const auto i = static_cast<std::size_t>(covariate);
  if (i >= domain.covariateLower.size() || i >= domain.covariateUpper.size()) return 0.0;
  const double lower = domain.covariateLower[i], upper = domain.covariateUpper[i];
  if (!(std::isfinite(lower) && std::isfinite(upper))) return 0.0;
  const double nearest = lower > 0.0 ? lower : upper < 0.0 ? -upper : 0.0;
  return nearest > upper - lower ? 0.5 * (lower + upper) : 0.0;
}

}  // namespace mm
