#include "ros_bridge/axis_messages.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "base/error.h"
#include "base/format.h"

namespace mm {
namespace {

const char* const kNotHomed = "not homed";
const char* const kHomedAt = "homed at ";

/// A joint as another controller latched it.
struct OtherLatch {
  double position, velocity;  // m or rad, and a second; velocity NaN: not known
  double apart;               // s between the latches, uncertainties included
  /// By how much the joint may have moved between the latches; NaN: not known.
  double moved() const { return velocity == 0.0 ? 0.0 : std::abs(velocity) * apart; }
};

/// The latch nearest to the trip; nothing: there is none.
std::optional<OtherLatch> otherLatchOf(const std::string& joint, const measuring_machine::ProbeLatch& first,
                                       const std::vector<measuring_machine::ProbeLatch>& others) {
  std::optional<OtherLatch> nearest;
  double nearestAway = 0.0;
  for (const measuring_machine::ProbeLatch& other : others) {
    const auto found = std::find(other.name.begin(), other.name.end(), joint);
    const std::size_t i = static_cast<std::size_t>(found - other.name.begin());
    if (found == other.name.end() || i >= other.position.size()) continue;
    if (other.header.stamp < restFrom(first) || other.header.stamp > restTo(first))
      continue;  // another touch's
    const double away = std::abs((other.header.stamp - first.header.stamp).toSec());
    if (nearest && away >= nearestAway) continue;
    nearestAway = away;
    nearest = OtherLatch{other.position[i], i < other.velocity.size() ? other.velocity[i] : std::nan(""),
                         away + other.time_uncertainty + first.time_uncertainty};
  }
  return nearest;
}

}  // namespace

sensor_msgs::JointState toJointState(const std::vector<std::string>& axes, const AxesState& state,
                                     const ros::Time& stamp, const ros::Time& homedAt) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.header.frame_id =
      state.homed && !homedAt.isZero() ? format("%s%u.%09u", kHomedAt, homedAt.sec, homedAt.nsec) : kNotHomed;
  message.name = axes;
  message.position = state.position;
  message.velocity = state.velocity;
  return message;
}

Homing homingOf(const sensor_msgs::JointState& message) {
  const std::string& text = message.header.frame_id;
  Homing homing;
  unsigned seconds = 0, nanoseconds = 0;
  if (std::sscanf(text.c_str(), "homed at %10u.%9u", &seconds, &nanoseconds) == 2 &&
      nanoseconds < 1000000000U) {
    homing.told = homing.homed = true;
    homing.at = ros::Time(seconds, nanoseconds);
  } else {
    homing.told = text == kNotHomed;
  }
  return homing;
}

measuring_machine::ProbeLatch toLatchMessage(const ProbeEdge& edge, const std::vector<std::string>& axes,
                                             const ros::Time& stamp, const std::string& feature) {
  measuring_machine::ProbeLatch message;
  message.header.stamp = stamp;
  message.header.frame_id = "workpiece";
  message.closed = edge.closed;
  message.probing = edge.probing;
  message.name = axes;
  message.position = edge.position;
  message.velocity = edge.velocity;
  message.laser_reading = edge.laserReading;
  message.feature = feature;
  message.time_uncertainty = edge.timeUncertainty;
  message.actual = edge.actual;
  return message;
}

ProbeEdge fromMessage(const measuring_machine::ProbeLatch& message) {
  ProbeEdge edge;
  edge.time = message.header.stamp.toSec();
  edge.closed = message.closed != 0;
  edge.probing = message.probing != 0;
  edge.position = message.position;
  edge.velocity = message.velocity;
  edge.laserReading = message.laser_reading;
  edge.timeUncertainty = message.time_uncertainty;
  edge.actual = message.actual != 0;
  return edge;
}

ros::Time restFrom(const measuring_machine::ProbeLatch& latch) {
  return latch.header.stamp - ros::Duration(latch.time_uncertainty + kRestAround);
}

