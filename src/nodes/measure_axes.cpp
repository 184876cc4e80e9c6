// The axes as a plan has them: whose they are, and one motion.
#include "base/error.h"
#include "drivers/motion_control.h"
#include "nodes/measure_node.h"

namespace mm {
namespace {

constexpr double kLease = 0.5;                                   // s that the axes are taken for
constexpr double kFirstAnswer = 3.0;                             // s for the first answer on a new connection
constexpr std::chrono::milliseconds kRenewal(100), kIdle(1000);  // between renewals; between plans
constexpr std::chrono::milliseconds kBusy(1000);                 // for which a computer may be held up
constexpr double kRecovery = 10.0;    // s within which a controller must answer again
const ros::WallDuration kLook(0.02);  // s between looks at it
const char* const kDriverGone = "the axis driver has stopped; home again, then continue from this move";

}  // namespace

void MeasureNode::takeAxes(const std::string& plan) {
  lost_ = 0;
  owner_ = ros::this_node::getName() + " (" + plan + ")";
  {
    std::unique_lock<std::mutex> lock(mutex_);
    contact_.wait_for(lock, std::chrono::seconds(5), [this] { return motion_.has_value(); });
    if (!motion_) throw Error(kDriverGone);
    lostTicket_.clear();
    lapse_.clear();
  }
  stopsBefore_ = takeTicket();
}

/// @return the stops until then. @throw Error
std::uint32_t MeasureNode::takeTicket() {
  measuring_machine::TakeMotion take;
  take.request.owner = owner_;
  take.request.seconds = kLease;
  if (!take_.callAnew(take, kFirstAnswer)) throw Error(kDriverGone);
  if (!take.response.success) throw Error(take.response.message);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    lapse_.clear();
    ticket_ = take.response.ticket;
    leased_ = Wall::now();
  }
  contact_.notify_all();
  return take.response.stops;
}

// A computer that was busy for a moment does not end a plan of hours: its motion was stopped, and it goes on
// with a new lease. After a stop there is none; and whatever stood still for longer does not move on by
// itself.
void MeasureNode::keepLease() {
  std::string lapse;
  Wall::time_point last;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    lapse = lapse_;
    last = leased_;
  }
  if (lapse.empty()) return;
  const auto requireBusy = [&] {
    if (Wall::now() - last > kBusy) throw Error("the plan was ended: " + lapse + "; continue from this move");
  };
  requireBusy();
  if (++lost_ > retries_) throw Error("the plan was ended: " + lapse);
  ROS_WARN("axes: %s; they are taken again (%d of %d)", lapse.c_str(), lost_, retries_);
  if (takeTicket() != stopsBefore_) throw Error("the plan was ended: the axes were stopped");
  requireBusy();  // until it was granted
}

void MeasureNode::renewAll() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!over_) {
    contact_.wait(lock, [this] { return over_ || (ticket_ != 0 && lostTicket_.empty() && lapse_.empty()); });
    contact_.wait_for(lock, kRenewal, [this] { return over_.load(); });
    const std::uint64_t ticket = ticket_;
    if (ticket == 0) continue;
    if (left()) {
      lostTicket_ = "its client has not renewed the lease in time";
      lock.unlock();
      giveAxes();
      lock.lock();
    } else {
      lock.unlock();
      renew(ticket);
      lock.lock();
    }
    contact_.notify_all();
  }
}

// With `mutex_` held.
bool MeasureNode::left() const {
  return lease_ > 0.0 && Wall::now() - renewed_ > std::chrono::duration<double>(lease_);
}

void MeasureNode::renew(std::uint64_t ticket) {
  measuring_machine::TakeMotion take;
  take.request.ticket = ticket;
  take.request.owner = owner_;
  take.request.seconds = kLease;
  const bool answered = take_.call(take, kLease);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (ticket_ != ticket) return;
  if (answered && take.response.success) {
    leased_ = Wall::now();
    return;
  }
  if (!answered)
    lapse_ = "the axis driver has not answered the renewal of the lease";
  else
    (take.response.stops == stopsBefore_ ? lapse_ : lostTicket_) = take.response.message;
}

// On the connection of the lease: a motion under way stops with it.
void MeasureNode::giveAxes() {
  measuring_machine::TakeMotion give;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    give.request.ticket = ticket_;
    ticket_ = 0;
  }
  if (give.request.ticket == 0) return;
  give.request.owner = owner_;
  take_.call(give, kLease);
}

// Whoever cancels does not want the tip to stay on the ball: what leaves a surface is not cancelled, only
// stopped.
bool MeasureNode::cancelAsked() { return !ros::ok() || ending_ || (cancel_ && !leaving_); }

void MeasureNode::goOn() {
  if (cancelAsked()) throw Cancelled("cancelled");
  const std::lock_guard<std::mutex> lock(mutex_);
  if (motion_ && motion_->stops != stopsBefore_)
    throw Error("the plan was ended: stopped by " + motion_->stopped_by);
  requireLease();
}

// With `mutex_` held: what is sent without a ticket is another's motion.
void MeasureNode::requireLease() {
  if (!lostTicket_.empty()) throw Error("the plan was ended: " + lostTicket_);
  if (ticket_ == 0) throw Cancelled("cancelled");
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
  goal.placement = placement_;
  goal.stylus = stylus_;
  goOn();
  keepLease();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requireLease();
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
    if (axes_.unheard(kUnheard))
      throw Error(
          "the axis driver did not receive a motion: its connection was lost; continue from this move");
  }
  const auto [state, result] = axes_.end();
  // A touch that came before the cancel counts, and the tip leaves the ball before the plan ends.
  const bool touched = kind == measuring_machine::MoveGoal::PROBE && result.tripped && ros::ok() && !ending_;
  if (cancelAsked() && !touched) throw Cancelled("cancelled");
  if (state == actionlib::TerminalState::SUCCEEDED) {
    lost_ = 0;
    return result.tripped;
  }
  if (state == actionlib::TerminalState::LOST || !axes_.isServerConnected()) throw Error(kDriverGone);
  bool lapsed = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requireLease();
    // The end of the motion may be heard before the answer to the renewal.
    if (lapse_.empty() && Wall::now() - leased_ > std::chrono::duration<double>(kLease))
      lapse_ = state.getText();
    lapsed = !lapse_.empty();
  }
  // The axes rest where they were stopped. A way is gone again; a probing motion begins from its approach.
  const auto again = [&] {
    return kind == measuring_machine::MoveGoal::GO && drive(plan, kind, position, speed, feature);
  };
  if (lapsed) return again();
  if (unsettled(kind, result)) throw UnsettledProbe("axes: " + state.getText());
  if (!lostController(result.outcome) || !answersAgain(state.getText()))
    throw Error("axes: " + state.getText());
  return again();
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
  ROS_WARN("axes: %s; waiting until the controller responds again (%d of %d)", why.c_str(), lost_, retries_);
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
