#pragma once

namespace mm {

// Distributions of statistical tests, by Boost.Math, whose templates are compiled once, in distributions.cpp.
// Degrees of freedom are positive, not only whole numbers. Each throws std::domain_error where an argument is
// outside its range.

/// Probability of less than `value` standard deviations.
double normalBelow(double value);
/// Below this number of standard deviations it is with that probability.
double normalQuantile(double probability);

/// Probability that Student's t is above `t`.
double studentTail(double t, double freedoms);
/// Student's t is above this with probability `chance`.
double studentLimit(double chance, double freedoms);

/// Probability that Fisher's F, of variances with so many degrees of freedom, is above `f`.
double fisherTail(double f, double freedomsAbove, double freedomsBelow);
/// Fisher's F is above this with probability `chance`.
double fisherLimit(double chance, double freedomsAbove, double freedomsBelow);

/// Probability that chi-squared is above `value`, which is 0 or more.
double chiSquaredTail(double value, double freedoms);
/// Chi-squared is below this with that probability.
double chiSquaredQuantile(double probability, double freedoms);

}  // namespace mm