ros::Time restTo(const measuring_machine::ProbeLatch& latch) {
  return latch.header.stamp + ros::Duration(latch.time_uncertainty + kRestAround);
}

measuring_machine::ProbeLatch joinLatches(const measuring_machine::ProbeLatch& first,
                                          const std::vector<measuring_machine::ProbeLatch>& others,
                                          const RestingJoints& resting, const Machine& machine,
                                          const LatchTolerance& tolerance) {
  measuring_machine::ProbeLatch joined = first;
  if (joined.position.size() < joined.name.size()) return joined;  // said by whoever needs it
  joined.velocity.resize(joined.name.size(), std::nan(""));
  for (const Joint& joint : machine.joints()) {
    if (std::count(joined.name.begin(), joined.name.end(), joint.name) > 0) continue;
    const bool turns = joint.kind == JointKind::kRotary;
    const double bound = turns ? tolerance.rotary : tolerance.linear;
    joined.name.push_back(joint.name);
    const std::optional<OtherLatch> other = otherLatchOf(joint.name, first, others);
    if (other && other->moved() <= bound) {
      joined.position.push_back(other->position);
      joined.velocity.push_back(other->velocity);
      continue;
    }
    const RestingJoints::Rest rest = resting.over(joint, restFrom(first), restTo(first), bound);
    if (!rest.why.empty() && other)
      throw InputError("joint '" + joint.name + "' was latched by another controller within " +
                       std::to_string(1e3 * other->apart) +
                       " ms, uncertainties included, while it moved at " + std::to_string(other->velocity) +
                       (turns ? " rad/s" : " m/s") +
                       "; the latches are not synchronised, no contact was published");
    if (!rest.why.empty())
      throw InputError("joint '" + joint.name + "' was not latched, and it cannot be said that it rested: " +
                       rest.why + "; wire the probe's switch to its controller too, or let it rest");
    joined.position.push_back(rest.position);
    joined.velocity.push_back(0.0);
    joined.time_uncertainty = std::max(joined.time_uncertainty, rest.apart);
  }
  return joined;
}

measuring_machine::ProbeContact toContactMessage(const measuring_machine::ProbeLatch& latch,
                                                 const Machine& machine) {
  measuring_machine::ProbeContact contact;
  contact.header = latch.header;
  contact.laser_reading = latch.laser_reading;
  contact.feature = latch.feature;
  std::vector<double> velocity;
  for (const Joint& joint : machine.joints()) {
    const auto found = std::find(latch.name.begin(), latch.name.end(), joint.name);
    const std::size_t i = static_cast<std::size_t>(found - latch.name.begin());
    if (found == latch.name.end() || i >= latch.position.size())
      throw InputError("joint '" + joint.name + "' was not latched; every joint of the machine must be");
    contact.name.push_back(joint.name);
    contact.position.push_back(latch.position[i]);
    velocity.push_back(i < latch.velocity.size() ? latch.velocity[i] : std::nan(""));
  }
  const bool laser = std::isfinite(latch.laser_reading);
  Eigen::Vector3d approach = Eigen::Vector3d::Zero();
  if (laser) {
    approach = machine.nominal(contact.position.data(), 0.0).orientation.col(2);
  } else if (std::none_of(velocity.begin(), velocity.end(), [](double v) { return std::isnan(v); })) {
    const auto jacobian = machine.jacobian(contact.position.data(), 0.0);
    const Eigen::Map<const Eigen::VectorXd> v(velocity.data(), static_cast<Eigen::Index>(velocity.size()));
    const Eigen::Vector3d motion = jacobian.topRows<3>() * v;
    if (motion.norm() > 0.0) approach = motion.normalized();
  }
  contact.approach.x = approach.x();
  contact.approach.y = approach.y();
  contact.approach.z = approach.z();
  if (std::any_of(velocity.begin(), velocity.end(), [](double v) { return !std::isnan(v); }))
    contact.velocity = velocity;
  return contact;
}

}  // namespace mm
