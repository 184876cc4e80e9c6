// What LinuxCNC shows, and how a task ends.
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "drivers/linuxcnc_controller.h"

namespace mm {
namespace {

constexpr double kChange = 2e-6;    // mm or deg: what is commanded has changed
constexpr double kStill = 0.06;     // s without a change of what is commanded: at rest
constexpr double kNoEffect = 0.25;  // s that a stop that was taken may have no effect
constexpr double kOwnEffect = 0.2;  // s that it is busy with a command that moves nothing: it was switched on
constexpr double kUntaken = 5.0;    // s for a command to be taken
constexpr double kWhole = 1.001;    // a feed override above the whole
constexpr double kSaid = 0.3;       // s within which LinuxCNC says why its machine went off
constexpr double kArrived = 0.02;   // mm or deg: it ended at its target, and not on its way
constexpr const char* kSwitchOn = "call ~clear_alarm to switch it on";
constexpr const char* kOffLimit =
    "override limits at LinuxCNC's own panel and jog off it, or turn the axis off it by hand; then call "
    "~clear_alarm";

bool has(const std::string& text, const char* word) { return text.find(word) != std::string::npos; }

}  // namespace

void LinuxCncController::take(const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    const LinuxCncLine line = parseLinuxCncLine(text);
    switch (line.kind) {
      case LinuxCncLine::Kind::kTrouble:
        trouble_ = line.trouble;
        break;
      case LinuxCncLine::Kind::kTaken:
        taken_ = std::max(taken_, line.taken);
        serial_ = line.serial;
        break;
      case LinuxCncLine::Kind::kState:
        takeState(line.state);
    }
  } catch (const std::exception& e) {
    trouble_ = e.what();
  }
  first_.notify_all();
}

void LinuxCncController::takeState(const LinuxCncState& now) {
  takeReadings(now);
  takeErrors(now);
  takeProbe(now);
  state_.alarm = alarmOf(now);
  judge(now);
  tendOverride(now);
  last_ = now;
}

void LinuxCncController::takeReadings(const LinuxCncState& now) {
  const std::size_t axes = map_->size();
  const double gone = last_ ? now.time - last_->time : 0.0;
  const std::vector<double> before = state_.position;
  state_.position.resize(axes);
  state_.velocity.assign(axes, 0.0);
  state_.limitSwitch.assign(axes, 0);
  state_.axisHomed.assign(axes, false);
  for (std::size_t j = 0; j < axes; ++j) {
    const std::size_t place = map_->place(j), joint = jointOf(j);
    state_.position[j] = map_->toJoint(j, now.actual[place]);
    if (last_ && std::abs(now.commanded[place] - last_->commanded[place]) > kChange) driven_ = now.time;
    if (gone > 0.0 && before.size() == axes) state_.velocity[j] = (state_.position[j] - before[j]) / gone;
    if (joint < now.limits.size())
      state_.limitSwitch[j] = static_cast<int>(now.limits[joint]) * map_->sign(j);
    if (joint < now.homed.size()) state_.axisHomed[j] = now.homed[joint];
  }
  const bool ours = task_ != Task::kNone || stopSaid_ > 0.0;
  if (ours || !now.on || !settled(now)) ownAt_ = now.time;
  others_ = now.time - ownAt_ > kOwnEffect && (now.busy || !rests(now));
  // Axes that nobody drives are at rest, whatever the last digit of an encoder does.
  if (!ours && !others_) state_.velocity.assign(axes, 0.0);
  state_.time = std::max(state_.time, now.time);
  state_.timeUncertainty = now.within;
  state_.homed =
      std::all_of(state_.axisHomed.begin(), state_.axisHomed.end(), [](bool homed) { return homed; });
  if (settled(now)) {
    resetting_ = false;
    settledAt_ = now.time;
  } else if (now.time - settledAt_ > kUntaken) {
    trouble_ = "LinuxCNC does not take commands";
  }
  if (now.emergency) emergencySaid_ = 0.0;
  state_.emergencyStop = now.emergency || resetting_;
  state_.feedOverride = now.override;
  state_.held = task_ != Task::kNone && now.override == 0.0 && rests(now);
}

void LinuxCncController::takeErrors(const LinuxCncState& now) {
  for (const std::string& text : now.said) {
    said_ = text;
    saidAt_ = now.time;
    if (error_.empty()) error_ = text;
  }
  // Switched on beside a closed switch it goes off again at once: for a moment it looks cleared.
  off_ = now.on ? 0.0 : off_ > 0.0 ? off_ : now.time;
  if (now.on) offSaid_.clear();
  // What it says later is of something else, as that a command is refused.
  if (off_ > 0.0 && offSaid_.empty() && !said_.empty() && std::abs(saidAt_ - off_) < kSaid)
    offSaid_ = ": " + said_;
}

void LinuxCncController::takeProbe(const LinuxCncState& now) {
  if (now.probe && !state_.probeClosed && task_ == Task::kProbing)
    tripSeen_ = now.time;
  else if (now.probe != state_.probeClosed)
    edges_.push_back(seenEdge(state_, now.probe, period_));
  state_.probeClosed = now.probe;
  openSeen_ = openSeen_ || !now.probe;
}

Alarm LinuxCncController::alarmOf(const LinuxCncState& now) const {
  const std::string onLimit = axisOnLimit();
  if (now.emergency || (now.on && onLimit.empty())) return {};
  if (!onLimit.empty()) return {0, "LinuxCNC's machine is off: " + onLimit, kOffLimit};
  return {0, "LinuxCNC's machine is off" + offSaid_, kSwitchOn};
}

