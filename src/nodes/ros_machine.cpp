#include "nodes/ros_machine.h"

#include <measuring_machine/Promote.h>
#include <measuring_machine/Rollback.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

#include "base/error.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

constexpr double kStanding = 1e-6;    // m/s, rad/s: slower is standing
constexpr double kStillMoving = 0.3;  // s after the last state that moved
constexpr double kFrameKept = 1.0;    // s: an older frame is no longer told
constexpr std::size_t kMostContacts = 100000;

/// Waits on the wall's clock: that of ROS may stand still. @return whether it came true.
template <typename Condition>
bool awaitWall(double seconds, Condition condition) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(seconds);
  while (ros::ok() && !condition() && ros::WallTime::now() < end) ros::WallDuration(0.02).sleep();
  return condition();
}

/// Calls a service that answers with success and message. @throw InputError: not there, or refused.
template <typename Service>
std::string ask(const ros::NodeHandle& node, const std::string& name, Service& service) {
  ros::NodeHandle handle(node);
  if (!awaitWall(3.0, [&] { return ros::service::exists(handle.resolveName(name), false); }))
    throw InputError(handle.resolveName(name) + " is not there; is its node running?");
  if (!ros::service::call(handle.resolveName(name), service))
    throw InputError(handle.resolveName(name) + " did not answer; look at its node's log");
  if (!service.response.success) throw InputError(service.response.message);
  return service.response.message;
}

}  // namespace

RosMachine::RosMachine(ros::NodeHandle node, const Machine& machine, std::string prefix)
    : node_(node),
      machine_(machine),
      prefix_(std::move(prefix)),
      live_(node),
      readings_(static_cast<std::size_t>(machine.jointCount()), kNotMeasured),
      measure_(node, "measure/run") {
  const ros::TransportHints quick = ros::TransportHints().tcpNoDelay();
  // of joint states the latest counts: one waits, and newer ones take its place
  subscribers_.push_back(node_.subscribe("joint_states", 1, &RosMachine::takeJoints, this, quick));
  subscribers_.push_back(node_.subscribe("probe/contact", 1000, &RosMachine::takeContact, this, quick));
  subscribers_.push_back(node_.subscribe("artifact", 10, &RosMachine::takeArtifact, this));
  subscribers_.push_back(node_.subscribe<measuring_machine::CompensationStatus>(
      "compensation/status", 10, [this](const measuring_machine::CompensationStatusConstPtr& message) {
        const std::lock_guard<std::mutex> lock(mutex_);
        compensation_ = *message;
      }));
  stopper_ = std::thread([this] { serveStops(); });
}

RosMachine::~RosMachine() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  stopper_.join();
}

std::string RosMachine::space() const { return machineSpace(); }

void RosMachine::takeJoints(const sensor_msgs::JointStateConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t i = 0; i < message->name.size() && i < message->position.size(); ++i) {
    const int joint = machine_.findJoint(message->name[i]);
    if (joint < 0) continue;
    double& reading = readings_[static_cast<std::size_t>(joint)];
    const bool fast = i < message->velocity.size() && std::abs(message->velocity[i]) > kStanding;
    if (fast) moved_ = ros::WallTime::now();
    reading = message->position[i];
  }
}

Eigen::Vector3d RosMachine::look(const std::string& child, Frame& frame) const {
  const ros::WallTime now = ros::WallTime::now();
  try {
    const auto found = buffer_.lookupTransform(prefix_ + "workpiece", prefix_ + child, ros::Time(0));
    if (found.header.stamp != frame.stamp)
      frame = {tf2::transformToEigen(found).translation(), found.header.stamp, now};
  } catch (const tf2::TransformException&) {
    // none was published yet
  }
  const bool lately = (now - frame.heard).toSec() < kFrameKept;
  return lately ? frame.position : Eigen::Vector3d::Constant(kNotMeasured);
}

void RosMachine::takeContact(const measuring_machine::ProbeContactConstPtr& message) {
  try {
    const Observation contact = fromMessage(*message, machine_);
    const double reading = std::isfinite(contact.laserReading) ? contact.laserReading : 0.0;
    const Eigen::Vector3d tip = machine_.nominal(contact.position.data(), reading).position;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (tip.allFinite() && contacts_.size() < kMostContacts) contacts_.push_back(tip);
  } catch (const InputError&) {
    // set aside by the live session too, which says so
  }
}

