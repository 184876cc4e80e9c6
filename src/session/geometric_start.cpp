#include "session/geometric_start.h"

#include <Eigen/Geometry>
#include <map>
#include <tuple>

#include "base/dense.h"
#include "base/error.h"
#include "session/sphere_centre.h"

namespace mm {
namespace {

/// Points that lie closer together than machines err, or across a line than a thousandth of its length, tell
/// no rotation: there it is the smallest, as axes of an instrument are set up along those of the machine.
constexpr double kOnePlace = 50e-6;  // m
constexpr double kOneLine = 1e-3;

/// What one stylus touched of one feature in one placement.
struct Spot {
  int feature = 0, placement = 0, stylus = 0;
  std::vector<Eigen::Vector3d> tips, approaches;
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  // of the probe, at its first contact
  bool laser = false;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // in workpiece, without the stylus' offset if unknown
};

class Start {
 public:
  explicit Start(const Session& session) : session_(session) {}

  GeometricStart make() {
    findSpots();
    findOffsets();
    out_.poses.resize(static_cast<std::size_t>(session_.placementCount()));
    for (const Feature& f : session_.artifact.features)
      out_.features.push_back(f.position), known_.push_back(f.known);
    // a placement that shares the most with what is known comes next: what is free in it is known then
    std::vector<char> placed(out_.poses.size(), 0);
    for (std::size_t k = 0; k < placed.size(); ++k) {
      std::size_t next = 0;
      int most = -1;
      for (std::size_t p = 0; p < placed.size(); ++p) {
        const int shared = placed[p] ? -1 : static_cast<int>(pairsOf(static_cast<int>(p)).from.size());
        if (shared > most) most = shared, next = p;
      }
      place(static_cast<int>(next));
      placed[next] = 1;
    }
    return std::move(out_);
  }

 private:
  /// Where the tip is, or probe_tip where the offset of the stylus is to be found.
  Eigen::Vector3d placeOf(const Observation& o) const {
    const auto& styli = session_.artifact.styli;
    const bool known = styli.empty() || styli[static_cast<std::size_t>(o.stylus)].known;
    return known ? session_.nominalProbe(o).position
                 : session_.machine.nominal(o.position.data(), o.laserReading).position;
  }

  void findSpots() {
    std::map<std::tuple<int, int, int>, std::size_t> number;
    for (const Observation& o : session_.observations) {
      if (o.kind != ObservationKind::kContact || o.feature < 0) continue;
      const auto [at, isNew] =
          number.try_emplace(std::tuple(o.feature, o.placement, o.stylus), spots_.size());
      if (isNew)
        spots_.push_back({o.feature, o.placement, o.stylus, {}, {}, session_.nominalProbe(o).orientation});
      Spot& spot = spots_[at->second];
      spot.tips.push_back(placeOf(o));
      if (o.laserReading == o.laserReading) spot.laser = true;
      if (o.approach.allFinite() && o.approach.norm() > 0.5)
        spot.approaches.push_back(o.approach.normalized());
    }
    std::vector<Spot> found;
    for (Spot& spot : spots_)
      if (findCentre(spot)) found.push_back(std::move(spot));
    spots_ = std::move(found);
  }

  bool findCentre(Spot& spot) const {
    const Feature& feature = session_.artifact.features[static_cast<std::size_t>(spot.feature)];
    if (feature.kind == FeatureKind::kPoint) {
      spot.centre = meanOf(spot.tips);
      return true;
    }
    const double distance = feature.radius + (spot.laser ? 0.0 : session_.artifact.tipRadiusOf(spot.stylus));
    bool found = false;
    if (spot.approaches.size() == spot.tips.size()) {
      Eigen::Vector3d centre = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < spot.tips.size(); ++i)
        centre += spot.tips[i] + distance * spot.approaches[i];
      spot.centre = centre / static_cast<double>(spot.tips.size());
      found = true;
    }
    Eigen::Vector3d fitted;
    if (sphereCentre(spot.tips, distance, fitted)) {
      // the mirror image of a shallow cap fits too: trust the approach where there is one
      if (!found || (fitted - spot.centre).norm() < distance) spot.centre = fitted;
      found = true;
    }
    return found;
  }

