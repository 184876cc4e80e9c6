// What others ask of an AxisDriver: goals and services.
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "nodes/axis_driver.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

using MoveResult = measuring_machine::MoveResult;

constexpr double kFeedbackPeriod = 0.05;  // s
// How long a motion waits for the connection by which its sender listens. On a loaded computer it follows the
// goal's own by tenths of a second; who has none after this is not there.
constexpr std::chrono::milliseconds kListens(2000);

// The name of the node that made a goal is the beginning of the goal's id, in roscpp and in rospy.
std::string senderOf(const std::string& goalId) {
  const std::size_t dash = goalId.find('-');
  return dash == std::string::npos || dash == 0 ? "somebody" : goalId.substr(0, dash);
}

MoveResult resultOf(std::uint8_t outcome, const std::string& message) {
  MoveResult result;
  result.outcome = outcome;
  result.message = message;
  return result;
}

}  // namespace

void AxisDriver::advertise(ros::NodeHandle own) {
  ros::NodeHandle holding(own), lease(own);
  holding.setCallbackQueue(&holdQueue_);
  lease.setCallbackQueue(&leaseQueue_);
  stops_ = std::make_unique<DirectServer>();
  stops_->add<std_srvs::Trigger>(own.resolveName("stop"),
                                 [this](const std::string& caller, const std_srvs::TriggerRequest&,
                                        std_srvs::TriggerResponse& response) { stop(caller, response); });
  stops_->add<std_srvs::SetBool>(
      own.resolveName("emergency_stop"),
      [this](const std::string& caller, const std_srvs::SetBoolRequest& request,
             std_srvs::SetBoolResponse& response) { emergencyStop(caller, request.data, response); });
  services_ = {offer<std_srvs::Trigger>(holding, "hold",
                                        [this](auto&, auto& response) {
                                          control_.hold(true);
                                          response.message = "feed hold; call ~resume to continue";
                                        }),
               offer<std_srvs::Trigger>(holding, "resume",
                                        [this](auto&, auto& response) {
                                          control_.hold(false);
                                          response.message = "goes on";
                                        }),
               own.advertiseService("home", &AxisDriver::home, this),
               own.advertiseService("home_axes", &AxisDriver::homeAxes, this),
               offer<Take>(lease, "take", [this](auto& request, auto& response) { take(request, response); }),
               offer<measuring_machine::SetOverride>(
                   own, "override", [this](auto& request, auto&) { control_.setOverride(request.share); }),
               offer<std_srvs::Trigger>(own, "clear_alarm",
                                        [this](auto&, auto& response) {
                                          control_.clearAlarm();
                                          response.message =
                                              control_.view().state.homed ? "cleared" : "cleared; home again";
                                        }),
               offer<std_srvs::Trigger>(own, "move_off_limit",
                                        [this](auto&, auto& response) {
                                          control_.moveOffLimit({"~move_off_limit"});
                                          response.message = "off the limit switch";
                                        }),
               offer<measuring_machine::BreakDevice>(own, "break_device", [this](auto& request, auto&) {
                 control_.breakDevice(request.fault);
               })};
}

// Beside what the action's server publishes there: who comes and goes. A client that was killed goes with its
// connection; of the topics that it publishes roscpp would look for it again and again.
void AxisDriver::watchListeners(ros::NodeHandle own) {
  own.setCallbackQueue(&atOnce_);
  for (const char* topic : {"move/status", "home/status"})
    listening_.push_back(own.advertise<actionlib_msgs::GoalStatusArray>(
        topic, 50,
        [this](const ros::SingleSubscriberPublisher& client) { listeners_.came(client.getSubscriberName()); },
        [this](const ros::SingleSubscriberPublisher& client) { listeners_.left(client.getSubscriberName()); },
        ros::VoidConstPtr(), true));
}

Mover AxisDriver::moverOf(const std::string& sender, std::uint64_t ticket) {
  return {
      sender, ticket, [this, sender]() -> std::string {
        if (listeners_.listens(sender)) return {};
        return "'" + sender +
               "', which requested the motion, does not subscribe to its action's status; a motion ends with "
               "the node that requested it";
      }};
}

