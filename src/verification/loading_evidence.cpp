#include "verification/loading_evidence.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "estimation/noise_rows.h"
#include "estimation/thin_qr.h"
#include "verification/decision.h"

namespace mm {
namespace {

constexpr double kLeast = 1e-12;  // in the unit of a parameter: none is smaller

const double kChanged = std::log(1e-4);  // chance to say in vain that an effect changed, all effects together
constexpr double kDrifts = 0.5;          // usual change of a parameter, of itself
constexpr double kShareStd = 10.0;       // of a share, before any data: anything is possible

/// Root of a covariance, also of a singular one.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& covariance) {
  // Parameters differ by many powers of ten: the root is taken of correlations.
  const Eigen::VectorXd std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(std.size(), std.size());
  for (Eigen::Index i = 0; i < std.size(); ++i)
    for (Eigen::Index j = 0; j < std.size(); ++j)
      if (i != j)
        correlation(i, j) = std[i] > 0.0 && std[j] > 0.0 ? covariance(i, j) / (std[i] * std[j]) : 0.0;
  const SymmetricEigen eigen(correlation);
  return std.asDiagonal() * eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// Size of a parameter that conditions the columns, SI.
double scaleOf(const Calibration::Value& v) {
  return std::max({std::abs(v.value), v.std, kLeast / std::max(kLeast, std::abs(v.toUnit))});
}

/// What a drift of size 1 along a direction adds to the mean square of the residuals of one kind: the mean
/// square of its cosines, or of its levers.
double seenOf(const std::string& direction, const FreshPoints& points, bool angular) {
  const std::vector<int>& used = points.space().used();
  const Directions directions = directionsOf(points.space().linearisation(), used);
  const auto found = std::find(directions.names.begin(), directions.names.end(), direction);
  if (found == directions.names.end()) return 0.0;
  const auto column = static_cast<Eigen::Index>(found - directions.names.begin());
  double square = 0.0;
  int rows = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (points.fitted().problem->rows()[static_cast<std::size_t>(used[i])].angular != angular) continue;
    square += std::pow(directions.factors(static_cast<Eigen::Index>(i), column), 2);
    ++rows;
  }
  return rows > 0 ? square / rows : 0.0;
}

/// Variance of the noise of these points, m^2 or rad^2, on average of the residuals of one kind.
double scatterOf(const FreshPoints& points, const PointSystem& system, bool angular) {
  const std::vector<int>& used = points.space().used();
  const Eigen::VectorXd variance = system.variances();
  double sum = 0.0;
  int rows = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (points.fitted().problem->rows()[static_cast<std::size_t>(used[i])].angular != angular) continue;
    sum += std::pow(points.fitted().sigma[used[i]], 2) * variance[static_cast<Eigen::Index>(i)];
    ++rows;
  }
  return rows > 0 ? sum / rows : 0.0;
}

}  // namespace

double leftUnexplained(const FreshPoints& points, const PointSystem& system, const Calibration& calibration) {
  const bool linear = std::isfinite(calibration.heldOutRms);
  const double left = linear ? calibration.heldOutRms : calibration.heldOutRmsAngular;
  double noise = calibration.repeatability * calibration.repeatability;
  for (const Wandering& w : calibration.drift) noise += w.std * w.std * seenOf(w.direction, points, !linear);
  // What these points scatter by themselves, the calibrated ones did too: it is no error of the machine.
  noise = std::max(noise, scatterOf(points, system, !linear));
  const double square = left * left - noise;
  return square > 0.0 ? std::sqrt(square) : 0.0;
}

Shares sharesOf(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  Eigen::MatrixXd normal = columns.transpose() * columns;
  normal.diagonal().array() += 1.0 / (kShareStd * kShareStd);
  const Eigen::MatrixXd covariance = inverseOfSymmetric(normal);
  return {covariance * (columns.transpose() * y), covariance.diagonal().cwiseMax(0.0).cwiseSqrt()};
}

LoadingEvidence::LoadingEvidence(const FreshPoints& points, const PointSystem& system,
                                 const Calibration& calibration)
    : points_(points),
      system_(system),
      calibration_(calibration),
      covariance_(covarianceOf(points, calibration)),
      byParameter_(system.whiten(points.byParameter())),
      asCalibrated_(system.base(), beside({scattering(covariance_), unexplainedOf() * unitShapes()})) {}

Projection LoadingEvidence::changedSince() const {
  Eigen::MatrixXd covariance = covariance_;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    const double value =
        calibration_.values[static_cast<std::size_t>(points_.parameters()[static_cast<std::size_t>(i)])]
            .value;
    covariance(i, i) += kDrifts * kDrifts * value * value;
  }
  return Projection(system_.base(), beside({scattering(covariance), system_.whiten(points_.shapes())}));
}

std::vector<double> LoadingEvidence::scores(const Projection& projection,
                                            const std::vector<LoadedHow>& all) const {
  const Eigen::MatrixXd left = projection.left(misses(all));
  std::vector<double> scores;
  for (std::size_t h = 0; h < all.size(); ++h)
    scores.push_back(all[h].logPrior -
                     0.5 * freedoms() * std::log(left.col(static_cast<Eigen::Index>(h)).squaredNorm()));
  return scores;
}

