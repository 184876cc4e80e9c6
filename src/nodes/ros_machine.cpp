#include "nodes/ros_machine.h"

#include <measuring_machine/Promote.h>
#include <measuring_machine/Rollback.h>
#include <std_srvs/SetBool.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

#include "base/error.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"
#include "session/travel_tracker.h"

namespace mm {
namespace {

constexpr double kStillMoving = 0.3;   // s after the last state that moved
constexpr double kFrameKept = 1.0;     // s: an older frame is no longer told
constexpr double kPlanLease = 0.5;     // s: a plan that is not renewed for so long ends
constexpr double kStopAnswers = 10.0;  // s for the axes to rest
const ros::WallDuration kBetweenRenewals(0.1);
constexpr std::chrono::milliseconds kConnect(500);  // between looks at the connection to stop
constexpr std::size_t kMostContacts = 100000;

const ros::WallDuration kAvailable(3.0);  // for a server or a service to come

/// Calls a service that answers with success and message. @throw InputError: not there, or refused.
template <typename Service>
std::string ask(const ros::NodeHandle& node, const std::string& name, Service& service) {
  const std::string full = node.resolveName(name);
  // On the wall's clock: that of ROS may stand still.
  const ros::WallTime end = ros::WallTime::now() + kAvailable;
  while (!ros::service::exists(full, false)) {
    if (!ros::ok() || ros::WallTime::now() > end)
      throw InputError(full + " is not available; is its node running?");
    ros::WallDuration(0.02).sleep();
  }
  if (!ros::service::call(full, service)) throw InputError(full + " did not answer; see its node's log");
  if (!service.response.success) throw InputError(service.response.message);
  return service.response.message;
}

/// Waits for the end of the goal that was sent, which lives by being renewed. One late answer is none: that
/// the server has gone is said where its connection has, or where it was silent for `kUnheard`.
/// @param renew whether that was answered. @return false: its server has gone; the goal is forgotten.
template <typename Action, typename Renew>
bool follow(ActionCall<Action>& call, const Renew& renew) {
  bool gone = false;
  ros::WallTime answered = ros::WallTime::now();
  while (ros::ok() && !gone && !call.ended()) {
    kBetweenRenewals.sleep();
    if (renew()) answered = ros::WallTime::now();
    const bool silent = (ros::WallTime::now() - answered).toSec() > kUnheard;
    gone = silent || !call.isServerConnected() || call.unheard(kUnheard);
  }
  if (gone) call.forget();
  return !gone;
}

/// What the server says of the goal that ended. @throw InputError: it did not succeed.
template <typename Action>
std::string messageOf(const ActionCall<Action>& call, const std::string& what) {
  const auto end = call.end();
  if (end.state == actionlib::TerminalState::SUCCEEDED) return end.result.message;
  if (!end.result.message.empty()) throw InputError(end.result.message);
  const std::string text = end.state.getText();
  throw InputError(text.empty() ? what + " ended without a result" : text);
}

}  // namespace

RosMachine::RosMachine(ros::NodeHandle node, const Machine& machine, std::string prefix)
    : node_(node),
      machine_(machine),
      prefix_(std::move(prefix)),
      live_(node),
      readings_(static_cast<std::size_t>(machine.jointCount()), kNotMeasured),
      measure_(node, "measure/run"),
      home_(node, "axis_driver/home"),
      stop_(node, "axis_driver/stop"),
      renew_(node, "measure/renew"),
      take_(node, "axis_driver/take") {
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
    const bool moves = i < message->velocity.size() && directionOf(message->velocity[i]) != 0.0;
    if (moves) moved_ = ros::WallTime::now();
    readings_[static_cast<std::size_t>(joint)] = message->position[i];
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
  if (!home_.waitForServer(kAvailable))
    throw InputError(node_.resolveName("axis_driver/home") +
                     " is not available; is the node axis_driver running?");
  measuring_machine::TakeMotion ticket;
  ticket.request.owner = ros::this_node::getName() + " (homing)";
  ticket.request.seconds = kPlanLease;
  if (!take_.callAnew(ticket, kPlanLease) || !ticket.response.success)
    throw InputError(ticket.response.message.empty() ? node_.resolveName("axis_driver/take") + " is not there"
                                                     : ticket.response.message);
  measuring_machine::HomeGoal goal;
  goal.ticket = ticket.request.ticket = ticket.response.ticket;
  home_.send(goal);
  const bool ended = follow(home_, [&] {
    take_.call(ticket, kPlanLease);  // where it is refused the homing ends, and says why
    return true;
  });
  ticket.request.seconds = 0.0;
  take_.call(ticket, kPlanLease);
  if (!ended) throw InputError("the node axis_driver stopped or lost its connection during homing");
  return messageOf(home_, "homing");
}

std::string RosMachine::pause(bool yes) {
  std_srvs::SetBool service;
  service.request.data = yes;
  return ask(node_, "measure/pause", service);
}

std::string RosMachine::run(const std::string& yaml, const std::function<bool()>& cancelled) {
  if (!measure_.waitForServer(kAvailable))
    throw InputError(node_.resolveName("measure/run") + " is not available; is the node measure running?");
  std_srvs::Trigger renewal;
  if (!renew_.callAnew(renewal, kPlanLease))
    throw InputError(node_.resolveName("measure/renew") + " is not there");
  measuring_machine::MeasureGoal goal;
  goal.plan = yaml;
  goal.lease = kPlanLease;
  measure_.send(goal, [this](const measuring_machine::MeasureFeedback& feedback) {
    const std::lock_guard<std::mutex> lock(mutex_);
    measuring_ = "move " + std::to_string(feedback.move + 1) + " of " + std::to_string(feedback.moves) +
                 ", " + std::to_string(feedback.contacts) + " contacts" +
                 (feedback.feature.empty() ? "" : ", on " + feedback.feature) +
                 (!feedback.asks.empty() ? "; waits: " + feedback.asks
                  : feedback.paused      ? ", paused"
                                         : "");
    share_ = feedback.progress;
  });
  bool asked = false;
  const bool ended = follow(measure_, [&] {
    const bool renewed = renew_.callAnew(renewal, kPlanLease);
    if (!asked && cancelled()) {
      measure_.cancel();
      asked = true;
    }
    return renewed;
  });
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    measuring_.clear();
    share_ = 0.0;
  }
  if (!ended) {
    stop();
    throw InputError(
        "the node measure has stopped, so the machine was stopped; its measurements are in the bag; run the "
        "plan again");
  }
  return messageOf(measure_, "the plan");
}

void RosMachine::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopAsked_ = true;
  }
  wake_.notify_all();
}

std::string RosMachine::deaf() {
  return stop_.connected() ? "" : node_.resolveName("axis_driver/stop") + " is not connected";
}

void RosMachine::serveStops() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    wake_.wait_for(lock, kConnect, [this] { return stopAsked_ || ending_; });
    if (!stopAsked_ && ending_) return;
    const bool asked = stopAsked_;
    stopAsked_ = false;
    lock.unlock();
    if (asked) sendStop();
    stop_.connect();
    lock.lock();
  }
}

void RosMachine::sendStop() {
  measure_.cancelAll();
  std_srvs::Trigger service;
  if (!stop_.callAnew(service, kStopAnswers))
    ROS_ERROR("workbench: stop: %s did not answer", node_.resolveName("axis_driver/stop").c_str());
  else if (!service.response.success)
    ROS_ERROR("workbench: stop: %s", service.response.message.c_str());
}

}  // namespace mm