// Of a service's caller nobody knows whether it is still there, unless it is a client of the actions, too.
Mover AxisDriver::callerOf(const std::string& node) {
  return listeners_.listens(node) ? moverOf(node, 0) : Mover{node};
}

void AxisDriver::takeHoming(HomeServer::GoalHandle goal) {
  {
    const std::lock_guard<std::mutex> lock(goals_);
    if (homes_.exchange(true))
      return goal.setRejected({}, "homing is in progress; wait until it has finished");
    homingCancelled_ = false;
    goal.setAccepted();
    nextHoming_ = std::make_unique<HomeServer::GoalHandle>(goal);
  }
  asked_.notify_all();
}

void AxisDriver::homeAll() {
  while (!ending_) {
    std::unique_ptr<HomeServer::GoalHandle> goal;
    {
      std::unique_lock<std::mutex> lock(goals_);
      asked_.wait(lock, [&] { return ending_ || nextHoming_; });
      if (ending_) return;
      goal = std::move(nextHoming_);
    }
    executeHoming(*goal);
  }
}

void AxisDriver::executeHoming(HomeServer::GoalHandle goal) {
  measuring_machine::HomeResult result;
  measuring_machine::HomeFeedback told;
  const auto watch = [&](const AxesState& state) {
    measuring_machine::HomeFeedback homed;
    for (std::size_t j = 0; j < control_.axes().size(); ++j)
      if (state.axisHomed[j]) homed.homed.push_back(control_.axes()[j]);
    if (homed.homed != told.homed) goal.publishFeedback(homed);
    told = homed;
    return !homingCancelled_;
  };
  try {
    const std::string sender = senderOf(goal.getGoalID().id);
    listeners_.listensWithin(sender, kListens, [&] { return homingCancelled_ || ending_; });
    control_.home(goal.getGoal()->name, moverOf(sender, goal.getGoal()->ticket), watch);
    result.message = control_.view().state.homed ? "homed" : "homed; other axes are not";
    homes_ = false;  // before the result: it may be answered with the next goal at once
    goal.setSucceeded(result, result.message);
  } catch (const std::exception& e) {
    result.message = e.what();
    homes_ = false;
    if (homingCancelled_)
      goal.setCanceled(result, result.message);
    else
      goal.setAborted(result, result.message);
  }
}

AxesMotion AxisDriver::motionOf(const measuring_machine::MoveGoal& goal) const {
  if (goal.kind > measuring_machine::MoveGoal::LASER)
    throw InputError("the goal's kind is " + std::to_string(goal.kind) +
                     "; possible are 0 (GO), 1 (PROBE) and 2 (LASER)");
  if (goal.name.size() != goal.position.size())
    throw InputError("the goal names " + std::to_string(goal.name.size()) + " joints and has " +
                     std::to_string(goal.position.size()) + " positions");
  const std::vector<double> here = control_.view().state.position;
  if (here.size() != control_.axes().size())
    throw Error("the controller has not reported the positions of its axes");
  std::vector<double> target = here;
  for (std::size_t i = 0; i < goal.name.size(); ++i) {
    const auto& axes = control_.axes();
    const auto found = std::find(axes.begin(), axes.end(), goal.name[i]);
    if (found == axes.end()) throw InputError("joint '" + goal.name[i] + "' is not moved by this driver");
    if (std::count(goal.name.begin(), goal.name.end(), goal.name[i]) > 1)
      throw InputError("joint '" + goal.name[i] + "' appears twice in the goal; give it once");
    target[found - axes.begin()] = goal.position[i];
  }
  checkTarget(control_.joints(), target);
  for (const double speed : {goal.linear_speed, goal.rotary_speed})
    if (!std::isfinite(speed) || speed < 0.0)
      throw InputError("a speed of the goal is " + std::to_string(speed) +
                       "; it must be above 0, or 0 for the driver's default");
  const double linear = goal.linear_speed > 0.0 ? goal.linear_speed : linearSpeed_;
  const double rotary = goal.rotary_speed > 0.0 ? goal.rotary_speed : rotarySpeed_;
  const bool whole = static_cast<int>(control_.joints().size()) == machine_.jointCount();
  AxesMotion motion;
  if (goal.kind != measuring_machine::MoveGoal::PROBE || !whole) {
    motion = straightMotion(control_.joints(), here, target, linear, rotary);
  } else {
    const Eigen::Vector3d from = machine_.nominal(here.data(), 0.0).position;
    const double way = (machine_.nominal(target.data(), 0.0).position - from).norm();
    if (way == 0.0)
      throw InputError("a probing move needs a length above 0: the probe is at its target already");
    motion = timedMotion(here, target, way / linear);
  }
  motion.probing = goal.kind == measuring_machine::MoveGoal::PROBE;
  checkSpeeds(control_.joints(), motion);
  return motion;
}

