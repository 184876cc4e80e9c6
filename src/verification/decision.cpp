#include "verification/decision.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimation/thin_qr.h"
#include "verification/verify_words.h"

namespace mm {
namespace {

constexpr double kSeen = 5.0;            // standard deviations of noise that a correction must be large
const double kMisfit = std::log(1e-5);   // chance to say in vain that something changed
const double kChanged = std::log(1e-4);  // that it was this effect, all effects together
const double kNotExcluded = std::log(20.0);
constexpr double kDrifts = 0.5;     // usual change of a parameter, of itself
constexpr double kShareStd = 10.0;  // of a share, before any data: anything is possible

/// Root of a covariance, also of a singular one.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& covariance) {
  // Parameters differ by many powers of ten: the root is taken of correlations.
  const Eigen::VectorXd std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(std.size(), std.size());
  for (Eigen::Index i = 0; i < std.size(); ++i)
    for (Eigen::Index j = 0; j < std.size(); ++j)
      if (i != j)
        correlation(i, j) = std[i] > 0.0 && std[j] > 0.0 ? covariance(i, j) / (std[i] * std[j]) : 0.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  return std.asDiagonal() * eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// Least squares of one column on others that a projection has left, with unit noise and a wide prior.
struct Shares {
  Eigen::VectorXd value, std;
};
Shares sharesOf(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  Eigen::MatrixXd normal = columns.transpose() * columns;
  normal.diagonal().array() += 1.0 / (kShareStd * kShareStd);
  const Eigen::MatrixXd covariance =
      normal.ldlt().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
  return {covariance * (columns.transpose() * y), covariance.diagonal().cwiseMax(0.0).cwiseSqrt()};
}

/// What the decision is made in.
class Court {
 public:
  Court(const FreshPoints& points, const PointSystem& system, const Calibration& calibration)
      : points_(points), system_(system), calibration_(calibration) {
    covariance_ = covarianceOf(points, calibration);
    byParameter_ = system.whiten(points.byParameter());
    known_ = scattering(covariance_);
    const double unexplained = unexplainedOf();
    if (unexplained > 0.0) known_ = beside({known_, unexplained * unitShapes()});
  }

  /// As calibrated, to within its uncertainty.
  Projection asCalibrated() const { return Projection(system_.base(), known_); }
  /// Changed since, by as much as machines do.
  Projection changedSince() const {
    Eigen::MatrixXd covariance = covariance_;
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      const double value =
          calibration_.values[static_cast<std::size_t>(points_.parameters()[static_cast<std::size_t>(i)])]
              .value;
      covariance(i, i) += kDrifts * kDrifts * value * value;
    }
    return Projection(system_.base(), beside({scattering(covariance), system_.whiten(points_.shapes())}));
  }

  /// Log likelihood of each hypothesis, with its prior; the scale of the noise integrated out.
  std::vector<double> scores(const Projection& projection, const std::vector<LoadedHow>& all) const {
    const Eigen::MatrixXd left = projection.left(misses(all));
    const double freedoms = points_.length() - static_cast<double>(system_.base().cols());
    std::vector<double> scores;
    for (std::size_t h = 0; h < all.size(); ++h)
      scores.push_back(all[h].logPrior -
                       0.5 * freedoms * std::log(left.col(static_cast<Eigen::Index>(h)).squaredNorm()));
    return scores;
  }

  /// Logarithm of the chance of such a misfit where the hypothesis and the calibration hold.
  double logMisfit(const Projection& projection, const LoadedHow& h) const {
    return logMisfitOf(projection.left(misses({h})).squaredNorm(), 0);
  }

  std::vector<ChangedEffect> changes(const LoadedHow& h, double* unexplained) const;

