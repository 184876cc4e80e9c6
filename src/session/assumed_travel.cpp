#include "session/assumed_travel.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/dense.h"
#include "base/median.h"
#include "base/range.h"
#include "machine/linear_inverse.h"
#include "session/geometric_start.h"
#include "session/travel_tracker.h"

namespace mm {
namespace {

const char* const kFromApproach = "from the approach of the contact";
const char* const kFromOrder = "from the order of positions";

/// Component of the tip's unit motion below which a joint hardly moves. Of an approach of a millimetre and
/// more, as probes need it, that is 50 um: as much as the play that it must take up. An approach that was
/// not recorded is known to some degrees only.
constexpr double kHardly = 0.05, kHardlyUnrecorded = 0.1;

constexpr double kOfRange = 1e-3;  // of the joint's range in the session: kSameTarget of small machines

/// For each joint, from where its travel comes; the observations that got it that way.
struct Counts {
  std::size_t approach = 0, order = 0;
};

class TravelMaker {
 public:
  explicit TravelMaker(Session& session) : session_(session), joints_(session.machine.jointCount()) {
    counts_.resize(joints_);
    missing_.assign(joints_, 1);
    tolerance_.assign(joints_, 0.0);
    for (int j = 0; j < joints_; ++j) {
      Range range;
      // a velocity of zero at each reading says nothing of its travel
      bool known = false, stoodAlways = true;
      for (const Observation& o : session.observations) {
        known |= o.travel[j] != 0.0 || !std::isnan(o.velocity[j]);
        stoodAlways &= o.travel[j] == 0.0 && o.velocity[j] == 0.0;
        range.add(o.position[j]);
      }
      tolerance_[j] = std::min(kSameTarget, kOfRange * range.size());
      if (known && !(stoodAlways && range.size() > 0.0)) missing_[j] = 0;
    }
  }

  void make() {
    touches();
    for (int j = 0; j < joints_; ++j) runs(j);
    for (int j = 0; j < joints_; ++j)
      for (const auto& [how, count] :
           {std::pair(kFromApproach, counts_[j].approach), std::pair(kFromOrder, counts_[j].order)})
        if (count > 0)
          session_.assumed.push_back(
              {session_.machine.joints()[j].name, how,
               static_cast<double>(count) / static_cast<double>(session_.observations.size())});
  }

 private:
  static bool isLaser(const Observation& o) { return !std::isnan(o.laserReading); }  // read where it stands

  /// Unit motion of the tip into the surface; zero where there was none or it is not known.
  Eigen::Vector3d motionAt(const Observation& o, const GeometricStart& start) const {
    const Feature& feature = session_.artifact.features[o.feature];
    if (isLaser(o)) return Eigen::Vector3d::Zero();
    if (o.approach.allFinite() && o.approach.norm() > 0.5) return o.approach.normalized();
    if (feature.kind != FeatureKind::kBall) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d inwards = start.inWorkpiece(o.feature, o.placement) - start.tipOf(session_, o);
    return inwards.norm() > 0.0 ? inwards.normalized().eval() : Eigen::Vector3d::Zero();
  }

  /// Speeds of the joints, none above 1, that move the tip along `motion`. Linear joints do it where they
  /// can (rotary ones stand still in an approach), else all of them together.
  Eigen::VectorXd jointSpeeds(const Observation& o, const Eigen::Vector3d& motion) const {
    constexpr double kReached = 0.02;  // of the motion may be left: the joints are not exactly square
    const Eigen::Matrix3Xd byJoint = session_.machine.jacobian(o.position.data(), kNotMeasured).topRows<3>();
    const LinearMotion linear = linearMotion(linearJoints(session_.machine.joints()), byJoint, motion);
    if (linear.missed <= kReached) return linear.change;
    Eigen::VectorXd speeds = shortestLeastSquares(byJoint, motion);
    if ((byJoint * speeds - motion).norm() > kReached) return Eigen::VectorXd::Zero(joints_);
    for (int j = 0; j < joints_; ++j) speeds[j] *= byJoint.col(j).norm();  // as the tip sees it
    return speeds;
  }

  void touches() {
    const auto isTouch = [](const Observation& o) { return o.kind == ObservationKind::kContact; };
    auto& all = session_.observations;
    if (std::none_of(all.begin(), all.end(), isTouch)) return;
    std::optional<GeometricStart> start;
    if (std::any_of(missing_.begin(), missing_.end(), [](char m) { return m != 0; }))
      start = geometricStart(session_);
    std::vector<double> last(joints_, 0.0);
    const Observation* previous = nullptr;
    for (Observation& o : all) {
      if (!isTouch(o)) continue;
      const Eigen::Vector3d motion = start ? motionAt(o, *start) : Eigen::Vector3d::Zero();
      if (isLaser(o) || (start && motion.isZero(0.0))) {
        previous = nullptr;
        continue;
      }
      const Eigen::VectorXd speeds = start ? jointSpeeds(o, motion) : Eigen::VectorXd::Zero(joints_);
      const double hardly = o.approach.allFinite() ? kHardly : kHardlyUnrecorded;
      for (int j = 0; j < joints_; ++j) {
        const double known = o.travel[j] != 0.0 ? o.travel[j] : directionOf(o.velocity[j]);
        if (!missing_[j] && (known != 0.0 || std::isnan(o.velocity[j]))) {
          if (known != 0.0) last[j] = known;
          continue;
        }
        // one that stands while others approach came there on the way from the touch before
        if (missing_[j] && std::abs(speeds[j]) >= hardly) {
          o.travel[j] = speeds[j] > 0.0 ? 1.0 : -1.0;
          ++counts_[j].approach;
        } else {
          const double moved = previous != nullptr ? o.position[j] - previous->position[j] : 0.0;
          o.travel[j] = std::abs(moved) > tolerance_[j] ? (moved > 0.0 ? 1.0 : -1.0) : last[j];
          if (o.travel[j] != 0.0) ++counts_[j].order;
        }
        last[j] = o.travel[j];
      }
      previous = &o;
    }
  }

