#pragma once
#include <Eigen/Core>

#include "posterior/size_grid.h"

namespace mm {

/// Of a law whose first coefficient is positive and whose second is a part of it (what is lost at once, of
/// all that is lost): probability, given the data, that the coefficients of its columns are such. Its
/// logarithm belongs to the evidence of the columns with free coefficients (Klugkist and Hoijtink, Comput.
/// Stat. Data Anal. 51 (2007)); that they are such before any data is in how seldom the cause is met
/// (Nature::met). Columns beside these two are not asked.
/// @param mean, covariance of the two coefficients. @return nats.
double logPartOfFirst(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance);

/// The same at each size of the grid. @param products, target of the columns of one shape, the two first;
/// everything else integrated out. @param rest squares beside them, of `freedoms`.
Sizes logPartOfFirst(const Eigen::MatrixXd& products, const Eigen::VectorXd& target, double rest,
                     double freedoms);

}  // namespace mm
