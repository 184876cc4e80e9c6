// What others ask of an AxisDriver: goals and services.
#include <algorithm>
#include <cmath>

#include "nodes/axis_driver.h"
#include "ros_bridge/axis_messages.h"
#include "ros_bridge/node_support.h"

namespace mm {

template <typename Done>
bool AxisDriver::waitUntil(std::unique_lock<std::mutex>& lock, Done done) {
  while (!ending_ && ros::ok()) {
    if (!lost_.empty()) throw Error("the controller does not answer: " + lost_);
    if (done()) return true;
    cycled_.wait_for(lock, std::chrono::milliseconds(200));
  }
  return false;
}

AxesMotion AxisDriver::motionOf(const measuring_machine::MoveGoal& goal) const {
  if (goal.name.size() != goal.position.size())
    throw InputError("the goal names " + std::to_string(goal.name.size()) + " joints and has " +
                     std::to_string(goal.position.size()) + " positions");
  std::vector<double> target = state_.position;
  for (std::size_t i = 0; i < goal.name.size(); ++i) {
    const auto& axes = controller_->axes();
    const auto found = std::find(axes.begin(), axes.end(), goal.name[i]);
    if (found == axes.end()) throw InputError("joint '" + goal.name[i] + "' is not moved by this driver");
    target[found - axes.begin()] = goal.position[i];
  }
  checkTarget(joints_, target);
  const double linear = goal.linear_speed > 0.0 ? goal.linear_speed : linearSpeed_;
  const double rotary = goal.rotary_speed > 0.0 ? goal.rotary_speed : rotarySpeed_;
  const bool whole = static_cast<int>(joints_.size()) == machine_.jointCount();
  if (goal.kind != measuring_machine::MoveGoal::PROBE || !whole)
    return straightMotion(joints_, state_.position, target, linear, rotary);
  const Eigen::Vector3d from = machine_.nominal(state_.position.data(), 0.0).position;
  const double way = (machine_.nominal(target.data(), 0.0).position - from).norm();
  if (way == 0.0)
    throw InputError("a probing move needs a length above 0: the probe is at its target already");
  return timedMotion(state_.position, target, way / linear);
}

bool AxisDriver::waitForMove(const AxesMotion& motion, bool probing, measuring_machine::MoveResult& result) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (!state_.homed) throw Error("not homed; call ~home first");
  if (homing_) throw Error("homing; wait until it is done");
  if (probing && state_.probeClosed)
    throw Error("the probe is closed before the probing move; retract it, or check whether it sticks");
  const std::vector<double> from = state_.position;
  double way = 0.0;
  for (std::size_t j = 0; j < from.size(); ++j) way = std::max(way, std::abs(motion.target[j] - from[j]));
  controller_->move(motion);
  stopAsked_ = tripped_ = false;
  probing_ = probing;
  const std::uint64_t first = cycles_ + 1;  // the state must be newer than the command
  std::uint64_t told = cycles_;
  const bool ended = waitUntil(lock, [&] {
    if (stopAsked_ || !state_.fault.empty() || moveServer_->isPreemptRequested()) return true;
    if (cycles_ > told + rate_ / 20) {
      told = cycles_;
      double left = 0.0;
      for (std::size_t j = 0; j < from.size(); ++j)
        left = std::max(left, std::abs(motion.target[j] - state_.position[j]));
      measuring_machine::MoveFeedback feedback;
      feedback.progress = way > 0.0 ? std::clamp(1.0 - left / way, 0.0, 1.0) : 1.0;
      feedback.name = controller_->axes();
      feedback.position = state_.position;
      moveServer_->publishFeedback(feedback);
    }
    return cycles_ > first && !state_.moving;
  });
  probing_ = false;
  if (!state_.fault.empty()) throw Error(state_.fault);
  if (stopAsked_) throw Error("stopped by ~stop");
  if (!ended || moveServer_->isPreemptRequested()) {
    controller_->stop();
    return false;
  }
  result.tripped = tripped_;
  if (probing) unsuccessful_ = tripped_ ? 0 : unsuccessful_ + 1;
  return true;
}

void AxisDriver::executeMove(const measuring_machine::MoveGoalConstPtr& goal) {
  using Goal = measuring_machine::MoveGoal;
  measuring_machine::MoveResult result;
  try {
    AxesMotion motion;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      motion = motionOf(*goal);
      motion.probing = goal->kind == Goal::PROBE;
      feature_ = goal->feature;
    }
    if (!waitForMove(motion, motion.probing, result)) {
      result.message = "cancelled";
      moveServer_->setPreempted(result, result.message);
      return;
    }
    if (goal->kind == Goal::LASER) {
      const std::lock_guard<std::mutex> lock(mutex_);
      const std::optional<ProbeEdge> reading = controller_->readLaser();
      result.tripped = reading.has_value();
      if (reading) {
        const ros::Time now = clock_ ? clockStart_ + ros::Duration(state_.time) : ros::Time::now();
        latchOut_.publish(toLatchMessage(*reading, controller_->axes(),
                                         now - ros::Duration(state_.time - reading->time), goal->feature));
      }
    }
    moveServer_->setSucceeded(result);
  } catch (const std::exception& e) {
    result.message = e.what();
    moveServer_->setAborted(result, result.message);
  }
}

bool AxisDriver::home(Trigger::Request&, Trigger::Response& response) {
  answer(response, [&] {
    std::unique_lock<std::mutex> lock(mutex_);
    if (state_.moving) throw Error("a motion is under way; call ~stop first");
    controller_->home();
    homing_ = true;
    stopAsked_ = false;
    const std::uint64_t first = cycles_ + 1;
    const auto end = [&] { homing_ = false; };
    try {
      waitUntil(lock,
                [&] { return stopAsked_ || !state_.fault.empty() || (cycles_ > first && !state_.moving); });
    } catch (...) {
      end();
      throw;
    }
    end();
    if (!state_.homed)
      throw Error("homing did not end: " + (state_.fault.empty() ? "stopped" : state_.fault));
    response.message = "homed";
  });
  return true;
}

bool AxisDriver::stop(Trigger::Request&, Trigger::Response& response) {
  answer(response, [&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    controller_->stop();
    stopAsked_ = true;
    response.message = "stopped";
  });
  cycled_.notify_all();
  return true;
}

bool AxisDriver::emergencyStop(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  answer(response, [&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (request.data)
      controller_->emergencyStop();
    else
      controller_->resetEmergencyStop();
    response.message = request.data ? "emergency stop" : "reset; home again";
  });
  cycled_.notify_all();
  return true;
}

}  // namespace mm
