#include "design/hypothetical_session.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "base/units.h"
#include "machine/linear_inverse.h"

namespace mm {
namespace {

constexpr double kLeastSpeed = 1e-4;  // m/s or rad/s: of a session that did not record its speeds
constexpr double kSlow = 0.3;         // of the speed: where a late trigger would show

/// The session's series go on after its end.
void continueSeries(const Session& session, double end, Session& next) {
  const auto add = [](Series& s, double time, double value) {
    if (!s.time.empty() && time <= s.time.back()) return;
    s.time.push_back(time);
    s.value.push_back(value);
  };
  for (std::size_t i = 0; i < next.temperatures.size(); ++i) {
    const Series& was = session.temperatures[i];
    add(next.temperatures[i], end + 1.0, was.at(end));
    add(next.temperatures[i], end + 0.5 * kCooling, was.at(0.0));
    add(next.temperatures[i], end + 2.0 * kCooling, was.at(0.0));
  }
  for (std::size_t i = 0; i < next.covariates.size(); ++i)
    add(next.covariates[i], end + 1.0, session.covariates[i].at(end));
}

const Observation& lastTouch(const Session& session) {
  for (std::size_t i = session.observations.size(); i-- > 0;)
    if (session.observations[i].kind == ObservationKind::kContact) return session.observations[i];
  return session.observations.back();
}

/// The middle of the balls where they stood last, in workpiece, m.
Eigen::Vector3d middleOf(const ResidualSpace& space) {
  const Problem& problem = space.problem();
  const Session& session = problem.session();
  const int last = lastTouch(session).placement;
  std::set<int> features;
  for (const Observation& o : session.observations)
    if (o.kind == ObservationKind::kContact && o.placement == last) features.insert(o.feature);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int f : features) sum += problem.featureInWorkpiece(f, last, space.fitted().x);
  return sum / static_cast<double>(std::max<std::size_t>(1, features.size()));
}

/// The touch that `like` was, on the same ball from another side, at several speeds.
void addTouches(const Observation& like, const Eigen::Vector3d& tip, const Eigen::Vector3d& side, double time,
                double fastest, Session& next) {
  const Machine& machine = next.machine;
  Observation at = like;
  at.time = time;
  at.approach = -side;
  if (!placeTip(machine, tip, at.laserReading, at.position) || !withinLimits(machine.joints(), at.position))
    return;
  const auto jacobian = machine.jacobian(at.position.data(), at.laserReading);
  for (const double speed : {fastest, kSlow * fastest}) {
    for (int j = 0; j < machine.jointCount(); ++j) {
      const double v = speed * at.approach.dot(jacobian.block<3, 1>(0, j));
      at.velocity[j] = machine.joints()[j].kind == JointKind::kLinear ? v : 0.0;
      at.travel[j] = v > 0 ? 1.0 : v < 0 ? -1.0 : like.travel[j];
    }
    next.observations.push_back(at);
  }
}

void addAllTouches(const ResidualSpace& space, const Stand& stand, double end, Session& next) {
  const Problem& problem = space.problem();
  const Session& session = problem.session();
  const double fastest = std::max(kLeastSpeed, problem.model().domain().maxSpeed);
  const int last = lastTouch(session).placement;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(stand.turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d middle = middleOf(space);
  std::vector<char> done(session.artifact.features.size(), 0);
  for (const Observation& o : session.observations) {
    if (o.kind != ObservationKind::kContact || o.placement != last || done[o.feature]++) continue;
    Observation like = o;
    if (next.placements.size() > session.placements.size())
      like.placement = static_cast<int>(next.placements.size()) - 1;
    if (stand.stylus >= 0) like.stylus = stand.stylus;
    like.recording = session.observations.back().recording;
    const Eigen::Vector3d centre =
        turn * (problem.featureInWorkpiece(o.feature, last, space.fitted().x) - middle) + middle;
    const Eigen::Vector3d reach = session.machine.nominal(o.position.data(), kNotMeasured).orientation *
                                  problem.reach(like.stylus, space.fitted().x);
    const double distance = session.artifact.features[o.feature].radius +
                            (std::isfinite(o.laserReading) ? 0.0 : session.artifact.tipRadiusOf(like.stylus));
    for (int i = 0; i < 26; ++i) {
      const int c = i < 13 ? i : i + 1;
      const Eigen::Vector3d side = Eigen::Vector3d(c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1).normalized();
      if (side.z() < -0.1) continue;  // from below stands the stem
      for (const double time : {end + 1.0, end + kCooling})
        addTouches(like, centre + distance * side - reach, side, time, fastest, next);
    }
  }
}

void addAllReadings(const ResidualSpace& space, double end, Session& next) {
  const Session& session = space.problem().session();
  const Domain& domain = space.problem().model().domain();
  const Observation& first = session.observations.front();
  for (int j = 0; j < session.machine.jointCount(); ++j) {
    if (!(domain.upper[j] > domain.lower[j])) continue;
    const double speed = std::isfinite(first.velocity[j]) ? std::abs(first.velocity[j]) : 0.0;
    for (int i = 0; i <= 8; ++i)
      for (const double sign : {-1.0, 1.0})
        for (const double share : {1.0, kSlow})
          for (const double time : {end + 1.0, end + kCooling}) {
            Observation at = first;
            at.time = time;
            at.recording = session.observations.back().recording;
            at.position[j] = domain.lower[j] + (domain.upper[j] - domain.lower[j]) * i / 8.0;
            at.travel[j] = sign;
            at.velocity[j] = sign * share * std::max(kLeastSpeed, speed);
            at.deviation.assign(at.deviation.size(), kNotMeasured);
            if (at.kind == ObservationKind::kDeviation) at.deviation[j] = 0.0;
            next.observations.push_back(at);
          }
  }
}

}  // namespace

std::vector<Stand> standsOf(const ResidualSpace& space) {
  const Session& session = space.problem().session();
  std::vector<Stand> stands = {{}};
  if (session.observations.front().kind != ObservationKind::kContact) return stands;
  constexpr int kQuarter = 90;  // deg
  for (const int quarters : {1, 2}) {
    std::string name = "turned by " + std::to_string(kQuarter * quarters) + " deg";
    while (std::find(session.placements.begin(), session.placements.end(), name) != session.placements.end())
      name += " again";
    stands.push_back({name, quarters * kQuarter * kDegree, -1});
  }
  const int used = lastTouch(session).stylus;
  for (int s = 0; s < static_cast<int>(session.artifact.styli.size()); ++s)
    if (s != used && session.artifact.styli[static_cast<std::size_t>(s)].offset.allFinite())
      stands.push_back({"", 0.0, s});
  return stands;
}

Session hypotheticalSession(const ResidualSpace& space, const Stand& stand) {
  const Session& session = space.problem().session();
  Session next = session;
  // it is another session, and where an artifact of unknown pose stands then is to be found anew
  if (!stand.placement.empty() || session.poseFree(lastTouch(session).placement)) {
    if (next.placements.empty()) next.placements.emplace_back();
    next.placements.push_back(stand.placement.empty() ? "then" : stand.placement);
  }
  const double end = session.observations.back().time;
  continueSeries(session, end, next);
  if (session.observations.front().kind == ObservationKind::kContact)
    addAllTouches(space, stand, end, next);
  else
    addAllReadings(space, end, next);
  std::stable_sort(next.observations.begin() + static_cast<long>(session.observations.size()),
                   next.observations.end(), [](auto& a, auto& b) { return a.time < b.time; });
  return next;
}

}  // namespace mm
