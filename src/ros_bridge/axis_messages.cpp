#include "ros_bridge/axis_messages.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace mm {

sensor_msgs::JointState toJointState(const std::vector<std::string>& axes, const AxesState& state,
                                     const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.name = axes;
  message.position = state.position;
  message.velocity = state.velocity;
  return message;
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
