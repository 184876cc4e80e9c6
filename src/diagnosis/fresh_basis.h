#pragma once
#include <Eigen/Core>

namespace mm {

/// Share of a column's square below which it adds nothing new to a basis.
constexpr double kDependent = 1e-6;

/// Orthonormal basis of what columns add to an orthonormal `basis`; both of the same length.
Eigen::MatrixXd freshBasis(const Eigen::MatrixXd& basis, Eigen::MatrixXd columns);

}  // namespace mm