Eigen::MatrixXd LoadingEvidence::misses(const std::vector<LoadedHow>& all) const {
  Eigen::MatrixXd m(points_.length(), static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i)
    m.col(static_cast<Eigen::Index>(i)) = points_.raw() - all[i].field;
  return system_.whiten(m);
}

Eigen::MatrixXd LoadingEvidence::scattering(const Eigen::MatrixXd& covariance) const {
  return byParameter_ * rootOf(covariance);
}

Eigen::MatrixXd LoadingEvidence::unitShapes() const {
  Eigen::MatrixXd shapes = system_.whiten(points_.shapes());
  for (Eigen::Index k = 0; k < shapes.cols(); ++k)
    if (shapes.col(k).norm() > 0.0) shapes.col(k) *= std::sqrt(points_.rows()) / shapes.col(k).norm();
  return shapes;
}

/// As much of each shape as the calibration left unexplained, in units of the noise.
double LoadingEvidence::unexplainedOf() const {
  if (!(calibration_.repeatability > 0.0)) return 0.0;
  const double shapes = std::max<double>(1.0, static_cast<double>(points_.shapes().cols()));
  return leftUnexplained(points_, system_, calibration_) / std::sqrt(shapes) /
         (calibration_.repeatability * system_.white());
}

double LoadingEvidence::logMisfitOf(double left, int taken) const {
  const double tested = freedoms() - system_.freedoms() - taken;
  if (tested < 1.0) return 0.0;
  return logPValueF((left - system_.leftByAll()) / tested / system_.noise(), tested, system_.freedoms());
}

Eigen::MatrixXd LoadingEvidence::ofEffect(std::size_t e) const {
  std::vector<Eigen::MatrixXd> columns;
  for (std::size_t i = 0; i < points_.parameters().size(); ++i) {
    const Calibration::Value& v = calibration_.values[static_cast<std::size_t>(points_.parameters()[i])];
    if (v.effect == points_.indices()[e])
      columns.emplace_back(byParameter_.col(static_cast<Eigen::Index>(i)) * scaleOf(v));
  }
  return columns.empty() ? Eigen::MatrixXd(points_.length(), 0) : beside(columns);
}

Changes LoadingEvidence::changes(const LoadedHow& h) const {
  const Projection& known = asCalibrated_;
  const Eigen::VectorXd y = known.left(misses({h}));
  const std::size_t count = points_.effects().size();
  const double noise = system_.noise();
  std::vector<std::size_t> chosen;
  std::vector<double> pValues;
  std::vector<Eigen::MatrixXd> columns;
  for (std::size_t e = 0; e < count; ++e) columns.push_back(known.left(ofEffect(e)));
  const auto leftWith = [&](const std::vector<std::size_t>& set, int* rank) {
    if (set.empty()) return *rank = 0, y.squaredNorm();
    std::vector<Eigen::MatrixXd> parts;
    for (const std::size_t e : set) parts.push_back(columns[e]);
    const Eigen::MatrixXd q = orthonormalBasis(beside(parts));
    *rank = static_cast<int>(q.cols());
    return (y - q * (q.transpose() * y)).squaredNorm();
  };
  int rank = 0;
  double left = leftWith({}, &rank);
  while (chosen.size() < count) {
    double best = 0.0, bestLeft = left;
    int bestRank = rank;
    std::size_t which = count;
    for (std::size_t e = 0; e < count; ++e) {
      if (std::find(chosen.begin(), chosen.end(), e) != chosen.end() || columns[e].cols() == 0) continue;
      std::vector<std::size_t> with = chosen;
      with.push_back(e);
      int more = 0;
      const double rest = leftWith(with, &more);
      if (more <= rank) continue;
      const double p = logPValueF((left - rest) / (more - rank) / noise, more - rank, system_.freedoms());
      if (p < best) best = p, bestLeft = rest, bestRank = more, which = e;
    }
    if (which == count || best > kChanged - std::log(static_cast<double>(count))) break;
    chosen.push_back(which);
    pValues.push_back(std::exp(best));
    left = bestLeft;
    rank = bestRank;
  }
  Changes found;
  found.unexplainedPValue = std::exp(logMisfitOf(left, rank));
  found.score = h.logPrior - 0.5 * freedoms() * std::log(left) - 0.5 * rank * std::log(points_.rows()) -
                static_cast<double>(chosen.size()) * std::log(static_cast<double>(count));
  if (chosen.empty()) return found;
  std::vector<Eigen::MatrixXd> parts;
  for (const std::size_t e : chosen) parts.push_back(columns[e]);
  const Shares shares = sharesOf(beside(parts), y);
  // Machines change by about half of an error, seldom by much more (Jeffreys 1961, 5.2: Cauchy).
  for (const double change : shares.value) found.score -= std::log1p(std::pow(change / kDrifts, 2));
  Eigen::Index column = 0;
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    ChangedEffect changed;
    const int effect = points_.indices()[chosen[c]];
    changed.effect = calibration_.effects[static_cast<std::size_t>(effect)];
    changed.pValue = pValues[c];
    for (const Calibration::Value& v : calibration_.values)
      if (v.effect == effect) {
        const double unit = scaleOf(v) * v.toUnit;
        changed.parameters.push_back(
            {v.name, v.unit, shares.value[column] * unit, shares.std[column] * unit});
        ++column;
      }
    found.effects.push_back(std::move(changed));
  }
  return found;
}

}  // namespace mm