  /// An offset that is not stated: by the features that another stylus touched in the same placement.
  void findOffsets() {
    const auto& styli = session_.artifact.styli;
    std::vector<char> known;
    for (const Stylus& s : styli) out_.offsets.push_back(s.offset), known.push_back(s.known);
    if (styli.empty()) out_.offsets.emplace_back(Eigen::Vector3d::Zero()), known.push_back(1);
    for (bool found = true; found;) {
      found = false;
      for (std::size_t s = 0; s < known.size(); ++s) {
        if (known[s]) continue;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        int count = 0;
        for (const Spot& mine : spots_)
          for (const Spot& other : spots_) {
            if (mine.stylus != static_cast<int>(s) || !known[static_cast<std::size_t>(other.stylus)] ||
                mine.feature != other.feature || mine.placement != other.placement)
              continue;
            sum += mine.orientation.transpose() * (other.centre - mine.centre);
            ++count;
          }
        if (count == 0) continue;
        out_.offsets[s] = sum / count;
        for (Spot& mine : spots_)
          if (mine.stylus == static_cast<int>(s)) mine.centre += mine.orientation * out_.offsets[s];
        known[s] = 1;
        found = true;
      }
    }
    for (std::size_t s = 0; s < known.size(); ++s)
      if (!known[s] && !out_.offsets[s].allFinite()) out_.offsets[s].setZero();
    for (Spot& spot : spots_)
      if (!known[static_cast<std::size_t>(spot.stylus)])
        spot.centre += spot.orientation * out_.offsets[static_cast<std::size_t>(spot.stylus)];
  }

  /// What is known in the artifact's frame and was found in a placement.
  PointPairs pairsOf(int placement) const {
    PointPairs pairs;
    for (const Spot& spot : spots_)
      if (spot.placement == placement && known_[static_cast<std::size_t>(spot.feature)])
        pairs.add(out_.features[static_cast<std::size_t>(spot.feature)], spot.centre);
    for (const Observation& o : session_.observations)
      if (o.kind == ObservationKind::kPosition && o.placement == placement && o.reference.allFinite())
        pairs.add(o.reference, out_.tipOf(session_, o));
    return pairs;
  }

  void place(int placement) {
    RigidMotion& pose = out_.poses[static_cast<std::size_t>(placement)];
    if (session_.poseFree(placement)) {
      const PointPairs pairs = pairsOf(placement);
      if (!pairs.from.empty()) pose = rigidMotion(columnsOfPoints(pairs.from), columnsOfPoints(pairs.to));
    }
    for (const Spot& spot : spots_) {
      const auto f = static_cast<std::size_t>(spot.feature);
      if (spot.placement != placement || known_[f]) continue;
      out_.features[f] = pose.rotation.transpose() * (spot.centre - pose.translation);
      known_[f] = 1;
    }
  }

  const Session& session_;
  std::vector<Spot> spots_;
  std::vector<char> known_;  // a feature: it is where it is said to be in the artifact's frame
  GeometricStart out_;
};

/// A pivot below this part of the largest: contacts on a flat patch say too little about the centre.
constexpr double kFlatPatch = 1e-3;

/// Lengths to tips.
struct Lengths {
  std::vector<Eigen::Vector3d> tips;
  std::vector<double> lengths;  // m
  bool fromZero = false;        // all are too long by one unknown length
};

/// Where they begin; nothing where they do not determine it: tips on a plane have a mirror image.
std::optional<Eigen::Vector3d> beginOf(const Lengths& all) {
  constexpr double kPlane = 1e-4;  // below it noise of a ten thousandth of the extent would decide
  const auto n = static_cast<Eigen::Index>(all.tips.size());
  const Eigen::Vector3d mean = meanOf(all.tips);
  double size = 0.0, usual = 0.0;
  for (const auto& tip : all.tips) size = std::max(size, (tip - mean).norm());
  for (const double length : all.lengths) usual += length / static_cast<double>(n);
  // |tip - begin|^2 = (l + m)^2 with l a length less the usual one, and m the usual one less the zero: linear
  // in begin, m and m^2 - begin^2
  Eigen::MatrixXd a(n, all.fromZero ? 5 : 4);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d d = (all.tips[static_cast<std::size_t>(i)] - mean) / size;
    const double l = (all.lengths[static_cast<std::size_t>(i)] - usual) / size;
    a.row(i).head<4>() << 2.0 * d.transpose(), 1.0;
    b[i] = d.squaredNorm() - l * l - (all.fromZero ? 0.0 : 2.0 * l * usual / size);
    if (all.fromZero) a(i, 4) = 2.0 * l;
  }
  if (n < a.cols() || !(size > 0.0) || rankOf(a, kPlane) < a.cols()) return std::nullopt;
  return mean + size * leastSquares(a, b).head<3>();
}

