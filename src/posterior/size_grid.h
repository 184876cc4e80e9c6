#pragma once
#include <Eigen/Core>

namespace mm {

/// Sizes over which a cause is integrated: RMS of its main column after the projection, in units of the white
/// noise, log-uniform from far below the noise to sixty times it. Thirteen are close enough for the
/// evidence between two of them not to be missed (a factor of 1.65).
constexpr int kSizes = 13;
using Sizes = Eigen::Array<double, kSizes, 1>;
const Sizes& sizeGrid();

/// Log Bayes factors of a group of columns, at each size of the grid, against its absence.
/// @param products of its columns, after everything that is given; destroyed. @param target their products
/// with what is left; destroyed. @param rest sum of squares that is left, with what the stated noise is
/// worth.
/// @param freedoms of `rest`. One tridiagonal form that begins with the target serves all sizes: its pivots
/// from the end give the determinant, the last of them the quadratic form.
Sizes logBayesFactors(Eigen::Ref<Eigen::MatrixXd> products, Eigen::Ref<Eigen::VectorXd> target, double rest,
                      double freedoms);

}  // namespace mm
