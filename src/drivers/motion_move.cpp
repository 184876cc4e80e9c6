// One motion, from the request to its outcome.
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "drivers/motion_control.h"
#include "machine/joint_units.h"

namespace mm {

// An alarm is no reason: homing or the way off a limit may be what ends it.
void MotionControl::requireAnswering(std::uint32_t stopsSeen) const {
  if (stopping_ > 0) throw Error("a stop is under way; wait until the axes rest");
  if (leaving_) throw Error("the driver is shutting down");
  if (!lost_.empty() || !forbidden_.empty() || emergency() || state_.emergencyStop) throw Error(faultText());
  if (stops_ != stopsSeen) throw Error("stopped by " + stoppedBy());
  // Another motion's stop has not come through yet, or somebody moves them at the control.
  if (state_.moving) throw Error("the axes still move; wait until they rest, or call ~stop");
}

void MotionControl::requireReady(std::uint32_t stopsSeen) const {
  requireAnswering(stopsSeen);
  const std::string fault = faultText();
  if (!fault.empty()) throw Error(fault);
  if (!(state_.homed && homedHere_)) throw Error("not homed; call ~home first");
}

void MotionControl::beginCurrent(bool armed) {
  current_.emplace(Current{});
  current_->armed = armed;
  current_->from = state_.position;
}

MotionControl::Report MotionControl::move(AxesMotion motion, const Mover& mover, std::uint32_t stopsSeen,
                                          const Watch& watch) {
  checkTarget(joints_, motion.target);
  checkSpeeds(joints_, motion);
  owner_.begin(mover, motion.probing ? "a probing motion" : "a motion");
  const EndOfMotion end(*this);
  withDevice([&] {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      requireReady(stopsSeen);
      if (motion.probing && state_.probeClosed)
        throw Error(std::string(kProbeIsClosed) + "; retract it, or check whether it sticks");
      motion.id = ++lastId_;
      // A switch that chatters may be open at this moment, and closed at the next.
      motion.leaving = state_.probeClosed || (touched_ && !motion.probing);
      beginCurrent(!motion.leaving);
      current_->motion = motion;
    }
    controller_->move(motion);
  });
  if (stops_ != stopsSeen) sendStop();
  std::unique_lock<std::mutex> lock(mutex_);
  const bool cancelled = awaitEnd(lock, stopsSeen, watch);
  if (ending_) throw Error("the driver is shutting down");
  if (cancelled || current_->forced != Outcome::kUnderWay) {
    lock.unlock();
    sendStop();
    lock.lock();
    if (!awaitRest(lock))
      current_->why += "; it is unknown whether the axes have stopped" + (lost_.empty() ? "" : ": " + lost_);
  }
  const Outcome outcome = current_->forced == Outcome::kUnderWay ? state_.outcome : current_->forced;
  if (outcome == Outcome::kTripped || outcome == Outcome::kReached) touched_ = outcome == Outcome::kTripped;
  if (motion.probing && current_->forced == Outcome::kUnderWay && state_.outcome == Outcome::kTripped)
    unsuccessful_ = 0;
  else if (motion.probing && state_.outcome == Outcome::kReached)
    ++unsuccessful_;
  return judge(*current_, cancelled);
}

// Until the motion under way has ended, or must be ended. @return whether `watch` cancelled it.
bool MotionControl::awaitEnd(std::unique_lock<std::mutex>& lock, std::uint32_t stopsSeen,
                             const Watch& watch) {
  while (!ending_) {
    changed_.wait_for(lock, std::chrono::milliseconds(20));
    if (stops_ != stopsSeen) force(Outcome::kStopped, "stopped by " + stoppedBy());
    if (current_->forced != Outcome::kUnderWay) return false;
    const double age = owing();
    if (age > settings_.silence) {
      force(Outcome::kLost, "the controller has not answered for " + shortSeconds(age) + "; stop was sent");
      return false;
    }
    if (state_.held && !current_->heldSince) current_->heldSince = Wall::now();
    if (!state_.held) current_->heldSince.reset();
    if (current_->heldSince &&
        Wall::now() - *current_->heldSince > std::chrono::duration<double>(settings_.holdLimit)) {
      force(Outcome::kHeld, "in feed hold for longer than " + shortSeconds(settings_.holdLimit));
      return false;
    }
    const bool said = state_.motion == current_->motion.id && state_.outcome != Outcome::kUnderWay;
    if (said && !state_.moving) return false;
    if (!watch) continue;
    const AxesState now = state_;
    lock.unlock();
    const bool goOn = watch(now);
    lock.lock();
    if (!goOn) return true;
  }
  return false;
}

// Success is what the readings say, whatever the controller says of itself.
MotionControl::Report MotionControl::judge(const Current& current, bool cancelled) const {
  Report report;
  report.position = state_.position;
  report.outcome = current.forced;
  report.message = current.why;
  if (cancelled) {
    report.outcome = Outcome::kStopped;
    report.message = "cancelled" + current.why;
    return report;
  }
  if (current.forced != Outcome::kUnderWay) return report;
  report.outcome = state_.outcome;
  switch (state_.outcome) {
    case Outcome::kReached:
      break;
    case Outcome::kTripped:
      if (!current.motion.probing) report.message = tripWords(current);
      return report;
    case Outcome::kStopped:
      report.message = "stopped at the controller" + (state_.note.empty() ? "" : ": " + state_.note);
      return report;
    default:
      report.message = state_.note.empty() ? faultText() : state_.note;
      if (report.message.empty())
        report.message = "the controller ended the motion: " + outcomeName(state_.outcome);
      return report;
  }
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const JointUnit unit = readingUnit(joints_[j]);
    const bool turns = joints_[j].kind == JointKind::kRotary;
    double tolerance = turns ? settings_.rotaryTolerance : settings_.tolerance;
    if (j < capabilities_.axes.size()) tolerance = std::max(tolerance, capabilities_.axes[j].resolution);
    const double away = state_.position[j] - current.motion.target[j];
    if (std::abs(away) <= tolerance) continue;
    report.outcome = Outcome::kAlarm;
    report.message =
        format("%s stopped %.6g %s from its target %.6g %s (tolerance %.3g %s)", axes_[j].c_str(),
               away / unit.factor, unit.symbol, current.motion.target[j] / unit.factor, unit.symbol,
               tolerance / unit.factor, unit.symbol);
    break;
  }
  return report;
}

}  // namespace mm
