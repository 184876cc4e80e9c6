#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// Called after each iteration with its number and the cost; returns false to stop with the best so far.
using RefineProgress = std::function<bool(int iteration, double cost)>;

struct RefineResult {
  Eigen::VectorXd x;
  int iterations = 0;
  bool converged = false;
  bool cancelled = false;
  std::string stop;  // in words
};

/// The least squares from `x` over the unknowns that are not fixed: Gauss-Newton, where the model is not
/// nearly linear or that does not converge after Levenberg-Marquardt (Ceres). Free positions of features are
/// eliminated first. Runs on one thread, so that bits do not depend on threads.
/// @param sigma standard deviation a data row (m, rad). @param weight a data row: 1, or 0 to leave it out.
RefineResult refine(const Problem& problem, const Eigen::VectorXd& x, const std::vector<char>& fixed,
                    const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                    const RefineProgress& progress = {});

}  // namespace mm
