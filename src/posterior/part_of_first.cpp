#include "posterior/part_of_first.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "base/dense.h"
#include "base/distributions.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kExact = 1e-10;         // less than this the sum of two large terms does not tell
constexpr double kCorrelated = 0.99999;  // more is rounding

/// Probability that two standard normal variables are below h and k (Drezner and Wesolowsky, J. Stat. Comput.
/// Simul. 35 (1990)).
double bothBelow(double h, double k, double correlation) {
  const double end = std::asin(std::clamp(correlation, -kCorrelated, kCorrelated));
  const auto density = [&](double angle) {
    const double cosine = std::cos(angle);
    return std::exp(-0.5 * (h * h + k * k - 2.0 * h * k * std::sin(angle)) / (cosine * cosine));
  };
  const double more = boost::math::quadrature::gauss<double, 20>::integrate(density, 0.0, end);
  return normalBelow(h) * normalBelow(k) + more / (2.0 * kPi);
}

/// Logarithm of that probability: where it is too small to be computed, its bound by the most probable place
/// at which both are below.
double logBothBelow(double h, double k, double correlation) {
  const bool isLikely = std::min(normalBelow(h), normalBelow(k)) > kExact;
  const double probability = isLikely ? bothBelow(h, k, correlation) : 0.0;
  if (probability > kExact) return std::log(std::min(probability, 1.0));
  const double rho = std::clamp(correlation, -kCorrelated, kCorrelated);
  double square = (h * h - 2.0 * rho * h * k + k * k) / (1.0 - rho * rho);  // of the distance of the corner
  if (h < 0.0 && k - rho * h >= 0.0) square = h * h;
  if (k < 0.0 && h - rho * k >= 0.0) square = std::min(square, k * k);
  return std::min(std::log(kExact), -0.5 * square);
}

}  // namespace

double logPartOfFirst(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance) {
  // the part and the rest are positive
  Eigen::Matrix2d parts;
  parts << 0.0, 1.0, 1.0, -1.0;
  const Eigen::Vector2d at = parts * mean;
  const Eigen::Matrix2d of = parts * covariance * parts.transpose();
  const Eigen::Vector2d std = of.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(std.minCoeff() > 0.0)) return 0.0;
  const double h = at[0] / std[0], k = at[1] / std[1], correlation = of(0, 1) / (std[0] * std[1]);
  return logBothBelow(h, k, correlation);
}

Sizes logPartOfFirst(const Eigen::MatrixXd& products, const Eigen::VectorXd& target, double rest,
                     double freedoms) {
  const SymmetricEigen axes(products);
  const Eigen::Matrix2Xd ofTwo = axes.vectors.topRows<2>();
  const Eigen::ArrayXd along = axes.vectors.transpose() * target;
  Sizes logs;
  for (int s = 0; s < kSizes; ++s) {
    const double square = sizeGrid()[s] * sizeGrid()[s];
    const Eigen::ArrayXd inverse = square / (1.0 + square * axes.values.array());
    const Eigen::Vector2d mean = ofTwo * (inverse * along).matrix();
    const double variance = std::max(0.0, rest - (inverse * along.square()).sum()) / freedoms;
    logs[s] = logPartOfFirst(mean, variance * ofTwo * inverse.matrix().asDiagonal() * ofTwo.transpose());
  }
  return logs;
}

}  // namespace mm
