// What LinuxCNC says, and how it ends a motion.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "drivers/linuxcnc_controller.h"

namespace mm {
namespace {

constexpr double kChange = 2e-6;  // mm or deg: two of the last decimal of linuxcncrsh
constexpr double kStill = 0.06;   // s without a change of position: at rest
constexpr double kUntaken = 5.0;  // s for a command to be taken
constexpr double kUnsaid = 1.0;   // s at rest after which nothing more is said of a motion
constexpr double kWhole = 1.0;    // a feed override: LinuxCNC tells it in whole percents
constexpr double kSaid = 0.3;     // s within which LinuxCNC says why its machine went off
constexpr double kHomed = 0.2;    // s that all flags must stand: between two sequences they may for a moment
constexpr double kRefall = 1.0;   // s for the flags of axes that are homed already to fall

}  // namespace

// One round at a time: answers do not say to which they belong.
void LinuxCncController::ask() {
  if (next_.asked > 0.0) return;
  const double asked = talk_->ask();
  if (asked == 0.0) return;
  next_ = {};
  next_.asked = lastAsked_ = asked;
}

void LinuxCncController::take(const LinuxCncLine& line, double time) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    try {
      takePart(line, time);
    } catch (const std::exception& e) {
      trouble_ = e.what();
    }
  }
  if (LinuxCncRound::isLast(line)) talk_->answered();
}

void LinuxCncController::takePart(const LinuxCncLine& line, double time) {
  const std::string &word = line.word, &rest = line.rest;
  if (next_.take(line)) {
    damaged_ = 0;
    if (!LinuxCncRound::isLast(line)) return;
    next_.came = time;
    if (next_.complete()) takeRound();
    next_ = {};
    heard_.notify_all();
  } else if (word == "ERROR") {
    damaged_ = 0;
    if (rest != "OK") takeError(rest);
  } else if (word == "OPERATOR_DISPLAY") {
    damaged_ = 0;
    if (rest != "OK") takeMessage(rest);
  } else if (word == "set" || word == "get" || word == "hello" || word == "GET") {
    damaged_ = 0;  // an echo, or a question that was taken apart wrongly
  } else if (++damaged_ >= kLinkDamaged) {
    trouble_ = "what arrives is no language of linuxcncrsh (last: '" + word.substr(0, 40) + "')";
  }
}

// `mm 17 1.0 …` behind the probing motion 17: success, place, where it then was, and the rotation.
void LinuxCncController::takeMessage(const std::string& text) {
  if (text.rfind("mm ", 0) != 0) return;
  const std::vector<double> values = parseLinuxCncNumbers(text.substr(3));
  if (values.empty() || task_ == Task::kNone || values[0] != static_cast<double>(motion_.id)) return;
  if (values.size() == 15) latched_ = std::vector<double>(values.begin() + 1, values.end());
}

void LinuxCncController::takeError(const std::string& text) {
  said_ = text;
  saidAt_ = steadySeconds();
  if (task_ == Task::kNone) return;
  const bool tripped = text.find("robe tripped") != std::string::npos;
  // LinuxCNC says it where the probe closes. On a busy computer what it says of one motion comes within the
  // next, which leads away from the surface.
  if (tripped && !openSeen_) return;
  const bool limit = text.find("limit") != std::string::npos;
  failed_ = tripped ? Outcome::kTripped : limit ? Outcome::kLimit : Outcome::kAlarm;
  note_ = tripped ? "" : "LinuxCNC: " + text;
}

void LinuxCncController::takeRound() {
  const LinuxCncRound now = next_;
  if (now.absolute.size() >= map_->needed()) {
    const double at = 0.5 * (now.asked + now.came);
    takeState(now, at);
    takeProbe(now.probe, at);
  }
  last_ = now;
  if (now.absolute.size() >= map_->needed()) judge();
}