std::string LinuxCncController::axisOnLimit() const {
  for (std::size_t j = 0; j < state_.limitSwitch.size(); ++j)
    if (state_.limitSwitch[j] != 0)
      return map_->names()[j] + " is at its " + (state_.limitSwitch[j] < 0 ? "lower" : "upper") +
             " limit switch";
  return {};
}

/// Every command of this driver is in what the state shows.
bool LinuxCncController::settled(const LinuxCncState& now) const {
  return taken_ >= sent_ && now.echo - serial_ >= 0;
}

bool LinuxCncController::rests(const LinuxCncState& now) const { return now.time - driven_ >= kStill; }

bool LinuxCncController::arrived(const LinuxCncState& now) const {
  for (std::size_t i = 0; i < goal_.size(); ++i)
    if (std::abs(goal_[i] - now.commanded[i]) > kArrived) return false;
  return true;
}

// How a task ends: by the first of these lines that holds.
void LinuxCncController::judge(const LinuxCncState& now) {
  const bool taken = settled(now);
  // Between two of its steps LinuxCNC may be idle for a moment, with the trip of the motion before.
  if (!taken) untakenAt_ = now.time;
  if (!taken || now.busy) idleSince_ = now.time;
  const bool ended = rests(now) && now.time - idleSince_ >= kStill;
  if (stopSaid_ > 0.0) {
    // Counted from when it was taken: said again each time that this is heard late, it would never be over.
    if (!ended && taken && now.time - std::max(stopSaid_.load(), untakenAt_) > kNoEffect) stop();
    if (!ended || now.time <= stopSaid_) return;
    giveBack_ = giveBack_ || now.override == 0.0;  // the stop may have overtaken what was to end a hold
    finish(Outcome::kStopped, {});
    stopSaid_ = 0.0;
    return;
  }
  if (task_ == Task::kNone || now.time <= began_) return;
  const bool homing = task_ == Task::kHoming, probing = task_ == Task::kProbing;
  const bool off = !now.on && (taken || !homing);  // homing switches it on
  const bool offExplained = off && (!error_.empty() || now.time - off_ > kSaid);
  const bool homed = homing && std::all_of(homing_.begin(), homing_.end(),
                                           [&](std::size_t j) { return state_.axisHomed[j]; });
  const std::string onLimit = axisOnLimit(), words = "LinuxCNC: " + error_;
  const bool limit = has(error_, "limit"), late = now.time - began_ > homingTimeout_;
  const struct {
    bool holds;
    Outcome outcome;
    std::string note;
  } endings[] = {
      {now.emergency, Outcome::kStopped, "LinuxCNC is in its emergency stop"},
      {offExplained && limit, Outcome::kLimit, words},
      {offExplained && !error_.empty(), Outcome::kAlarm, words},
      {offExplained && !onLimit.empty(), Outcome::kLimit, "LinuxCNC: " + onLimit},
      {offExplained, Outcome::kStopped, "LinuxCNC's machine was switched off"},
      {off || !ended || state_.held, Outcome::kUnderWay, {}},
      {now.lapses != lapses_, Outcome::kStopped,
       "the driver's heartbeat was missing, so the axes were stopped"},
      {homed, Outcome::kReached, {}},
      {homing && !error_.empty(), Outcome::kAlarm, words},
      {homing && late, Outcome::kAlarm, "homing did not finish in time"},
      {homing, Outcome::kUnderWay, {}},
      {probing && now.tripped, Outcome::kTripped, {}},
      {arrived(now), Outcome::kReached, {}},
      {!probing && now.probe && openSeen_, Outcome::kTripped, {}},
      {limit, Outcome::kLimit, words},
      {!error_.empty(), Outcome::kAlarm, words},
      {true, Outcome::kStopped, "LinuxCNC ended the motion before its target; was it stopped at the panel?"},
  };
  for (const auto& ending : endings) {
    if (!ending.holds) continue;
    if (ending.outcome == Outcome::kTripped && probing) edges_.push_back(latchOf(now));
    if (ending.outcome != Outcome::kUnderWay) finish(ending.outcome, ending.note);
    return;
  }
}

// What motion latched; it saw the trip in this servo period or the one before.
ProbeEdge LinuxCncController::latchOf(const LinuxCncState& now) const {
  ProbeEdge edge;
  edge.time = tripSeen_ > began_ ? tripSeen_ : state_.time;
  edge.timeUncertainty = period_ + servoPeriod_ + state_.timeUncertainty;
  edge.probing = edge.actual = true;
  edge.motion = motion_.id;
  for (std::size_t j = 0; j < map_->size(); ++j) {
    edge.position.push_back(map_->toJoint(j, now.probed[map_->place(j)]));
    edge.velocity.push_back(std::copysign(motion_.speed[j], motion_.target[j] - edge.position[j]) *
                            now.override);
  }
  return edge;
}

void LinuxCncController::finish(Outcome outcome, const std::string& note) {
  if (task_ != Task::kNone && state_.outcome == Outcome::kUnderWay) {
    state_.outcome = outcome;
    state_.note = note;
  }
  task_ = Task::kNone;
  homing_.clear();
  state_.velocity.assign(map_->size(), 0.0);
  giveBack_ = giveBack_ || holding_;
  holding_ = false;
}

// A hold whose motion is over would keep the next one from beginning: it is given back at rest, with nothing
// left that could move for it. What was asked for while the panel stood at 0 counts from when it does not. No
// motion is faster than its speed, which the URDF limits.
void LinuxCncController::tendOverride(const LinuxCncState& now) {
  if (!settled(now) || holding_) return;
  const bool stands = now.override == 0.0,
             idle = task_ == Task::kNone && stopSaid_ == 0.0 && !others_ && rests(now);
  if (stands ? giveBack_ && idle : owed_ || now.override > kWhole) giveOverride(share_);
  if (!stands) giveBack_ = owed_ = false;
}

}  // namespace mm
