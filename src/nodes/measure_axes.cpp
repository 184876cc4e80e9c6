// The axes as a plan has them: whose they are, and one motion.
#include <measuring_machine/TakeMotion.h>

#include "base/error.h"
#include "drivers/motion_control.h"
#include "nodes/measure_node.h"

namespace mm {
namespace {

constexpr double kTicket = 5.0;       // s that the axes are taken for
constexpr double kRecovery = 10.0;    // s within which a controller must answer again
const ros::WallDuration kLook(0.02);  // s between looks at it
const char* const kDriverGone = "the axis driver has gone; home again, then go on from this move";

}  // namespace

void MeasureNode::takeAxes(const std::string& plan) {
  measuring_machine::TakeMotion take;
  take.request.owner = ros::this_node::getName() + " (" + plan + ")";
  lost_ = 0;
  take.request.seconds = kTicket;
  {
    std::unique_lock<std::mutex> lock(mutex_);
    contact_.wait_for(lock, std::chrono::seconds(5), [this] { return motion_.has_value(); });
    if (!motion_) throw Error(kDriverGone);
    stopsBefore_ = motion_->stops;
    lostTicket_.clear();
  }
  if (!take_.call(take)) throw Error(kDriverGone);
  if (!take.response.success) throw Error(take.response.message);
  const std::lock_guard<std::mutex> lock(mutex_);
  ticket_ = take.response.ticket;
}

void MeasureNode::renew() {
  measuring_machine::TakeMotion take;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    take.request.ticket = ticket_;
  }
  if (take.request.ticket == 0) return;
  take.request.owner = ros::this_node::getName();
  take.request.seconds = kTicket;
  const bool answered = take_.call(take);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!answered || take.response.success || ticket_ != take.request.ticket) return;
  lostTicket_ = take.response.message;
  contact_.notify_all();
}

void MeasureNode::giveAxes() {
  measuring_machine::TakeMotion give;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    give.request.ticket = ticket_;
    ticket_ = 0;
  }
  give.request.owner = ros::this_node::getName();
  take_.call(give);
}

// Whoever cancels does not want the tip to stay on the ball: what leaves a surface is not cancelled, only
// stopped.
bool MeasureNode::cancelAsked() { return !ros::ok() || (cancel_ && !leaving_); }

void MeasureNode::goOn() {
  if (cancelAsked()) throw Cancelled("cancelled");
  const std::lock_guard<std::mutex> lock(mutex_);
  if (motion_ && motion_->stops != stopsBefore_)
    throw Error("the plan was ended: stopped by " + motion_->stopped_by);
  if (!lostTicket_.empty()) throw Error("the plan was ended: " + lostTicket_);
}

// After backing off the probe opens; what stays closed sticks, or stands in something.
void MeasureNode::requireOpenProbe(const std::string& when, const std::string& reason) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (contact_.wait_for(lock, std::chrono::duration<double>(releaseTimeout_),
                        [this] { return status_.probe_closed == 0; }))
    return;
  if (!reason.empty()) throw Error("the probe stays closed (" + when + "): " + reason);
  throw Error(std::string(kProbeIsClosed) + " (" + when + "); retract it, or check whether it sticks");
}

bool MeasureNode::touches() {
  constexpr std::chrono::milliseconds kOnTheWay(300);
  std::unique_lock<std::mutex> lock(mutex_);
  return contact_.wait_for(lock, kOnTheWay, [this] { return status_.probe_closed != 0; });
}

bool MeasureNode::drive(const Plan& plan, std::uint8_t kind, const std::vector<double>& position,
                        double speed, const std::string& feature) {
  measuring_machine::MoveGoal goal;
  goal.kind = kind;
  for (const Joint& joint : machine_.joints()) goal.name.push_back(joint.name);
  goal.position = position;
  goal.linear_speed = speed > 0.0 ? speed : plan.rapid;
  goal.rotary_speed = plan.rapidRotary;
  goal.feature = feature;
  goOn();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    goal.ticket = ticket_;
  }
  axes_.send(goal);
  // On the wall clock: simulated time stops when the one who makes it dies.
  while (!waitForArrival(0.2)) {
    if (cancelAsked()) {
      axes_.cancel();
      if (!waitForArrival(2.0)) throw Cancelled("cancelled");
      break;
    }
    if (!axes_.isServerConnected()) throw Error(kDriverGone);
  }
  const auto [state, result] = axes_.end();
  // A touch that came before the cancel counts, and the tip leaves the ball before the plan ends.
  const bool touched = kind == measuring_machine::MoveGoal::PROBE && result.tripped && ros::ok();
  if (cancelAsked() && !touched) throw Cancelled("cancelled");
  if (state == actionlib::TerminalState::SUCCEEDED) {
    lost_ = 0;
    return result.tripped;
  }
  if (state == actionlib::TerminalState::LOST || !axes_.isServerConnected()) throw Error(kDriverGone);
  if (unsettled(kind, result)) throw UnsettledProbe("axes: " + state.getText());
  if (!lostController(result.outcome) || !answersAgain(state.getText()))
    throw Error("axes: " + state.getText());
  // The axes rest where they were stopped. A way is gone again; a probing motion begins from its approach.
  return kind == measuring_machine::MoveGoal::GO && drive(plan, kind, position, speed, feature);
}

// The last motion: the probe closed on the way out of a surface, or was closed as a probing motion was to
// begin.
bool MeasureNode::unsettled(std::uint8_t kind, const measuring_machine::MoveResult& result) const {
  if (kind == measuring_machine::MoveGoal::PROBE)
    return result.outcome == measuring_machine::MoveResult::REFUSED &&
           result.message.rfind(kProbeIsClosed, 0) == 0;
  return leaving_ && result.outcome == measuring_machine::MoveResult::TRIPPED;
}

bool MeasureNode::lostController(std::uint8_t outcome) {
  if (outcome != measuring_machine::MoveResult::REFUSED)
    return outcome == measuring_machine::MoveResult::LOST;
  const std::lock_guard<std::mutex> lock(mutex_);
  return motion_ && motion_->lost;  // between two motions
}

// A controller that was silent for a moment, or a computer that was busy, does not end a plan of hours.
// Whether the axes are still homed is the driver's to say, at the next motion.
bool MeasureNode::answersAgain(const std::string& why) {
  if (++lost_ > retries_) return false;
  ROS_WARN("axes: %s; waiting until the controller answers again (%d of %d)", why.c_str(), lost_, retries_);
  const ros::Time ended = ros::Time::now();
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(kRecovery);
  for (; ros::WallTime::now() < end; kLook.sleep()) {
    goOn();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (motion_ && motion_->header.stamp > ended && !motion_->lost) return true;
  }
  return false;
}

}  // namespace mm
