#include "verification/point_system.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/median.h"
#include "estimation/thin_qr.h"

namespace mm {
namespace {

constexpr double kFewestFreedoms = 8;  // below, the noise is not known to a quarter
constexpr double kForMemory = 25;      // fewer residuals beyond the unknowns do not tell a memory
constexpr double kApart = 5.0;         // standard deviations
constexpr double kMostApart = 0.1;     // of the rows; more than these are no outliers
constexpr double kDriftPrice = 3.0;    // as a calibration's: log evidence that a memory must earn
constexpr double kKnown = 2.0;  // log evidence by which another memory must be better than the known one
constexpr int kMostRows = 1500;

/// Orthonormal columns of what orthonormal ones and others span; of dependent columns the first.
Eigen::MatrixXd spanWith(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& more) {
  constexpr double kNew = 1e-7;  // of a column's own length
  Eigen::MatrixXd all(basis.rows(), std::min(basis.rows(), basis.cols() + more.cols()));
  all.leftCols(basis.cols()) = basis;
  Eigen::Index count = basis.cols();
  for (Eigen::Index k = 0; k < more.cols() && count < all.cols(); ++k) {
    Eigen::VectorXd column = more.col(k);
    const double norm = column.norm();
    for (int pass = 0; pass < 2; ++pass)  // Gram and Schmidt twice: orthogonal to rounding
      column -= all.leftCols(count) * (all.leftCols(count).transpose() * column);
    if (column.norm() > kNew * norm) all.col(count++) = column.normalized();
  }
  return all.leftCols(count);
}

}  // namespace

Eigen::MatrixXd beside(const std::vector<Eigen::MatrixXd>& parts) {
  Eigen::Index columns = 0;
  for (const Eigen::MatrixXd& part : parts) columns += part.cols();
  Eigen::MatrixXd all(parts.front().rows(), columns);
  columns = 0;
  for (const Eigen::MatrixXd& part : parts) {
    all.middleCols(columns, part.cols()) = part;
    columns += part.cols();
  }
  return all;
}

std::vector<DriftTerm> PointSystem::knownDrift(const Calibration& calibration) const {
  std::vector<DriftTerm> terms;
  for (const Wandering& w : calibration.drift) {
    const auto found = std::find(rows_.directions.begin(), rows_.directions.end(), w.direction);
    if (found == rows_.directions.end() || !(w.std > 0.0) || !(w.timeConstant > 0.0)) continue;
    const int d = found - rows_.directions.begin();
    terms.push_back({d, w.std / rows_.directionScale[d], w.timeConstant, w.smooth});
  }
  return terms;
}

PointSystem::PointSystem(const FreshPoints& points, const Calibration& calibration) : points_(points) {
  const ResidualSpace& space = points.space();
  const int length = space.length();
  // What could be wrong, in the order in which it is asked; as much of it as leaves the noise to be seen.
  std::vector<Eigen::MatrixXd> misplaced = {Eigen::MatrixXd(length, 0)};
  for (const MisplacedTable& table : points.misplaced()) misplaced.emplace_back(table.column);
  if (points.hasOffsets()) misplaced.emplace_back(points.offsets());
  Eigen::MatrixXd all = space.basis();
  int parts = 0;
  for (const Eigen::MatrixXd& more :
       {points.byEffect(), points.crossed(), points.byParameter(), beside(misplaced), points.shapes()}) {
    Eigen::MatrixXd with = spanWith(all, more);
    if (length - with.cols() < kFewestFreedoms) break;
    all = std::move(with);
    ++parts;
  }
  if (parts == 0)
    throw NumericalError(points.fitted().problem->session().source + ": " + std::to_string(points.rows()) +
                         " residuals are too few to verify a calibration of " +
                         std::to_string(points.effects().size()) +
                         " effects; measure the plan of mm plan verify");
  findOutliers(all);

  rows_ = noiseRows(space.linearisation(), space.used(), points.fitted().sigma, points.raw(), all);
  NoiseModel noise;
  noise.variance = Eigen::VectorXd::Ones(points.rows());
  NoiseFitOptions options;
  options.driftPrice = kDriftPrice;
  options.addDrift = length - all.cols() >= kForMemory;
  NoiseFitResult fit = fitNoise(rows_.rows, {}, noise, options, kMostRows);
  // The memory that the calibration knows of is there without a price.
  noise.drift = knownDrift(calibration);
  if (!noise.drift.empty()) {
    options.addDrift = options.dropDrift = options.refine = false;
    options.driftPrice = options.smoothPrice = 0.0;
    NoiseFitResult known = fitNoise(rows_.rows, {}, noise, options, kMostRows);
    if (known.logEvidence + kKnown > fit.logEvidence) fit = std::move(known);
  }
  noise_ = fit.noise;
  white_ = fit.white;
  whitener_ =
      std::make_unique<TimeWhitener>(rows_.rows.time, rows_.rows.factors, noise_.variance, noise_.drift);
  base_ = orthonormalBasis(whiten(space.basis()));
  const Projection rest(orthonormalBasis(whiten(all)), {});
  freedoms_ = length - rest.rank();
  leftByAll_ = rest.left(whiten(points.raw())).squaredNorm();
}

void PointSystem::findOutliers(const Eigen::MatrixXd& all) {
  const Eigen::VectorXd left = points_.raw() - all * (all.transpose() * points_.raw());
  std::vector<double> sizes;
  for (int i = 0; i < points_.rows(); ++i) {
    const double share = 1.0 - all.row(i).squaredNorm();
    sizes.push_back(share > 0.05 ? std::abs(left[i]) / std::sqrt(share) : 0.0);
  }
  constexpr double kOfMedian = 1.4826;  // standard deviation of a normal distribution over its median size
  const double scale = kOfMedian * upperMedian(sizes);
  for (int i = 0; i < points_.rows(); ++i)
    if (scale > 0.0 && sizes[i] > kApart * scale) outliers_.push_back(i);
  if (outliers_.size() > kMostApart * points_.rows()) outliers_.clear();
}

Eigen::MatrixXd PointSystem::whiten(const Eigen::MatrixXd& columns) const {
  RowMatrix m = columns;
  whitener_->whiten(m);
  return m / white_;
}

Eigen::VectorXd PointSystem::variances() const {
  Eigen::VectorXd variance = noise_.variance;
  for (const DriftTerm& t : noise_.drift)
    variance += t.ratio * t.ratio * rows_.rows.factors.col(t.direction).cwiseAbs2();
  return white_ * white_ * variance;
}

Eigen::MatrixXd PointSystem::covarianceTimes(const Eigen::MatrixXd& m) const {
  return white_ * white_ * Eigen::MatrixXd(whitener_->covarianceTimes(RowMatrix(m)));
}

Projection::Projection(const Eigen::MatrixXd& free, const Eigen::MatrixXd& scattering)
    : scattering_(scattering.cols()) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(free.rows() + scattering_, free.cols() + scattering_);
  all.topLeftCorner(free.rows(), free.cols()) = free;
  if (scattering_ > 0) {
    all.topRightCorner(free.rows(), scattering_) = scattering;
    all.bottomRightCorner(scattering_, scattering_).setIdentity();
  }
  basis_ = orthonormalBasis(std::move(all));
}

Eigen::MatrixXd Projection::left(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(columns.rows() + scattering_, columns.cols());
  all.topRows(columns.rows()) = columns;
  all -= basis_ * (basis_.transpose() * all).eval();
  return all;
}

}  // namespace mm
