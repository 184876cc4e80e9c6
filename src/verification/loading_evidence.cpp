#include "verification/loading_evidence.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/covariance_root.h"
#include "base/dense.h"
#include "estimation/noise_rows.h"
#include "estimation/thin_qr.h"
#include "verification/figures.h"
#include "verification/verify_words.h"

namespace mm {
namespace {

constexpr double kLeast = 1e-12;  // in the unit of a parameter: none is smaller

const double kChanged = std::log(1e-4);  // chance to say in vain that an effect changed, all effects together
constexpr double kDrifts = 0.5;          // usual change of a parameter, of itself
constexpr double kShareStd = 10.0;       // of a share, before any data: anything is possible

constexpr double kSeen = 5.0;           // standard deviations of noise that a correction must be large
const double kMisfit = std::log(1e-5);  // chance to say in vain that something changed
const double kNotExcluded = std::log(20.0);

/// Shares of columns in another one.
struct Shares {
  Eigen::VectorXd value, std;
};

/// Least squares of one column on others that a projection has left, with unit noise and a wide prior.
Shares sharesOf(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  Eigen::MatrixXd normal = columns.transpose() * columns;
  normal.diagonal().array() += 1.0 / (kShareStd * kShareStd);
  const Eigen::MatrixXd covariance = inverseOfSymmetric(normal);
  return {covariance * (columns.transpose() * y), covariance.diagonal().cwiseMax(0.0).cwiseSqrt()};
}

/// Indices of the hypotheses, the best first.
std::vector<std::size_t> orderOf(const std::vector<double>& scores) {
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  return order;
}

/// Size of a parameter that conditions the columns, SI.
double scaleOf(const Calibration::Value& v) {
  return std::max({std::abs(v.value), v.std, kLeast / std::max(kLeast, std::abs(v.toUnit))});
}

/// Mean over the residuals of one kind of what of(i) says of the i-th row in use; 0 without any.
template <typename Of>
double meanOf(const FreshPoints& points, bool angular, Of of) {
  double sum = 0.0;
  int rows = 0;
  for (int i = 0; i < points.rows(); ++i) {
    if (points.row(i).angular != angular) continue;
    sum += of(i);
    ++rows;
  }
  return rows > 0 ? sum / rows : 0.0;
}

/// What a drift of size 1 along a direction adds to the mean square of the residuals of one kind: the mean
/// square of its cosines, or of its levers.
double seenOf(const std::string& direction, const FreshPoints& points, bool angular) {
  const Directions directions = directionsOf(points.space().linearisation(), points.space().used());
  const auto found = std::find(directions.names.begin(), directions.names.end(), direction);
  if (found == directions.names.end()) return 0.0;
  const auto column = found - directions.names.begin();
  return meanOf(points, angular, [&](Eigen::Index i) { return std::pow(directions.factors(i, column), 2); });
}

/// Variance of the noise of these points, m^2 or rad^2, on average of the residuals of one kind.
double scatterOf(const FreshPoints& points, const PointSystem& system, bool angular) {
  const Eigen::VectorXd variance = system.variances();
  return meanOf(points, angular, [&](Eigen::Index i) {
    const int row = points.space().used()[i];
    return std::pow(points.fitted().sigma[row], 2) * variance[i];
  });
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

LoadingEvidence::LoadingEvidence(const FreshPoints& points, const PointSystem& system,
                                 const Calibration& calibration)
    : points_(points),
      system_(system),
      calibration_(calibration),
      covariance_(covarianceOf(points, calibration)),
      byParameter_(system.whiten(points.byParameter())),
      asCalibrated_(system.base(), beside({scattering(covariance_), unexplainedShapes()})) {}

Projection LoadingEvidence::changedSince() const {
  Eigen::MatrixXd covariance = covariance_;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    const double value = calibration_.values[points_.parameters()[i]].value;
    covariance(i, i) += kDrifts * kDrifts * value * value;
  }
  return Projection(system_.base(), beside({scattering(covariance), system_.whiten(points_.shapes())}));
}

std::vector<double> LoadingEvidence::scores(const Projection& projection,
                                            const std::vector<LoadedHow>& all) const {
  const Eigen::MatrixXd left = projection.left(misses(all));
  std::vector<double> scores;
  for (std::size_t h = 0; h < all.size(); ++h)
    scores.push_back(all[h].logPrior - 0.5 * freedoms() * std::log(left.col(h).squaredNorm()));
  return scores;
}

Eigen::MatrixXd LoadingEvidence::misses(const std::vector<LoadedHow>& all) const {
  Eigen::MatrixXd m(points_.length(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) m.col(i) = points_.raw() - all[i].field;
  return system_.whiten(m);
}

Eigen::MatrixXd LoadingEvidence::scattering(const Eigen::MatrixXd& covariance) const {
  return byParameter_ * rootOfCovariance(covariance);
}

Eigen::MatrixXd LoadingEvidence::unexplainedShapes() const {
  Eigen::MatrixXd shapes = system_.whiten(points_.shapes());
  for (Eigen::Index k = 0; k < shapes.cols(); ++k)
    if (shapes.col(k).norm() > 0.0) shapes.col(k) *= std::sqrt(points_.rows()) / shapes.col(k).norm();
  if (!(calibration_.repeatability > 0.0)) return 0.0 * shapes;
  const double count = std::max<double>(1.0, shapes.cols());
  return leftUnexplained(points_, system_, calibration_) / std::sqrt(count) /
         (calibration_.repeatability * system_.white()) * shapes;
}

Eigen::MatrixXd LoadingEvidence::ofEffect(std::size_t e) const {
  std::vector<Eigen::MatrixXd> columns;
  for (std::size_t i = 0; i < points_.parameters().size(); ++i) {
    const Calibration::Value& v = calibration_.values[points_.parameters()[i]];
    if (v.effect == points_.indices()[e]) columns.emplace_back(byParameter_.col(i) * scaleOf(v));
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
    *rank = q.cols();
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
    if (which == count || best > kChanged - std::log(count)) break;
    chosen.push_back(which);
    pValues.push_back(std::exp(best));
    left = bestLeft;
    rank = bestRank;
  }
  Changes found;
  const double tested = freedoms() - system_.freedoms() - rank;
  if (tested >= 1.0)
    found.unexplainedPValue =
        std::exp(logPValueF((left - system_.leftByAll()) / tested / noise, tested, system_.freedoms()));
  found.score = h.logPrior - 0.5 * freedoms() * std::log(left) - 0.5 * rank * std::log(points_.rows()) -
                chosen.size() * std::log(count);
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
    changed.effect = calibration_.effects[effect];
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

Eigen::MatrixXd covarianceOf(const FreshPoints& points, const Calibration& calibration) {
  return calibration.covariance(points.parameters(), points.parameters());
}

Decision decide(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded) {
  const LoadingEvidence evidence(points, system, calibration);
  std::vector<char> seen;
  for (int a = 0; a < points.axisCount(); ++a)
    seen.push_back(evidence.asCalibrated().left(system.whiten(points.own(a))).norm() > kSeen);
  Decision decision;
  decision.tablesSeen = std::any_of(seen.begin(), seen.end(), [](char s) { return s != 0; });
  decision.offsetsSeen =
      points.hasOffsets() && evidence.asCalibrated().left(system.whiten(points.offsets())).norm() > kSeen;
  const bool anySeen = decision.tablesSeen || decision.offsetsSeen;
  const std::vector<LoadedHow> all = hypothesesOf(points, loaded, seen, decision.offsetsSeen);
  std::vector<std::optional<Changes>> asked(all.size());  // what changed since, as far as it was asked
  const auto changesOf = [&](std::size_t h) -> const Changes& {
    if (!asked[h]) asked[h] = evidence.changes(all[h]);
    return *asked[h];
  };
  std::vector<double> scores = evidence.scores(evidence.asCalibrated(), all);
  std::size_t best = anySeen ? orderOf(scores).front() : 0;
  // Something changed where one effect is not what it was, or where the whole does not fit; or where that is
  // likelier than tables at the wrong place, which can look like it.
  const auto changedUnder = [&](std::size_t h) {
    return !changesOf(h).effects.empty() || std::log(changesOf(h).unexplainedPValue) < kMisfit;
  };
  decision.drifted = changedUnder(best) || (best != 0 && changesOf(0).score > scores[best]);
  if (decision.drifted && anySeen) {
    scores = evidence.scores(evidence.changedSince(), all);
    best = orderOf(scores).front();
  }
  decision.changed = changesOf(best).effects;
  decision.unexplainedPValue = changesOf(best).unexplainedPValue;
  decision.hypothesis = all[best];
  constexpr std::size_t kMostRivals = 4;
  for (const std::size_t h : orderOf(scores))
    if (anySeen && h != best && scores[best] - scores[h] < kNotExcluded &&
        decision.rivals.size() < kMostRivals)
      decision.rivals.push_back({inWords(all[h], points.axes(), loaded), std::exp(scores[h] - scores[best])});
  return decision;
}

void fillShares(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded, Verification& found) {
  const LoadingEvidence evidence(points, system, calibration);
  const Projection& projection = evidence.asCalibrated();
  const int count = points.axisCount();
  Eigen::MatrixXd own(points.length(), count + (points.hasOffsets() ? 1 : 0));
  for (int a = 0; a < count; ++a) own.col(a) = points.own(a);
  if (points.hasOffsets()) own.col(count) = points.offsets();
  const bool restIsThere = !loaded || points.tabled();  // no table has it
  const Eigen::VectorXd raw = points.raw() - (restIsThere ? 1.0 : 0.0) * points.rest();
  const Eigen::VectorXd y = projection.left(system.whiten(raw));
  const auto fill = [&](auto& to, double size, const Shares& of, Eigen::Index k) {
    to.size = size;
    to.remaining = loaded ? of.value[k] : 1.0 - of.value[k];
    to.std = of.std[k];
    to.inWords = inWords(to);
  };
  const Eigen::VectorXd ownSizes = rmsOf(points, own), effectSizes = rmsOf(points, points.byEffect());
  const Shares axes = sharesOf(projection.left(system.whiten(own)), y);
  for (int a = 0; a < count; ++a) {
    RemainingOfAxis& axis = found.axes.emplace_back();
    axis.axis = points.axes()[a];
    fill(axis, ownSizes[a], axes, a);
  }
  if (points.hasOffsets()) fill(found.offsets.emplace(), ownSizes[count], axes, count);
  const Eigen::MatrixXd columns = projection.left(system.whiten(points.byEffect()));
  const Eigen::VectorXd notCarried =
      points.tabled() ? sharesOf(columns, projection.left(system.whiten(points.rest()))).value
                      : Eigen::VectorXd::Zero(columns.cols());
  // Without tables of an export nothing is carried apart: the effects have what no axis shows, too.
  const Eigen::VectorXd carried = (1.0 - notCarried.array()).cwiseMax(0.0);
  const Shares effects =
      sharesOf(columns * carried.asDiagonal(),
               points.tabled() ? y : Eigen::VectorXd(projection.left(system.whiten(points.raw()))));
  for (std::size_t e = 0; e < points.effects().size(); ++e) {
    RemainingOfEffect& effect = found.effects.emplace_back();
    effect.effect = calibration.effects[points.indices()[e]];
    effect.notCarried = notCarried[e];
    fill(effect, effectSizes[e], effects, e);
  }
  // What the offsets leave is no other axis's correction.
  const Shares crossed = sharesOf(
      projection.left(system.whiten(beside({points.crossed(), own.rightCols(own.cols() - count)}))), y);
  constexpr double kThere = 4.0, kTold = 0.25;
  for (int on = 0; on < count; ++on)
    for (int of = 0; of < count; ++of) {
      const int k = on * count + of;
      if (on == of || !(crossed.std[k] < kTold) || std::abs(crossed.value[k]) < kThere * crossed.std[k])
        continue;
      found.crossed.push_back({points.axes()[of], points.axes()[on],
                               loaded ? -crossed.value[k] : crossed.value[k], crossed.std[k]});
    }
}

}  // namespace mm