void RosMachine::takeArtifact(const measuring_machine::ArtifactConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (message->header.stamp == artifact_) return;
  artifact_ = message->header.stamp;  // another stamp is another session
  contacts_.clear();
}

std::vector<Eigen::Vector3d> RosMachine::contacts() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return contacts_;
}

LiveMachine::State RosMachine::state() {
  const ros::WallTime now = ros::WallTime::now();
  State s;
  s.observations = live_.observations();
  const std::lock_guard<std::mutex> lock(mutex_);
  s.readings = readings_;
  s.moving = (now - moved_).toSec() < kStillMoving;
  bool known = true;
  for (const double reading : readings_) known = known && std::isfinite(reading);
  if (known) s.nominal = machine_.nominal(readings_.data(), 0.0).position;
  s.corrected = look("probe_tip_corrected", corrected_);
  s.candidate = look("probe_tip_candidate", candidate_);
  s.sigma = compensation_.sigma;
  s.calibration = compensation_.calibration_id;
  s.status = compensation_.message;
  s.measuring = measuring_;
  s.share = share_;
  return s;
}

std::string RosMachine::promote(const std::string& id) {
  measuring_machine::Promote service;
  service.request.calibration_id = id;
  return ask(node_, "calibration_server/promote", service);
}

std::string RosMachine::rollback(const std::string& id) {
  measuring_machine::Rollback service;
  service.request.calibration_id = id;
  return ask(node_, "calibration_server/rollback", service);
}

std::string RosMachine::home() {
  std_srvs::Trigger service;
  const std::string message = ask(node_, "axis_driver/home", service);
  return message.empty() ? "homed" : message;
}

std::string RosMachine::pause(bool yes) {
  std_srvs::SetBool service;
  service.request.data = yes;
  return ask(node_, "measure/pause", service);
}

std::string RosMachine::run(const std::string& yaml, const std::function<bool()>& cancelled) {
  if (!awaitWall(3.0, [&] { return measure_.isServerConnected(); }))
    throw InputError(node_.resolveName("measure/run") + " is not there; is the node measure running?");
  measuring_machine::MeasureGoal goal;
  goal.plan = yaml;
  measure_.send(goal, [this](const measuring_machine::MeasureFeedback& feedback) {
    const std::lock_guard<std::mutex> lock(mutex_);
    measuring_ = "move " + std::to_string(feedback.move + 1) + " of " + std::to_string(feedback.moves) +
                 ", " + std::to_string(feedback.contacts) + " contacts" +
                 (feedback.feature.empty() ? "" : ", on " + feedback.feature) +
                 (feedback.paused ? ", paused" : "");
    share_ = feedback.progress;
  });
  bool asked = false, gone = false;
  while (ros::ok() && !gone && !measure_.ended()) {
    ros::WallDuration(0.05).sleep();
    gone = !measure_.isServerConnected();
    if (asked || !cancelled()) continue;
    measure_.cancel();
    asked = true;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    measuring_.clear();
    share_ = 0.0;
  }
  if (gone) {
    measure_.forget();
    throw InputError("the node measure has gone; what it measured is in the bag, run the plan again");
  }
  const auto end = measure_.end();
  if (end.state == actionlib::TerminalState::SUCCEEDED) return end.result.message;
  if (!end.result.message.empty()) throw InputError(end.result.message);
  const std::string text = end.state.getText();
  throw InputError(text.empty() ? "the plan ended without an answer" : text);
}

void RosMachine::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopAsked_ = true;
  }
  wake_.notify_all();
}

void RosMachine::serveStops() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stopAsked_ || ending_; });
    if (!stopAsked_) return;
    stopAsked_ = false;
    lock.unlock();
    try {
      measure_.cancelAll();
      std_srvs::Trigger service;
      ask(node_, "axis_driver/stop", service);
    } catch (const std::exception& e) {
      ROS_ERROR("workbench: stop: %s", e.what());
    }
    lock.lock();
  }
}

}  // namespace mm
