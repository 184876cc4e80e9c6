#include "nodes/probe_node.h"

#include <cmath>
#include <sstream>

#include "base/erase_if.h"
#include "base/error.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

using StatusEvent = ros::MessageEvent<const measuring_machine::AxisStatus>;
using StatesEvent = ros::MessageEvent<const sensor_msgs::JointState>;

constexpr double kLongestWait = 0.5;  // s that a trip waits for what other drivers say
constexpr double kKept = 2.0;         // s that the latches of other drivers are kept
constexpr double kNear = 2e-3;        // m between a contact and the surface of the ball that it belongs to

}  // namespace

ProbeNode::ProbeNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine)
    : machine_(machine), updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(own, {"drivers", "latch_tolerance", "rotary_latch_tolerance"});
  contactsOut_ = node.advertise<measuring_machine::ProbeContact>("probe/contact", 1000);
  tolerance_.linear = numberParameter(own, "latch_tolerance", tolerance_.linear, 0.0, 1.0);
  tolerance_.rotary = numberParameter(own, "rotary_latch_tolerance", tolerance_.rotary, 0.0, 1.0);
  updater_.setHardwareID("probe");
  updater_.add("probe", this, &ProbeNode::diagnose);
  std::istringstream drivers(textParameter(own, "drivers", "axis_driver"));
  std::string first;
  if (!(drivers >> first))
    throw InputError("parameter ~drivers is empty; name the driver that has the probe");
  in_.push_back(node.subscribe<measuring_machine::ProbeLatch>(
      first + "/latch", 1000, [this](const measuring_machine::ProbeLatchConstPtr& trip) {
        trips_.push_back(*trip);
        publishKnown();
      }));
  for (std::string other; drivers >> other;) listenTo(node, other);
  in_.push_back(node.subscribe<measuring_machine::Artifact>(
      "artifact", 1, [this](const measuring_machine::ArtifactConstPtr& message) {
        try {
          artifact_ = fromMessage(*message);
        } catch (const InputError& e) {
          ROS_ERROR("artifact: %s", e.what());
        }
      }));
  timer_ = node.createTimer(ros::Duration(0.05), [this](const ros::TimerEvent&) {
    publishKnown();
    updater_.update();
  });
}

void ProbeNode::listenTo(ros::NodeHandle& node, const std::string& other) {
  in_.push_back(node.subscribe<measuring_machine::ProbeLatch>(
      other + "/latch", 1000, [this](const measuring_machine::ProbeLatchConstPtr& latch) {
        others_.push_back(*latch);
        publishKnown();
      }));
  in_.push_back(node.subscribe<measuring_machine::AxisStatus>(
      other + "/status", 100, boost::function<void(const StatusEvent&)>([this](const StatusEvent& event) {
        resting_.take(*event.getConstMessage(), event.getPublisherName());
      })));
  if (!wait_.isZero()) return;
  wait_ = ros::Duration(kLongestWait);
  in_.push_back(node.subscribe<sensor_msgs::JointState>(
      "joint_states", 1000, boost::function<void(const StatesEvent&)>([this](const StatesEvent& event) {
        resting_.take(*event.getConstMessage(), event.getPublisherName());
        publishKnown();
      }),
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
}

// A trip is refused when its time is over; also when the clock went back, as in a replay.
void ProbeNode::publishKnown() {
  const ros::Time now = ros::Time::now();
  const auto away = [&](const measuring_machine::ProbeLatch& latch) {
    return std::abs((now - latch.header.stamp).toSec());
  };
  eraseIf(others_, [&](const measuring_machine::ProbeLatch& latch) { return away(latch) > kKept; });
  while (!trips_.empty()) {
    try {
      publish(trips_.front());
    } catch (const InputError& e) {
      if (away(trips_.front()) < wait_.toSec()) return;
      ++refused_;
      refusal_ = e.what();
      ROS_WARN("%s", e.what());
      updater_.force_update();
    }
    trips_.pop_front();
  }
}

void ProbeNode::publish(const measuring_machine::ProbeLatch& trip) {
  measuring_machine::ProbeContact contact = contactOf(trip, others_, resting_, machine_, tolerance_);
  if (contact.feature.empty()) contact.feature = featureAt(contact);
  contactsOut_.publish(contact);
  ++contacts_;
  if (!refusal_.empty()) updater_.force_update();
  refusal_.clear();
}

std::string ProbeNode::featureAt(const measuring_machine::ProbeContact& contact) const {
  if (!artifact_) return {};
  const bool laser = std::isfinite(contact.laser_reading);
  const Eigen::Vector3d at = machine_.nominal(contact.position.data(), contact.laser_reading).position;
  std::string name;
  double nearest = kNear;
  for (const Feature& f : artifact_->features) {
    const double surface = f.radius + (laser ? 0.0 : artifact_->tipRadius);
    const double away = std::abs((at - f.position).norm() - surface);
    if (away < nearest) nearest = away, name = f.name;
  }
  return name;
}

void ProbeNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(refusal_.empty() ? DiagnosticStatus::OK : DiagnosticStatus::ERROR,
                 refusal_.empty() ? "ready" : refusal_);
  status.add("contacts", contacts_);
  status.add("trips refused", refused_);
}

}  // namespace mm
