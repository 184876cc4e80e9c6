#pragma once
#include <functional>
#include <vector>

namespace mm {

/// Standard deviation of normal numbers from the median of their deviations from the median (MAD times
/// 1.4826). NaN of none.
double robustSpread(const std::vector<double>& values);

/// Standard deviation of normal numbers from the distances of all pairs: their lower quartile, nearly (Qn;
/// Rousseeuw and Croux, J. Amer. Statist. Assoc. 88 (1993) 1273, with the factors for small samples of Croux
/// and Rousseeuw, Computational Statistics 1 (1992) 411). Up to half of them may be wrong, as for the median
/// deviation, and of normal numbers it is known twice as well. Time goes with the square of their number. NaN
/// below two.
double pairSpread(const std::vector<double>& values);

/// The least spread from 0 to `high` that is not too small, to a share of 2^-halvings of it.
double leastSpread(const std::function<bool(double)>& tooSmall, double high, int halvings);

/// Scatter beyond the stated uncertainties that makes the median of |value| / sqrt(std^2 + scatter^2) that of
/// normal numbers; 0 where they scatter less than stated.
double excessScatter(const std::vector<double>& value, const std::vector<double>& variance);

/// Probability that Student's t with `dof` degrees of freedom is farther from 0 than `t`, on either side;
/// accurate far out (1e-300). @param dof may be infinite: the normal distribution.
double twoSidedT(double t, double dof);

}  // namespace mm