void LinuxCncController::takeState(const LinuxCncRound& now, double at) {
  const double gone = at - state_.time + age_;
  const std::size_t axes = map_->size();
  std::vector<double> position(axes), velocity(axes, 0.0);
  const bool first = last_.absolute.size() != now.absolute.size();
  bool changed = first, driven = false;
  for (std::size_t j = 0; j < axes; ++j) {
    const std::size_t place = map_->place(j);
    position[j] = map_->toJoint(j, now.absolute[place]);
    changed = changed || std::abs(now.absolute[place] - last_.absolute[place]) > kChange;
    driven = driven || (!first && std::abs(now.commanded[place] - last_.commanded[place]) > kChange);
    if (gone > 0.0 && state_.position.size() == axes) velocity[j] = (position[j] - state_.position[j]) / gone;
  }
  if (driven && now.on) driven_ = now.came;
  others_ = task_ == Task::kNone && !stopAsked_ && (now.runs || now.came - driven_ < kStill);
  // Axes that nobody drives are at rest, whatever the last digit of an encoder does.
  if (task_ == Task::kNone && !stopAsked_ && !others_) velocity.assign(axes, 0.0);
  if (changed || still_ == 0.0) still_ = now.came;
  went_ = went_ || (changed && task_ != Task::kNone);
  // Axes that went stand still while LinuxCNC says that it drives them: its task was held up, not the axes,
  // and what it shows is as old as the last change.
  const bool drives = (task_ == Task::kGo || task_ == Task::kProbing) && now.runs && now.feedOverride > 0.0;
  age_ = went_ && drives ? now.came - still_ : 0.0;
  state_.time = std::max(state_.time, at);
  state_.timeUncertainty = 0.5 * (now.came - now.asked) + age_;
  state_.position = position;
  state_.velocity = velocity;
  state_.limitSwitch.assign(axes, 0);
  state_.axisHomed.assign(axes, false);
  for (std::size_t j = 0; j < axes; ++j) {
    const std::size_t joint = jointOf(j);
    if (joint < now.limits.size()) state_.limitSwitch[j] = now.limits[joint] * map_->sign(j);
    if (joint < now.homed.size()) state_.axisHomed[j] = now.homed[joint];
  }
  state_.homed =
      std::all_of(state_.axisHomed.begin(), state_.axisHomed.end(), [](bool homed) { return homed; });
  if (!talk_->commanding() && now.asked > taken_) resetting_ = false;
  state_.emergencyStop = now.emergency || resetting_;
  state_.feedOverride = now.feedOverride;
  state_.held = task_ != Task::kNone && now.feedOverride == 0.0 && now.came - still_ >= kStill;
  off_ = now.on ? 0.0 : off_ > 0.0 ? off_ : now.came;
  state_.alarm = {};
  const std::string onLimit = axisOnLimit();
  // Switched on beside a closed switch it goes off again at once: for a round it looks cleared.
  if (now.on) offSaid_.clear();
  if (now.emergency || (now.on && onLimit.empty())) return;
  state_.alarm = {0, "LinuxCNC's machine is off", "call ~clear_alarm to switch it on"};
  if (!onLimit.empty()) {
    // linuxcncrsh takes no override of limits while the machine is off, and it goes off at once.
    state_.alarm.text += ": " + onLimit;
    state_.alarm.remedy =
        "override limits at LinuxCNC's own panel and jog off it, or turn the axis off it by hand; then call "
        "~clear_alarm";
    return;
  }
  // What it says later is of something else, as that a command is refused.
  if (offSaid_.empty() && std::abs(saidAt_ - off_) < kSaid) offSaid_ = ": " + said_;
  state_.alarm.text += offSaid_;
}

std::string LinuxCncController::axisOnLimit() const {
  for (std::size_t j = 0; j < state_.limitSwitch.size(); ++j)
    if (state_.limitSwitch[j] != 0)
      return map_->names()[j] + " is at its " + (state_.limitSwitch[j] < 0 ? "lower" : "upper") +
             " limit switch";
  return {};
}

void LinuxCncController::takeProbe(bool closed, double at) {
  if (closed && !state_.probeClosed && task_ == Task::kProbing)
    tripSeen_ = at;
  else if (closed != state_.probeClosed)
    edges_.push_back(seenEdge(state_, closed, pollPeriod_));
  state_.probeClosed = closed;
  openSeen_ = openSeen_ || !closed;
}

// Whether the task has ended, by the round that came last.
void LinuxCncController::judge() {
  judgeStop();
  giveOverrideBack();
  const bool rests = last_.came - still_ >= kStill;
  if (task_ == Task::kNone || last_.asked <= taskBegan_) return;
  const bool taken = taken_ > 0.0 && last_.asked > taken_;
  if (last_.emergency) return finish(Outcome::kStopped, "LinuxCNC is in its emergency stop");
  if (!last_.on && (taken || task_ != Task::kHoming)) return judgeOff();  // homing switches it on
  if (task_ == Task::kHoming && taken && !failed_) return judgeHoming();
  if (!rests || state_.held) return;
  if (failed_) return finish(*failed_, note_);
  if (!taken) {
    if (last_.asked - taskBegan_ <= kUntaken) return;
    trouble_ = "LinuxCNC does not take commands";  // nor would the next: the connections are made anew
    return finish(Outcome::kLost, trouble_);
  }
  if (!last_.idle) return;
  if (task_ == Task::kGo) return finish(Outcome::kReached);
  judgeProbing();
}

