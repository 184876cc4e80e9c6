#include "session/agreement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "session/geometric_start.h"
#include "session/sphere_centre.h"

namespace mm {
namespace {

/// RMS without the largest twentieth: a few outliers do not hide that the rest agrees.
double trimmed(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t kept = std::max<std::size_t>(1, values.size() - values.size() / 20);
  double sum = 0.0;
  for (std::size_t i = 0; i < kept; ++i) sum += values[i] * values[i];
  return std::sqrt(sum / static_cast<double>(kept));
}

/// What is left between points (m), where `from` may be moved if it is free. @param turn gets by how
/// much it was turned, rad.
Eigen::Matrix3Xd misfit(const PointPairs& pairs, bool free, double& turn) {
  const Eigen::Matrix3Xd from = columnsOfPoints(pairs.from), to = columnsOfPoints(pairs.to);
  const RigidMotion motion = free ? rigidMotion(from, to) : RigidMotion();
  turn = Eigen::AngleAxisd(motion.rotation).angle();
  return to - ((motion.rotation * from).colwise() + motion.translation);
}

}  // namespace

Geometry::Geometry(const Session& session) : session_(session), of_(session.artifact.features.size()) {
  std::map<std::pair<int, int>, std::size_t> counts;
  for (const Observation& o : session.observations) ++counts[{o.placement, o.stylus}];
  std::size_t most = 0;
  for (const auto& [at, count] : counts)
    if (count > most) most = count, std::tie(placement_, stylus_) = at;
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const Observation& o = session.observations[i];
    if (o.placement != placement_ || o.stylus != stylus_) continue;
    if (o.kind == ObservationKind::kContact) of_[o.feature].push_back(&o);
    if (o.kind == ObservationKind::kPosition && o.reference.allFinite()) positions_.push_back(&o);
  }
  constexpr std::size_t kEnough = 200;  // of one ball: more would say the same
  const auto thin = [&](std::vector<const Observation*>& rows) {
    const std::size_t all = rows.size();
    for (std::size_t k = 0; all > kEnough && k < kEnough; ++k) rows[k] = rows[k * all / kEnough];
    rows.resize(std::min(all, kEnough));
  };
  thin(positions_);
  for (auto& rows : of_) thin(rows);
}

Agreement Geometry::judge(const Change& change) const {
  Agreement a;
  a.centres.assign(of_.size(), Eigen::Vector3d::Constant(kNotMeasured));
  std::vector<double> within;
  double aligned = 0.0;
  int approaches = 0;
  for (std::size_t f = 0; f < of_.size(); ++f)
    if (!of_[f].empty()) judgeFeature(f, change, a, within, aligned, approaches);
  if (approaches > 0) a.aligned = aligned / approaches;
  a.misfit = std::hypot(trimmed(within), layout(a.centres, names(), a));
  const double instrument = positions(change);
  if (std::isfinite(instrument)) a.misfit = std::hypot(a.misfit, instrument);
  if (within.empty() && !std::isfinite(instrument)) a.misfit = kNotMeasured;
  return a;
}

/// The tips on one ball, or about one point.
void Geometry::judgeFeature(std::size_t f, const Change& change, Agreement& a, std::vector<double>& within,
                            double& aligned, int& approaches) const {
  const Feature& feature = session_.artifact.features[f];
  std::vector<Eigen::Vector3d> tips;
  for (const Observation* o : of_[f]) tips.push_back(tipOf(*o, change));
  Eigen::Vector3d centre = meanOf(tips);
  double extent = 0.0;
  for (const auto& t : tips) extent = std::max(extent, (t - centre).norm());
  const bool ball = feature.kind == FeatureKind::kBall;
  double distance = 0.0;
  if (ball) {
    distance = feature.radius +
               (std::isnan(of_[f].front()->laserReading) ? session_.artifact.tipRadiusOf(stylus_) : 0.0);
    constexpr std::size_t kDetermining = 5;
    if (tips.size() < kDetermining || !sphereCentre(tips, distance, centre)) return;
    a.cap = std::min(a.cap, extent / distance);
  }
  for (const auto& t : tips) within.push_back(std::abs((t - centre).norm() - distance));
  a.centres[f] = centre;
  for (std::size_t i = 0; ball && i < tips.size(); ++i) {
    const Eigen::Vector3d& approach = of_[f][i]->approach;
    if (!approach.allFinite() || approach.norm() < 0.5 || !std::isnan(of_[f][i]->laserReading)) continue;
    aligned += approach.normalized().dot((centre - tips[i]).normalized());
    ++approaches;
  }
}

double Geometry::layout(const std::vector<Eigen::Vector3d>& centres, const std::vector<int>& names,
                        Agreement& turned) const {
  PointPairs pairs;
  for (std::size_t f = 0; f < centres.size(); ++f) {
    const Feature& feature = session_.artifact.features[static_cast<std::size_t>(names[f])];
    if (feature.known && centres[f].allFinite()) pairs.add(feature.position, centres[f]);
  }
  const bool free = session_.poseFree(placement_);
  constexpr std::size_t kLayout = 3;
  if (pairs.from.size() < (free ? kLayout : 1)) return 0.0;
  turned.cap = INFINITY;  // the layout says how large everything is
  const Eigen::Matrix3Xd off = misfit(pairs, free, turned.turn);
  return std::sqrt(off.squaredNorm() / static_cast<double>(off.size()));
}

double Geometry::travelling(const Agreement& base, const Change& change) const {
  double aligned = 0.0;
  int touches = 0;
  for (std::size_t f = 0; f < of_.size(); ++f) {
    if (session_.artifact.features[f].kind != FeatureKind::kBall || !base.centres[f].allFinite()) continue;
    for (const Observation* o : of_[f]) {
      if (!std::isnan(o->laserReading)) continue;
      std::vector<double> velocity = o->velocity;
      std::replace_if(
          velocity.begin(), velocity.end(), [](double v) { return std::isnan(v); }, 0.0);
      if (change) change(velocity);
      const Eigen::Map<const Eigen::VectorXd> speeds(velocity.data(),
                                                     static_cast<Eigen::Index>(velocity.size()));
      const Eigen::Vector3d motion =
          session_.machine.jacobian(o->position.data(), kNotMeasured).topRows<3>() * speeds;
      if (motion.isZero(0.0)) continue;
      aligned += motion.normalized().dot((base.centres[f] - tipOf(*o, {})).normalized());
      ++touches;
    }
  }
  return touches > 0 ? aligned / touches : kNotMeasured;
}

std::vector<int> Geometry::names() const {
  std::vector<int> own(of_.size());
  std::iota(own.begin(), own.end(), 0);
  return own;
}

Eigen::Vector3d Geometry::tipOf(const Observation& o, const Change& change) const {
  if (!change) return session_.nominalProbe(o).position;
  Observation changed = o;
  change(changed.position);
  return session_.nominalProbe(changed).position;
}

/// What an independent instrument found of the tip's position, NaN without.
double Geometry::positions(const Change& change) const {
  constexpr std::size_t kFew = 5;
  if (positions_.size() < kFew) return kNotMeasured;
  PointPairs pairs;
  for (const Observation* o : positions_) pairs.add(o->reference, tipOf(*o, change));
  double turn = 0.0;
  const Eigen::Matrix3Xd off = misfit(pairs, session_.poseFree(placement_), turn);
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < off.cols(); ++i) distances.push_back(off.col(i).norm());
  return trimmed(std::move(distances)) / std::sqrt(3.0);
}

}  // namespace mm
