#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// 0 for an empty list.
double medianOf(std::vector<double> values);

/// 1.4826 times the median absolute value: standard deviation of the bulk. 0 for an empty list.
double robustSigma(std::vector<double> values);

/// From how many standard deviations of the bulk on a residual can be an outlier: 9, and more where few
/// degrees of freedom say how large the bulk is (Student's t at 1e-9).
double outlyingLimit(int degreesOfFreedom);

/// Standard deviation that a reading has by its resolution alone (GUM F.2.2.1: its step over the square root
/// of 12), m or rad, a data row. Of deviations the step is the smallest difference of two that differ: where
/// they are not rounded, next to nothing. Other rows have 0: their positions are where the plan went.
Eigen::VectorXd resolutionSigma(const Problem& problem);

/// Finds outliers: residuals that are large against the bulk AND stand apart from their neighbours in time,
/// in approach and in position. What its neighbours share is structure (an effect that is missing), not an
/// outlier.
/// @param sigma of a data row, m or rad; the bulk is never less than the resolution of the readings. @return
/// weight a data row: 0 for all rows of an outlying observation, else 1; all 1 when there are fewer than 20
/// rows or when more than a fifth stand apart.
Eigen::VectorXd outlierWeights(const Problem& problem, const Eigen::VectorXd& residuals,
                               const Eigen::VectorXd& sigma, int freeUnknowns);

/// Takes back into the fit what only seems to stand apart because the others hardly determine the model there
/// (leverage).
/// @param x fit without the rows of weight 0, `residuals` (m, rad) at it. @return the weights with those rows
/// at 1.
Eigen::VectorXd reinstated(const Problem& problem, const Eigen::VectorXd& x, const Eigen::VectorXd& residuals,
                           const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                           const std::vector<char>& fixed);

}  // namespace mm