void LinuxCncController::judgeStop() {
  const bool rests = last_.came - still_ >= kStill;
  if (!refusedStop_.empty() && last_.asked > refusedAt_) {
    // Off, it refuses to abort: there is nothing that it could end.
    if (last_.on || refusedStop_ != "ABORT")
      trouble_ = "LinuxCNC refuses to " + refusedStop_ + "; use the machine's own emergency stop";
    refusedStop_.clear();
  }
  if (!stopAsked_ || last_.asked <= stopSent_ || !rests || last_.runs) return;
  stopAsked_ = false;
  finish(Outcome::kStopped);
  const std::lock_guard<std::mutex> feed(feedMutex_);
  giveBack_ = giveBack_ || last_.feedOverride == 0.0;  // the stop may have overtaken what was to end a hold
}

// The machine went off in a motion: by a limit or a fault, which LinuxCNC says at about the same time, or by
// somebody.
void LinuxCncController::judgeOff() {
  if (failed_) return finish(*failed_, note_);
  if (last_.came - off_ < kSaid) return;
  const std::string onLimit = axisOnLimit();
  if (!onLimit.empty()) return finish(Outcome::kLimit, "LinuxCNC: " + onLimit);
  finish(Outcome::kStopped, "LinuxCNC's machine was switched off");
}

// A hold whose motion is over would keep the next one from beginning. Given back at rest, with nothing left
// that could move for it; again until it is seen, since LinuxCNC refuses it while its machine is off.
void LinuxCncController::giveOverrideBack() {
  const std::lock_guard<std::mutex> feed(feedMutex_);
  const bool settled = !talk_->commanding() && last_.asked > taken_;
  if (settled && !holding_) {
    stands_ = last_.feedOverride == 0.0;
    // One that was asked for while the panel stood at 0 counts from when it does not; and no motion is faster
    // than its speed, which the URDF limits. LinuxCNC refuses it while its machine is off.
    if (!stands_ && last_.on && (owed_ || last_.feedOverride > kWhole)) {
      owed_ = false;
      talk_->command({overrideLine(false)});
      return;
    }
  }
  if (!giveBack_ || !settled || task_ != Task::kNone || stopAsked_) return;
  if (last_.feedOverride > 0.0)
    giveBack_ = false;
  else if (last_.on && !last_.runs && !others_ && last_.came - still_ >= kStill)
    talk_->command({overrideLine(false)});
}

// Axes that were homed before keep their flags until it has begun; where it takes a moment only, their fall
// may not be seen.
void LinuxCncController::judgeHoming() {
  const bool homed =
      std::all_of(homing_.begin(), homing_.end(), [&](std::size_t j) { return state_.axisHomed[j]; });
  if (!homed) {
    fell_ = true;
    homedSince_ = 0.0;
  } else if (homedSince_ == 0.0) {
    homedSince_ = last_.asked;
  }
  const bool rests = last_.came - still_ >= kStill;
  if (homed && rests && last_.asked - homedSince_ > (fell_ ? kHomed : kRefall))
    return finish(Outcome::kReached);
  if (rests && last_.asked - taskBegan_ > homingTimeout_)
    finish(Outcome::kAlarm, "homing has not ended within its time");
}

// In machine coordinates: from where it was commanded to at the end, back by what it went on after the trip,
// which LinuxCNC tells in work coordinates.
std::vector<double> LinuxCncController::latchedPlace() const {
  const std::vector<double>& said = *latched_;
  const std::size_t axes = std::string(kControlLetters).size();
  std::vector<double> place(last_.commanded);
  place.resize(axes, 0.0);
  const double turn = said[1 + 2 * axes] * kDegree;
  const double x = said[1] - said[1 + axes], y = said[2] - said[2 + axes];
  place[0] += x * std::cos(turn) - y * std::sin(turn);
  place[1] += x * std::sin(turn) + y * std::cos(turn);
  for (std::size_t i = 2; i < axes; ++i) place[i] += said[1 + i] - said[1 + axes + i];
  return place;
}

void LinuxCncController::judgeProbing() {
  if (!latched_ && last_.asked - std::max(still_, taken_) < kUnsaid) return;  // it is on its way
  if (!latched_)
    return finish(Outcome::kAlarm,
                  "LinuxCNC did not say what it latched; does another program read its messages?");
  const bool tripped = latched_->front() == 1.0;
  if (tripped) {
    ProbeEdge edge;
    edge.time = tripSeen_ > taskBegan_ ? tripSeen_ : state_.time;
    edge.timeUncertainty = pollPeriod_ + servoPeriod_ + state_.timeUncertainty;
    edge.probing = edge.actual = true;
    edge.motion = motion_.id;
    const std::vector<double> place = latchedPlace();
    for (std::size_t j = 0; j < map_->size(); ++j) {
      edge.position.push_back(map_->toJoint(j, place[map_->place(j)]));
      edge.velocity.push_back(std::copysign(motion_.speed[j], motion_.target[j] - edge.position[j]) *
                              state_.feedOverride);
    }
    edges_.push_back(edge);
  }
  finish(tripped ? Outcome::kTripped : Outcome::kReached);
}

}  // namespace mm
