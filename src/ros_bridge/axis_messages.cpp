#include "ros_bridge/axis_messages.h"

#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "base/error.h"

namespace mm {
namespace {

const char* const kWorkpiece = "workpiece";
const char* const kUnhomed = "unhomed";

/// A frame's name without the prefix of its machine.
std::string bareName(const std::string& frame) { return frame.substr(frame.rfind('/') + 1); }

constexpr double kRestAround = 0.05;  // s that a joint without a latch must have rested, on either side

struct JointAtTrip {
  double position, velocity;  // m or rad, and a second; velocity NaN: not known
};

std::optional<JointAtTrip> latchedIn(const measuring_machine::ProbeLatch& latch, const std::string& joint) {
  const auto found = std::find(latch.name.begin(), latch.name.end(), joint);
  const std::size_t i = static_cast<std::size_t>(found - latch.name.begin());
  if (found == latch.name.end() || i >= latch.position.size() || !std::isfinite(latch.position[i]))
    return std::nullopt;
  return JointAtTrip{latch.position[i], i < latch.velocity.size() ? latch.velocity[i] : std::nan("")};
}

/// A joint that this controller does not move.
JointAtTrip elsewhere(const Joint& joint, const measuring_machine::ProbeLatch& trip,
                      const std::vector<measuring_machine::ProbeLatch>& others, const RestingJoints& resting,
                      const LatchTolerance& tolerance) {
  const bool turns = joint.kind == JointKind::kRotary;
  const double bound = turns ? tolerance.rotary : tolerance.linear;
  const ros::Duration around(trip.time_uncertainty + kRestAround);
  std::optional<JointAtTrip> nearest;
  double away = around.toSec(), apart = 0.0;  // s from the trip; with the uncertainties of both latches
  for (const measuring_machine::ProbeLatch& other : others) {
    const double gone = std::abs((other.header.stamp - trip.header.stamp).toSec());
    const std::optional<JointAtTrip> latched = latchedIn(other, joint.name);
    if (!latched || gone > away) continue;  // another touch's
    nearest = latched;
    away = gone;
    apart = gone + other.time_uncertainty + trip.time_uncertainty;
  }
  if (nearest && (nearest->velocity == 0.0 || std::abs(nearest->velocity) * apart <= bound)) return *nearest;
  const RestingJoints::Rest rest =
      resting.over(joint, trip.header.stamp - around, trip.header.stamp + around, bound);
  if (rest.why.empty()) return {rest.position, 0.0};
  if (nearest)
    throw InputError("joint '" + joint.name + "' was latched by another controller within " +
                     std::to_string(1e3 * apart) + " ms, uncertainties included, while it moved at " +
                     std::to_string(nearest->velocity) + (turns ? " rad/s" : " m/s") +
                     "; the latches are not synchronised, no contact was published");
  throw InputError("joint '" + joint.name + "' was not latched, and it is not certain that it stood still: " +
                   rest.why + "; wire the probe's switch to its controller as well, or keep it at rest");
}

Eigen::Vector3d approachOf(const measuring_machine::ProbeContact& contact, const Machine& machine) {
  if (std::isfinite(contact.laser_reading))
    return machine.nominal(contact.position.data(), 0.0).orientation.col(2);
  const Eigen::Map<const Eigen::VectorXd> velocity(contact.velocity.data(), machine.jointCount());
  const Eigen::Vector3d motion = machine.jacobian(contact.position.data(), 0.0).topRows<3>() * velocity;
  if (!(motion.norm() > 0.0)) return Eigen::Vector3d::Zero();  // of an unknown one, too
  return motion.normalized();
}

}  // namespace

sensor_msgs::JointState toJointState(const std::vector<std::string>& axes, const AxesState& state,
                                     const ros::Time& stamp, const std::string& prefix) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.header.frame_id = prefix + (state.homed ? kWorkpiece : kUnhomed);
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
    homing.homed = bareName(text) == kWorkpiece;
    homing.told = homing.homed || bareName(text) == kUnhomed || text == "not homed";
  }
  return homing;
}

measuring_machine::ProbeLatch toLatchMessage(const ProbeEdge& trip, const std::vector<std::string>& axes,
                                             const ros::Time& stamp, const Meant& meant) {
  measuring_machine::ProbeLatch message;
  message.header.stamp = stamp;
  message.header.frame_id = "workpiece";
  message.probing = trip.probing;
  message.name = axes;
  message.position = trip.position;
  message.velocity = trip.velocity;
  message.laser_reading = trip.laserReading;
  message.feature = meant.feature;
  message.placement = meant.placement;
  message.stylus = meant.stylus;
  message.time_uncertainty = trip.timeUncertainty;
  message.actual = trip.actual;
  return message;
}

measuring_machine::ProbeContact contactOf(const measuring_machine::ProbeLatch& trip,
                                          const std::vector<measuring_machine::ProbeLatch>& others,
                                          const RestingJoints& resting, const Machine& machine,
                                          const LatchTolerance& tolerance) {
  if (!trip.probing && !std::isfinite(trip.laser_reading))
    throw InputError(
        "the probe triggered outside a probing move, possibly a collision; no contact was published");
  measuring_machine::ProbeContact contact;
  contact.header = trip.header;
  contact.laser_reading = trip.laser_reading;
  contact.feature = trip.feature;
  contact.placement = trip.placement;
  contact.stylus = trip.stylus;
  for (const Joint& joint : machine.joints()) {
    const bool own = std::count(trip.name.begin(), trip.name.end(), joint.name) > 0;
    const std::optional<JointAtTrip> at =
        own ? latchedIn(trip, joint.name) : elsewhere(joint, trip, others, resting, tolerance);
    if (!at) throw InputError("the controller latched no position at the trigger; no contact was published");
    contact.name.push_back(joint.name);
    contact.position.push_back(at->position);
    contact.velocity.push_back(at->velocity);
  }
  tf2::toMsg(approachOf(contact, machine), contact.approach);
  if (std::all_of(contact.velocity.begin(), contact.velocity.end(), [](double v) { return std::isnan(v); }))
    contact.velocity.clear();
  return contact;
}

}  // namespace mm
