#pragma once
#include <Eigen/Core>

#include "posterior/size_grid.h"

namespace mm {

/// Of a law whose first coefficient is positive and whose second is a part of it (what is lost at once, of all
/// that is lost): how much likelier data make it that the two are such, than independent coefficients about
/// zero are before any data, which are so in one of eight. This is the Bayes factor of the law against the
/// same columns with free coefficients (Klugkist and Hoijtink, Comput. Stat. Data Anal. 51 (2007)).
/// @param mean, covariance of the two coefficients. @return nats.
double logPartOfFirst(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance);

/// The same at each size of the grid. @param products, target of the columns of one shape, the two first;
/// everything else integrated out. @param rest squares beside them, of `freedoms`.
Sizes logPartOfFirst(const Eigen::MatrixXd& products, const Eigen::VectorXd& target, double rest,
                     double freedoms);

}  // namespace mm