 private:
  Eigen::MatrixXd misses(const std::vector<LoadedHow>& all) const {
    Eigen::MatrixXd m(points_.length(), static_cast<Eigen::Index>(all.size()));
    for (std::size_t i = 0; i < all.size(); ++i)
      m.col(static_cast<Eigen::Index>(i)) = points_.raw() - all[i].field;
    return system_.whiten(m);
  }
  Eigen::MatrixXd scattering(const Eigen::MatrixXd& covariance) const {
    return byParameter_ * rootOf(covariance);
  }
  Eigen::MatrixXd unitShapes() const {
    Eigen::MatrixXd shapes = system_.whiten(points_.shapes());
    for (Eigen::Index k = 0; k < shapes.cols(); ++k)
      if (shapes.col(k).norm() > 0.0) shapes.col(k) *= std::sqrt(points_.rows()) / shapes.col(k).norm();
    return shapes;
  }
  /// What the calibration itself left unexplained, beside its noise and its drift: as much of each shape, in
  /// units of the noise.
  double unexplainedOf() const {
    const bool linear = std::isfinite(calibration_.heldOutRms);
    const double left = linear ? calibration_.heldOutRms : calibration_.heldOutRmsAngular;
    double square = left * left - calibration_.repeatability * calibration_.repeatability;
    constexpr double kDirections = 3.0;  // a residual sees a drift by its cosine, squared a third on average
    for (const Wandering& w : calibration_.drift) square -= w.std * w.std / kDirections;
    if (!(square > 0.0) || !(calibration_.repeatability > 0.0)) return 0.0;
    const double shapes = std::max<double>(1.0, static_cast<double>(points_.shapes().cols()));
    return std::sqrt(square / shapes) / (calibration_.repeatability * system_.white());
  }
  double logMisfitOf(double left, int taken) const {
    const double all = points_.length() - static_cast<double>(system_.base().cols());
    const double tested = all - system_.freedoms() - taken;
    if (tested < 1.0) return 0.0;
    const double noise = system_.leftByAll() / system_.freedoms();
    return logPValueF((left - system_.leftByAll()) / tested / noise, tested, system_.freedoms());
  }
  Eigen::MatrixXd ofEffect(std::size_t e) const {
    std::vector<Eigen::MatrixXd> columns;
    for (std::size_t i = 0; i < points_.parameters().size(); ++i) {
      const Calibration::Value& v = calibration_.values[static_cast<std::size_t>(points_.parameters()[i])];
      if (v.effect == points_.indices()[e])
        columns.emplace_back(byParameter_.col(static_cast<Eigen::Index>(i)) * scaleOf(v));
    }
    return columns.empty() ? Eigen::MatrixXd(points_.length(), 0) : beside(columns);
  }
  /// Size of a parameter that conditions the columns, SI.
  static double scaleOf(const Calibration::Value& v) {
    return std::max({std::abs(v.value), v.std, 1e-12 / std::max(1e-12, std::abs(v.toUnit))});
  }

  const FreshPoints& points_;
  const PointSystem& system_;
  const Calibration& calibration_;
  Eigen::MatrixXd covariance_, byParameter_, known_;
};

std::vector<ChangedEffect> Court::changes(const LoadedHow& h, double* unexplained) const {
  const Projection known = asCalibrated();
  Eigen::VectorXd y = known.left(misses({h}));
  const std::size_t count = points_.effects().size();
  const double noise = system_.leftByAll() / system_.freedoms();
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
  *unexplained = std::exp(logMisfitOf(left, rank));
  if (chosen.empty()) return {};
  std::vector<Eigen::MatrixXd> parts;
  for (const std::size_t e : chosen) parts.push_back(columns[e]);
  const Shares shares = sharesOf(beside(parts), y);
  std::vector<ChangedEffect> found;
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
    found.push_back(std::move(changed));
  }
  return found;
}

}  // namespace

Eigen::MatrixXd covarianceOf(const FreshPoints& points, const Calibration& calibration) {
  const auto count = static_cast<Eigen::Index>(points.parameters().size());
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      covariance(i, j) = calibration.covariance(points.parameters()[static_cast<std::size_t>(i)],
                                                points.parameters()[static_cast<std::size_t>(j)]);
  return covariance;
}

