// What LinuxCNC says, and how it ends a motion.
#include <algorithm>
#include <cmath>

#include "drivers/linuxcnc_controller.h"

namespace mm {
namespace {

constexpr double kChange = 2e-6;  // mm or deg: two of the last decimal of linuxcncrsh
constexpr double kStill = 0.06;   // s without a change of position: at rest
constexpr double kUntaken = 5.0;  // s for a command to be taken
constexpr double kUnsaid = 1.0;   // s at rest after which nothing more is said of a motion
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

// `mm 17 1.0 …` behind the probing motion 17: success and place.
void LinuxCncController::takeMessage(const std::string& text) {
  if (text.rfind("mm ", 0) != 0) return;
  const std::vector<double> values = parseLinuxCncNumbers(text.substr(3));
  if (values.empty() || task_ == Task::kNone || values[0] != static_cast<double>(motion_.id)) return;
  if (values.size() == 8) latched_ = std::vector<double>(values.begin() + 1, values.end());
}

void LinuxCncController::takeError(const std::string& text) {
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
  bool changed = last_.absolute.size() != now.absolute.size();
  for (std::size_t j = 0; j < axes; ++j) {
    const std::size_t place = map_->place(j);
    position[j] = map_->toJoint(j, now.absolute[place]);
    changed = changed || std::abs(now.absolute[place] - last_.absolute[place]) > kChange;
    if ((task_ != Task::kNone || stopAsked_) && gone > 0.0 && state_.position.size() == axes)
      velocity[j] = (position[j] - state_.position[j]) / gone;
  }
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
  state_.alarm = {};
  if (!now.emergency && !now.on)
    state_.alarm = {0, "LinuxCNC's machine is off", "call ~clear_alarm to switch it on"};
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
  const bool rests = last_.came - still_ >= kStill;
  if (stopAsked_ && last_.asked > stopSent_ && rests && !last_.runs) {
    stopAsked_ = false;
    finish(Outcome::kStopped);
  }
  if (task_ == Task::kNone || last_.asked <= taskBegan_) return;
  const bool taken = taken_ > 0.0 && last_.asked > taken_;
  if (last_.emergency || (!last_.on && (taken || task_ != Task::kHoming)))  // homing switches it on
    return finish(Outcome::kStopped, "LinuxCNC was switched off");
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
    for (std::size_t j = 0; j < map_->size(); ++j) {
      const std::size_t place = map_->place(j);
      const double offset = last_.absolute[place] - last_.relative[place];
      edge.position.push_back(map_->toJoint(j, (*latched_)[1 + place] + offset));
      edge.velocity.push_back(std::copysign(motion_.speed[j], motion_.target[j] - edge.position[j]) *
                              state_.feedOverride);
    }
    edges_.push_back(edge);
  }
  finish(tripped ? Outcome::kTripped : Outcome::kReached);
}

}  // namespace mm
