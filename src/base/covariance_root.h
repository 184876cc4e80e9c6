#pragma once
#include <Eigen/Core>

namespace mm {

/// r with r rᵀ = `covariance`, in the units of its rows: the symmetric root of the correlations, a row times
/// its standard deviation; zero where that is 0. Independent variable k is the one that resembles row k most.
Eigen::MatrixXd rootOfCovariance(const Eigen::MatrixXd& covariance);

}  // namespace mm