Decision decide(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded) {
  const Court court(points, system, calibration);
  const Projection asCalibrated = court.asCalibrated();
  std::vector<char> seen;
  for (int a = 0; a < static_cast<int>(points.axes().size()); ++a)
    seen.push_back(asCalibrated.left(system.whiten(points.own(a))).norm() > kSeen);
  const std::vector<LoadedHow> all = hypothesesOf(points, loaded, seen);
  Decision decision;
  decision.seen = std::any_of(seen.begin(), seen.end(), [](char s) { return s != 0; });
  std::vector<double> scores = court.scores(asCalibrated, all);
  const auto bestOf = [&] {
    return static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  };
  std::size_t best = decision.seen ? bestOf() : 0;
  // Something changed where one effect is not what it was, or where the whole does not fit.
  decision.changed = court.changes(all[best], &decision.unexplainedPValue);
  decision.drifted = !decision.changed.empty() || court.logMisfit(asCalibrated, all[best]) < kMisfit;
  if (decision.drifted && decision.seen) {
    scores = court.scores(court.changedSince(), all);
    const std::size_t before = best;
    best = bestOf();
    if (best != before) decision.changed = court.changes(all[best], &decision.unexplainedPValue);
  }
  decision.hypothesis = all[best];
  if (!decision.seen) return decision;
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  for (const std::size_t h : order)
    if (h != best && scores[best] - scores[h] < kNotExcluded) {
      decision.rivals.push_back(all[h]);
      decision.odds.push_back(std::exp(scores[h] - scores[best]));
    }
  return decision;
}

void fillShares(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded, Verification& found) {
  const Court court(points, system, calibration);
  const Projection projection = court.asCalibrated();
  const int count = static_cast<int>(points.axes().size());
  Eigen::MatrixXd own(points.length(), count);
  for (int a = 0; a < count; ++a) own.col(a) = points.own(a);
  const Eigen::VectorXd rest = points.whole() - own.rowwise().sum();
  const Eigen::VectorXd raw = points.raw() - (loaded ? 0.0 : 1.0) * rest;
  const Eigen::VectorXd y = projection.left(system.whiten(raw));
  const auto remaining = [&](double share) { return loaded ? share : 1.0 - share; };
  const double size = found.angular ? points.fitted().sigma.maxCoeff() : points.fitted().sigma.minCoeff();
  const auto sizeOf = [&](const Eigen::VectorXd& column) {
    return size * column.head(points.rows()).norm() / std::sqrt(static_cast<double>(points.rows()));
  };
  const Shares axes = sharesOf(projection.left(system.whiten(own)), y);
  for (int a = 0; a < count; ++a) {
    RemainingOfAxis axis;
    axis.axis = points.axes()[static_cast<std::size_t>(a)];
    axis.size = sizeOf(own.col(a));
    axis.remaining = remaining(axes.value[a]);
    axis.std = axes.std[a];
    axis.inWords = inWords(axis);
    found.axes.push_back(axis);
  }
  const Eigen::VectorXd all = projection.left(system.whiten(points.raw()));
  const Shares effects = sharesOf(projection.left(system.whiten(points.byEffect())), all);
  for (std::size_t e = 0; e < points.effects().size(); ++e) {
    const auto k = static_cast<Eigen::Index>(e);
    RemainingOfEffect effect;
    effect.effect = calibration.effects[static_cast<std::size_t>(points.indices()[e])];
    effect.size = sizeOf(points.byEffect().col(k));
    effect.remaining = remaining(effects.value[k]);
    effect.std = effects.std[k];
    effect.inWords = inWords(effect);
    found.effects.push_back(effect);
  }
  const Shares crossed = sharesOf(projection.left(system.whiten(points.crossed())), y);
  constexpr double kThere = 4.0, kTold = 0.25;
  for (int on = 0; on < count; ++on)
    for (int of = 0; of < count; ++of) {
      const int k = on * count + of;
      if (on == of || !(crossed.std[k] < kTold) || std::abs(crossed.value[k]) < kThere * crossed.std[k])
        continue;
      found.crossed.push_back({points.axes()[static_cast<std::size_t>(of)],
                               points.axes()[static_cast<std::size_t>(on)],
                               loaded ? -crossed.value[k] : crossed.value[k], crossed.std[k]});
    }
}

}  // namespace mm