/// The sphere through the tips; their mean where they do not determine one.
Eigen::Vector3d centreOf(const std::vector<Eigen::Vector3d>& tips) {
  const Eigen::Vector3d mean = meanOf(tips);
  double size = 0.0;
  for (const auto& tip : tips) size = std::max(size, (tip - mean).norm());
  return algebraicSphereCentre(tips, size, kFlatPatch).value_or(mean);
}

}  // namespace

void startFreeFeatures(Session& session) {
  for (std::size_t f = 0; f < session.artifact.features.size(); ++f) {
    Feature& feature = session.artifact.features[f];
    if (feature.known || !feature.position.hasNaN()) continue;
    Lengths touched, measured;
    const Observation* first = nullptr;  // of the placement and stylus by which it is told
    for (const Observation& o : session.observations) {
      if (o.feature != static_cast<int>(f)) continue;
      if (first == nullptr) first = &o;
      if (o.placement != first->placement || o.stylus != first->stylus) continue;
      Lengths& mine = o.kind == ObservationKind::kLength ? measured : touched;
      if (o.kind == ObservationKind::kLength && o.setup != first->setup) continue;  // of another zero
      mine.tips.push_back(session.nominalProbe(o).position);
      mine.lengths.push_back(o.length);
      mine.fromZero = o.setup >= 0;
    }
    if (!touched.tips.empty()) {
      feature.position = feature.kind == FeatureKind::kBall ? centreOf(touched.tips) : meanOf(touched.tips);
    } else if (measured.tips.empty()) {
      feature.position.setZero();
    } else if (const auto begin = beginOf(measured)) {
      feature.position = *begin;
    } else {
      throw InputError(session.source + ": where '" + feature.name + "' is cannot be determined from its " +
                       std::to_string(measured.tips.size()) +
                       " lengths (too few, or all tip positions on a plane); give its approximate position "
                       "in the artifact file: position_mm: [x, y, z]");
    }
  }
}

Eigen::Matrix3Xd columnsOfPoints(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = points[i];
  return columns;
}

RigidMotion rigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::Vector3d a = from.rowwise().mean(), b = to.rowwise().mean();
  const Eigen::Matrix3Xd around = from.colwise() - a;
  RigidMotion motion;
  const double none =
      static_cast<double>(from.cols()) * kOnePlace * kOnePlace + kOneLine * kOneLine * around.squaredNorm();
  const Eigen::Matrix3d both = (to.colwise() - b) * around.transpose();
  constexpr int kExact = 4;  // each time what the points tell is held back by `none` less
  for (int k = 0; k < kExact; ++k) motion.rotation = nearestRotation(both + none * motion.rotation);
  motion.translation = b - motion.rotation * a;
  return motion;
}

Eigen::Vector3d GeometricStart::inWorkpiece(int feature, int placement) const {
  const RigidMotion& pose = poses[static_cast<std::size_t>(placement)];
  return pose.rotation * features[static_cast<std::size_t>(feature)] + pose.translation;
}

Eigen::Vector3d GeometricStart::tipOf(const Session& session, const Observation& o) const {
  const ProbePose pose = session.machine.nominal(o.position.data(), o.laserReading);
  return pose.position + pose.orientation * offsets[static_cast<std::size_t>(o.stylus)];
}

GeometricStart geometricStart(const Session& session) { return Start(session).make(); }

}  // namespace mm