// A goal of another than the one who moves is refused; one of the same, or one in the place of somebody who
// does not listen, replaces the one before.
void AxisDriver::takeGoal(Goal goal) {
  auto asked = std::make_unique<Asked>();
  asked->goal = goal;
  asked->stops = control_.stops();
  asked->sender = senderOf(goal.getGoalID().id);
  {
    const std::lock_guard<std::mutex> lock(goals_);
    const Asked* before = next_ ? next_.get() : now_.get();
    if (before != nullptr && before->sender != asked->sender && listeners_.listens(before->sender)) {
      const MoveResult result =
          resultOf(MoveResult::REFUSED, "a motion by '" + before->sender +
                                            "' is in progress; wait until it has finished, or call ~stop");
      goal.setRejected(result, result.message);
      return;
    }
    if (next_) {
      const MoveResult result = resultOf(MoveResult::STOPPED, "replaced by a newer goal");
      next_->goal.setCanceled(result, result.message);
    }
    if (now_) cancelled_ = true;
    goal.setAccepted();
    next_ = std::move(asked);
  }
  asked_.notify_all();
}

void AxisDriver::cancelGoal(Goal goal) {
  const std::lock_guard<std::mutex> lock(goals_);
  if (now_ && now_->goal == goal) cancelled_ = true;
  if (!next_ || !(next_->goal == goal)) return;
  const MoveResult result = resultOf(MoveResult::STOPPED, "cancelled");
  next_->goal.setCanceled(result, result.message);
  next_.reset();
}

void AxisDriver::moveAll() {
  while (!ending_) {
    Asked asked;
    {
      std::unique_lock<std::mutex> lock(goals_);
      asked_.wait(lock, [&] { return ending_ || next_; });
      if (ending_) return;
      now_ = std::move(next_);
      cancelled_ = false;
      const auto goal = now_->goal.getGoal();
      if (goal->kind == measuring_machine::MoveGoal::PROBE) meant_ = meantBy(*goal);
      asked = *now_;
    }
    execute(asked);
    forgetGoal();
  }
}

// A handle of actionlib takes its server's lock when it ends, and its callbacks take ours within that lock:
// it must end outside of ours.
void AxisDriver::forgetGoal() {
  std::unique_ptr<Asked> ended;
  const std::lock_guard<std::mutex> lock(goals_);
  ended.swap(now_);
}

