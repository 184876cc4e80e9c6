#include "design/hypothetical_session.h"

#include <algorithm>
#include <cmath>

#include "machine/linear_inverse.h"

namespace mm {
namespace {

constexpr double kLeastSpeed = 1e-4;  // m/s or rad/s: of a session that did not record its speeds
constexpr double kSlow = 0.3;         // of the speed: where a late trigger would show

/// The session's series, for the times after its end.
void continueSeries(const Session& session, double end, Session& next) {
  for (const Series& s : session.temperatures) {
    Series t = s;
    t.time = {0.0, end + 1.0, end + 0.5 * kCooling, end + 2 * kCooling};
    t.value = {s.at(0.0), s.at(end), s.at(0.0), s.at(0.0)};
    next.temperatures.push_back(t);
  }
  for (const Series& s : session.covariates) {
    Series t = s;
    t.time = {0.0, end + 1.0};
    t.value = {s.at(end), s.at(end)};
    next.covariates.push_back(t);
  }
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

void addAllTouches(const ResidualSpace& space, double end, Session& next) {
  const Session& session = space.problem().session();
  const double fastest = std::max(kLeastSpeed, space.problem().model().domain().maxSpeed);
  std::vector<char> done(session.artifact.features.size(), 0);
  for (const Observation& o : session.observations) {
    if (o.kind != ObservationKind::kContact || done[o.feature]++) continue;
    const Eigen::Vector3d centre = space.problem().featureInWorkpiece(o.feature, space.fitted().x);
    const double distance = session.artifact.features[o.feature].radius +
                            (std::isfinite(o.laserReading) ? 0.0 : session.artifact.tipRadius);
    for (int i = 0; i < 26; ++i) {
      const int c = i < 13 ? i : i + 1;
      const Eigen::Vector3d side = Eigen::Vector3d(c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1).normalized();
      if (side.z() < -0.1) continue;  // from below stands the stem
      for (const double time : {end + 1.0, end + kCooling})
        addTouches(o, centre + distance * side, side, time, fastest, next);
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

Session hypotheticalSession(const ResidualSpace& space) {
  const Session& session = space.problem().session();
  Session next(session.machine);
  next.artifact = session.artifact;
  next.setups = session.setups;
  next.source = session.source;
  const double end = session.observations.back().time;
  continueSeries(session, end, next);
  if (session.observations.front().kind == ObservationKind::kContact)
    addAllTouches(space, end, next);
  else
    addAllReadings(space, end, next);
  std::stable_sort(next.observations.begin(), next.observations.end(),
                   [](auto& a, auto& b) { return a.time < b.time; });
  return next;
}

}  // namespace mm
