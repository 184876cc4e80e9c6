#include "nodes/probe_node.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "ros_bridge/axis_messages.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

constexpr double kLongestWait = 0.5;  // s that a contact waits for what other drivers say
constexpr double kNear = 2e-3;        // m between a contact and the surface of the ball that it belongs to

ProbeDebounce::Settings debounceFrom(const ros::NodeHandle& own) {
  ProbeDebounce::Settings settings;
  settings.settle = numberParameter(own, "settle", settings.settle, 0.0, 1.0);
  settings.longest = numberParameter(own, "longest", settings.longest, settings.settle, 10.0);
  settings.stuck = numberParameter(own, "stuck", settings.stuck, 0.1, 3600.0);
  return settings;
}

}  // namespace

ProbeNode::ProbeNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine)
    : machine_(machine),
      debounce_(debounceFrom(own)),
      silentMoves_(static_cast<int>(numberParameter(own, "silent_moves", 3, 1, 1000))),
      updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(own, {"settle", "longest", "stuck", "silent_moves", "drivers", "latch_tolerance",
                                "rotary_latch_tolerance"});
  contactsOut_ = node.advertise<measuring_machine::ProbeContact>("probe/contact", 1000);
  tolerance_.linear = numberParameter(own, "latch_tolerance", tolerance_.linear, 0.0, 1.0);
  tolerance_.rotary = numberParameter(own, "rotary_latch_tolerance", tolerance_.rotary, 0.0, 1.0);
  std::istringstream drivers(textParameter(own, "drivers", "axis_driver"));
  std::string first;
  if (!(drivers >> first))
    throw InputError("parameter ~drivers is empty; name the driver that has the probe");
  latchIn_ = node.subscribe(first + "/latch", 1000, &ProbeNode::takeLatch, this);
  statusIn_ = node.subscribe(first + "/status", 100, &ProbeNode::takeStatus, this);
  for (std::string other; drivers >> other;) listenTo(node, other);
  if (!othersIn_.empty())
    othersIn_.push_back(node.subscribe<sensor_msgs::JointState>(
        "joint_states", 1000,
        [this](const sensor_msgs::JointStateConstPtr& message) {
          resting_.take(*message);
          publishKnown();
        },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
  artifactIn_ = node.subscribe<measuring_machine::Artifact>(
      "artifact", 1, [this](const measuring_machine::ArtifactConstPtr& message) {
        try {
          artifact_ = fromMessage(*message);
        } catch (const InputError& e) {
          ROS_ERROR("artifact: %s", e.what());
        }
      });
  updater_.setHardwareID("probe");
  updater_.add("probe", this, &ProbeNode::diagnose);
  timer_ = node.createTimer(ros::Duration(0.005), &ProbeNode::poll, this);
}

void ProbeNode::listenTo(ros::NodeHandle& node, const std::string& other) {
  othersIn_.push_back(node.subscribe<measuring_machine::ProbeLatch>(
      other + "/latch", 1000, [this](const measuring_machine::ProbeLatchConstPtr& latch) {
        if (latch->closed && !latch->position.empty()) others_.push_back(*latch);
      }));
  othersIn_.push_back(node.subscribe<measuring_machine::AxisStatus>(
      other + "/status", 100,
      [this](const measuring_machine::AxisStatusConstPtr& status) { resting_.take(*status); }));
}

void ProbeNode::takeLatch(const measuring_machine::ProbeLatch& latch) {
  if (std::isfinite(latch.laser_reading)) return confirmed(latch);
  if (latch.closed) closings_.push_back(latch);
  debounce_.edge(fromMessage(latch));
}

void ProbeNode::takeStatus(const measuring_machine::AxisStatus& status) { status_ = status; }

void ProbeNode::poll(const ros::TimerEvent&) {
  const ros::Time now = ros::Time::now();
  if (now < last_) {  // a replay began again
    debounce_.reset();
    closings_.clear();
    waiting_.clear();
    resting_.forget();
  }
  last_ = now;
  const std::optional<ProbeEdge> contact = debounce_.poll(now.toSec(), status_.probe_closed, status_.probing);
  if (contact)
    for (const measuring_machine::ProbeLatch& latch : closings_)
      if (latch.header.stamp.toSec() == contact->time) {
        confirmed(latch);
        break;
      }
  publishKnown();
  while (!closings_.empty() && (contact || now - closings_.front().header.stamp > ros::Duration(1.0)))
    closings_.pop_front();
  while (!others_.empty() && now - others_.front().header.stamp > ros::Duration(2.0)) others_.pop_front();
  const std::string wrong = complaint();
  if (wrong != said_ && !wrong.empty()) ROS_WARN("%s", wrong.c_str());
  if (wrong != said_) updater_.force_update();
  said_ = wrong;
  updater_.update();
}

void ProbeNode::confirmed(const measuring_machine::ProbeLatch& latch) {
  if (othersIn_.empty()) return publish(latch);
  waiting_.push_back(latch);
  publishKnown();
}

/// Whether every joint of another driver was latched, or is known until after the trip.
bool ProbeNode::isKnown(const measuring_machine::ProbeLatch& latch) const {
  const ros::Time from = restFrom(latch), to = restTo(latch);
  for (const Joint& joint : machine_.joints()) {
    const auto has = [&](const measuring_machine::ProbeLatch& one) {
      return std::count(one.name.begin(), one.name.end(), joint.name) > 0;
    };
    const bool latched =
        has(latch) ||
        std::any_of(others_.begin(), others_.end(), [&](const measuring_machine::ProbeLatch& one) {
          return one.header.stamp >= from && one.header.stamp <= to && has(one);
        });
    if (!latched && !resting_.heard(joint.name, to)) return false;
  }
  return true;
}

void ProbeNode::publishKnown() {
  while (!waiting_.empty() &&
         (isKnown(waiting_.front()) || last_ - waiting_.front().header.stamp > ros::Duration(kLongestWait))) {
    const measuring_machine::ProbeLatch latch = waiting_.front();
    waiting_.pop_front();
    publish(latch);
  }
}

void ProbeNode::publish(const measuring_machine::ProbeLatch& latch) {
  try {
    measuring_machine::ProbeLatch whole = latch;
    if (!othersIn_.empty())
      whole = joinLatches(latch, {others_.begin(), others_.end()}, resting_, machine_, tolerance_);
    measuring_machine::ProbeContact contact = toContactMessage(whole, machine_);
    if (contact.feature.empty()) contact.feature = featureAt(contact);
    contactsOut_.publish(contact);
    ++contacts_;
    refusal_.clear();
  } catch (const InputError& e) {
    refusal_ = e.what();
  }
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

std::string ProbeNode::complaint() const {
  if (!refusal_.empty()) return refusal_;
  if (!debounce_.complaint().empty()) return debounce_.complaint();
  if (static_cast<int>(status_.unsuccessful) >= silentMoves_)
    return "the probe does not trigger: " + std::to_string(status_.unsuccessful) +
           " probing moves in a row ended without a contact; look at the stylus, the cable, and where the "
           "artifact is";
  return {};
}

void ProbeNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::string wrong = complaint();
  status.summary(wrong.empty() ? DiagnosticStatus::OK : DiagnosticStatus::ERROR,
                 wrong.empty() ? "ready" : wrong);
  status.add("contacts", contacts_);
  status.add("bounces swallowed", debounce_.bounces());
  status.add("trips refused", debounce_.refused());
  status.add("switch", status_.probe_closed ? "closed" : "open");
}

}  // namespace mm