void AxisDriver::execute(const Asked& asked) {
  const auto goal = asked.goal.getGoal();
  Goal handle = asked.goal;
  MoveResult result = resultOf(MoveResult::REFUSED, {});
  const auto finish = [&](void (Goal::*how)(const MoveResult&, const std::string&)) {
    forgetGoal();  // before the result: it may be answered with the next goal at once
    (handle.*how)(result, result.message);
  };
  try {
    listeners_.listensWithin(asked.sender, kListens, [&] {
      const std::lock_guard<std::mutex> lock(goals_);
      return cancelled_ || ending_;
    });  // who does not listen is refused by the mover's own question
    const AxesMotion motion = motionOf(*goal);
    const std::vector<double> from = control_.view().state.position;
    double way = 0.0;
    for (std::size_t j = 0; j < from.size(); ++j) way = std::max(way, std::abs(motion.target[j] - from[j]));
    ros::WallTime told;
    const auto watch = [&](const AxesState& state) {
      {
        const std::lock_guard<std::mutex> lock(goals_);
        if (cancelled_) return false;
      }
      const ros::WallTime now = ros::WallTime::now();
      if (now - told < ros::WallDuration(kFeedbackPeriod)) return true;
      told = now;
      double left = 0.0;
      for (std::size_t j = 0; j < from.size(); ++j)
        left = std::max(left, std::abs(motion.target[j] - state.position[j]));
      measuring_machine::MoveFeedback feedback;
      feedback.progress = way > 0.0 ? std::clamp(1.0 - left / way, 0.0, 1.0) : 1.0;
      feedback.held = state.held;
      feedback.name = control_.axes();
      feedback.position = state.position;
      handle.publishFeedback(feedback);
      return true;
    };
    const MotionControl::Report report =
        control_.move(motion, moverOf(asked.sender, goal->ticket), asked.stops, watch);
    result.outcome = static_cast<std::uint8_t>(report.outcome);
    result.tripped = motion.probing && report.outcome == Outcome::kTripped;
    result.message = report.message;
    const bool done = report.outcome == Outcome::kReached || result.tripped;
    if (done && goal->kind == measuring_machine::MoveGoal::LASER) result.tripped = latchLaser(meantBy(*goal));
    if (done) return finish(&Goal::setSucceeded);
    if (report.outcome == Outcome::kStopped && result.message.rfind("cancelled", 0) == 0)
      return finish(&Goal::setCanceled);
    finish(&Goal::setAborted);
  } catch (const std::exception& e) {
    result.message = e.what();
    finish(&Goal::setAborted);
  }
}

bool AxisDriver::home(TriggerCall& call) {
  auto& response = call.getResponse();
  answer(response, [&] {
    control_.home({}, callerOf(call.getCallerName()));
    response.message = "homed";
  });
  return true;
}

bool AxisDriver::homeAxes(HomeCall& call) {
  auto& response = call.getResponse();
  answer(response, [&] {
    control_.home(call.getRequest().name, callerOf(call.getCallerName()));
    response.message = control_.view().state.homed ? "homed" : "homed; other axes are not";
  });
  return true;
}

void AxisDriver::stop(const std::string& caller, std_srvs::TriggerResponse& response) {
  answer(response, [&] {
    control_.stop(caller);
    response.message = "stopped: the axes stand still";
  });
}

void AxisDriver::emergencyStop(const std::string& caller, bool on, std_srvs::SetBoolResponse& response) {
  answer(response, [&] {
    if (!on) {
      const std::unique_lock<std::mutex> alone(reset_, std::try_to_lock);
      if (!alone.owns_lock()) throw Error("a reset is in progress");
      control_.resetEmergencyStop();
      response.message = "reset; home again";
      return;
    }
    const std::string failed = control_.emergencyStop(caller);
    if (!failed.empty())
      throw Error("the emergency stop did not reach the controller: " + failed + "; press its button");
    response.message = "emergency stop";
  });
}

void AxisDriver::take(const Take::Request& request, Take::Response& response) {
  const struct Count {  // after the ticket was taken, or was found to be taken away
    MotionControl& control;
    Take::Response& response;
    ~Count() { response.stops = control.stops(); }
  } count{control_, response};
  if (request.seconds == 0.0) {
    control_.owner().give(request.ticket);
    response.message = "given back";
    return;
  }
  if (!(request.seconds > 0.0 && request.seconds <= 3600.0))
    throw InputError("'seconds' is " + std::to_string(request.seconds) + "; it must be above 0, up to 3600");
  if (request.owner.empty()) throw InputError("'owner' is empty; name the node that moves the axes");
  response.ticket = control_.owner().take({request.owner, request.ticket}, request.seconds);
  response.message = "the axes belong to '" + request.owner + "'";
}

}  // namespace mm