  /// Readings of an instrument at one position of a joint, one after the other.
  struct Stop {
    std::vector<Observation*> rows;
    bool oneTarget = true;                             // all joints stood still
    double position = 0.0, before = 0.0, after = 0.0;  // direction of the motion to it, and from it
    int count() const { return static_cast<int>(rows.size()); }
  };

  /// Rows of one setup and measured component belong to one run.
  static std::vector<bool> runOf(const Observation& o) {
    std::vector<bool> key = {o.kind == ObservationKind::kDeviation};
    if (o.kind == ObservationKind::kDeviation)
      for (const double d : o.deviation) key.push_back(!std::isnan(d));
    else
      for (int k = 0; k < 3; ++k) key.push_back(!std::isnan(o.reference[k]));
    return key;
  }

  bool sameTarget(const Observation& a, const Observation& b) const {
    for (int j = 0; j < joints_; ++j)
      if (std::abs(a.position[j] - b.position[j]) > tolerance_[j]) return false;
    return true;
  }

  std::vector<Stop> stopsOf(const std::vector<Observation*>& rows, int j) const {
    std::vector<Stop> stops;
    for (Observation* o : rows) {
      if (stops.empty() || std::abs(o->position[j] - stops.back().position) > tolerance_[j]) {
        stops.emplace_back();
        stops.back().position = o->position[j];
      } else if (!sameTarget(*o, *stops.back().rows.back())) {
        stops.back().oneTarget = false;
      }
      stops.back().rows.push_back(o);
    }
    for (std::size_t i = 1; i < stops.size(); ++i)
      stops[i].before = stops[i - 1].after = stops[i].position > stops[i - 1].position ? 1.0 : -1.0;
    return stops;
  }

  /// How often a target is read in passing; where none is passed, the least often that any was.
  static int usualCount(const std::vector<Stop>& stops) {
    std::vector<int> passing, any;
    for (const Stop& s : stops) {
      any.push_back(s.count());
      if (s.before != 0.0 && s.before == s.after) passing.push_back(s.count());
    }
    if (passing.empty()) return *std::min_element(any.begin(), any.end());
    return upperMedian(passing);
  }

  /// Whether all returns jump back over several targets to where the run began: each target is then
  /// approached from one side, and whether the return was overrun is not known.
  static bool oneSided(const std::vector<Stop>& stops, double direction) {
    int returns = 0;
    for (std::size_t i = 1; i < stops.size(); ++i) {
      if (stops[i].before != -direction) continue;
      constexpr std::size_t kSeveral = 2;
      std::size_t passed = 0;
      for (std::size_t k = i - 1; k-- > 0 && stops[k].after == direction;)
        if ((stops[k].position - stops[i].position) * direction > 0.0) ++passed;
      if (passed < kSeveral || stops[i].after == -direction) return false;
      ++returns;
    }
    return returns > 0;
  }

  /// What is known stays; a velocity that was lost at one reading does not say that the joint stood.
  void give(Observation& o, int j, double travel) {
    if (!missing_[j] && (o.travel[j] != 0.0 || std::isnan(o.velocity[j]))) return;
    o.travel[j] = travel;
    if (travel != 0.0) ++counts_[j].order;
  }

  void runs(int j) {
    std::map<std::pair<int, std::vector<bool>>, std::vector<Observation*>> all;
    std::map<const Observation*, double> moved;  // to the first row of a run, from the row before it
    const Observation* previous = nullptr;
    double last = 0.0;
    for (Observation& o : session_.observations) {
      if (previous != nullptr && std::abs(o.position[j] - previous->position[j]) > tolerance_[j])
        last = o.position[j] > previous->position[j] ? 1.0 : -1.0;
      previous = &o;
      if (o.kind == ObservationKind::kContact) {
        if (o.travel[j] != 0.0) last = o.travel[j];
        continue;
      }
      auto& run = all[{o.setup, runOf(o)}];
      if (run.empty()) moved[&o] = last;
      run.push_back(&o);
    }
    for (auto& [key, rows] : all) {
      std::vector<Stop> stops = stopsOf(rows, j);
      const int usual = usualCount(stops);
      const auto turned = [&](const Stop& s) {
        return s.before * s.after < 0.0 && s.oneTarget && s.count() >= 2 * usual;
      };
      const bool overrun = std::any_of(stops.begin(), stops.end(), turned);
      const bool up = oneSided(stops, 1.0), down = oneSided(stops, -1.0);
      for (std::size_t i = 0; i < stops.size(); ++i) {
        Stop& s = stops[i];
        double before = i > 0 ? s.before : overrun ? s.after : moved[rows.front()];
        if (i > 0 && ((up && s.before < 0.0) || (down && s.before > 0.0))) before = 0.0;
        for (int k = 0; k < s.count(); ++k)
          give(*s.rows[static_cast<std::size_t>(k)], j, k >= usual && turned(s) ? s.after : before);
      }
    }
  }

  Session& session_;
  int joints_;
  std::vector<char> missing_;  // a joint: its velocity was recorded nowhere
  std::vector<double> tolerance_;
  std::vector<Counts> counts_;
};

}  // namespace

void assumeTravel(Session& session) {
  if (!session.assumed.empty()) return;
  TravelMaker(session).make();
}

}  // namespace mm
