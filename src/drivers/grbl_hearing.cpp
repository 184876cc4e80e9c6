// What a grbl control says, of itself and of its motions, and how it ends one.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/format.h"
#include "drivers/grbl_controller.h"

namespace mm {
namespace {

constexpr double kReportDelay = 5e-3;  // s that the control may take to put a report together
constexpr double kSameLimit = 1e-9;    // m or rad: rounding of two limits that are the same
constexpr double kStepSlack = 0.002;   // mm or deg: reports have three decimals
constexpr int kWholeOverride = 100;    // %
constexpr int kSingleAxes = 2;         // bit of $22 in grblHAL
constexpr double kAlwaysOn = 255.0;    // of $1: motors hold their place at rest
constexpr double kJogBegins = 0.2;     // s after which a jog that is not seen to move has ended
const char* const kDoorText = "the safety door is open";

}  // namespace

// What a report ends: the first row that fits. A feed hold that is left would keep the next motion from
// beginning, and of axes at rest it is not known whether they heard it: a reset ends it. An alarm holds
// nothing.
const std::vector<GrblController::Transition> GrblController::kTransitions = {
    {Phase::kStopping, {GrblShows::kHeld, GrblShows::kHeldByDoor}, false, &GrblController::endStop},
    {Phase::kStopping, {GrblShows::kRest}, true, &GrblController::endStop},
    {Phase::kStopping, {GrblShows::kLocked, GrblShows::kNotHomed}, true, &GrblController::endStopInAlarm},
    {Phase::kFree, {GrblShows::kHeld}, false, &GrblController::endStop},
    {Phase::kAnswered, {GrblShows::kRest}, true, &GrblController::arrive},
    {Phase::kAnswered, {GrblShows::kNotHomed}, true, &GrblController::endHoming},
};

void GrblController::take(const std::string& line, double time) {
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    if (understood(line, time)) {
      damaged_ = 0;
    } else if (line.front() != '$' && line.front() != '>' && ++damaged_ >= kLinkDamaged) {  // no echoes
      trouble_ =
          "received data are not grbl protocol; check the baud rate (last: '" + line.substr(0, 40) + "')";
      for (char& c : trouble_)
        if (static_cast<unsigned char>(c) < ' ' || static_cast<unsigned char>(c) > '~') c = '.';
    }
  } catch (const std::exception& e) {
    trouble_ = e.what();  // of writing: lost
  }
}

bool GrblController::understood(const std::string& line, double time) {
  if (const auto report = parseGrblReport(line))
    takeReport(*report, time);
  else if (const auto answer = parseGrblAnswer(line))
    takeAnswer(*answer);
  else if (const auto alarm = parseGrblAlarm(line))
    takeAlarm(*alarm);
  else if (const auto probe = parseGrblProbe(line))
    takeProbe(*probe, time);
  else if (const auto setting = parseGrblSetting(line))
    settings_[setting->first] = setting->second;
  else if (isGrblWelcome(line))
    takeWelcome(line);
  else if (line.front() == '[' && line.back() == ']')
    takeInfo(line);
  else
    return false;
  return true;
}

void GrblController::takeInfo(const std::string& line) {
  if (line.rfind("[FIRMWARE:grblHAL]", 0) == 0) hal_ = true;
  if (line.rfind("[OPT:", 0) != 0) return;
  // [OPT:VNM,35,254]: the last number is the receive buffer.
  const std::size_t comma = line.find(',', line.find(',') + 1);
  const int size = comma == std::string::npos ? 0 : std::atoi(line.c_str() + comma + 1);
  if (size >= 64 && size <= 65536) buffer_ = static_cast<std::size_t>(size);
}

void GrblController::takeReport(const GrblReport& report, double time) {
  trouble_.clear();
  const double sent = questionOf(time);
  std::vector<double> machine = report.machine;
  if (!report.offset.empty()) offset_ = report.offset;
  if (machine.empty()) {
    if (offset_.size() != report.work.size()) return;  // WCO comes with one of the next
    for (std::size_t i = 0; i < report.work.size(); ++i) machine.push_back(report.work[i] + offset_[i]);
  }
  roundTrip_ = std::max(0.0, time - sent);
  lastReport_ = time;
  report_ = report;
  report_.machine = machine;
  if (machine.size() < map_->needed()) return;
  takeState(machine, 0.5 * (sent + time));
  takePins(report.pins);
  takeCondition(report);
  begun_ = begun_ || report.state == "Run" || report.state == "Jog";
  judge(sent);
}

void GrblController::takeState(const std::vector<double>& machine, double at) {
  const double gone = at - state_.time;
  std::vector<double> position(map_->size()), velocity(map_->size(), 0.0);
  const bool moves = report_.moves();
  for (std::size_t j = 0; j < map_->size(); ++j) {
    position[j] = map_->toJoint(j, machine[map_->place(j)]);
    if (moves && state_.position.size() == position.size() && gone > 0.0)
      velocity[j] = (position[j] - state_.position[j]) / gone;
  }
  state_.time = std::max(state_.time, at);
  state_.timeUncertainty = 0.5 * roundTrip_;
  state_.position = position;
  state_.velocity = velocity;
}

void GrblController::takePins(const std::string& pins) {
  state_.limitSwitch.assign(map_->size(), 0);
  for (std::size_t j = 0; j < map_->size(); ++j) {
    if (pins.find(map_->letter(j)) == std::string::npos) continue;
    const ControllerAxis& axis = map_->axis(j);
    const bool upper = lastDirection_[j] != 0.0 ? lastDirection_[j] > 0.0
                                                : state_.position[j] > 0.5 * (axis.lower + axis.upper);
    state_.limitSwitch[j] = upper ? 1 : -1;
  }
  const bool closed = pins.find('P') != std::string::npos;
  const bool told = task_ == Task::kProbing || task_ == Task::kGuarded;  // with what was latched
  if (closed != state_.probeClosed && !told) edges_.push_back(seenEdge(state_, closed, reportPeriod_));
  state_.probeClosed = closed;
}

// Override, hold, and what keeps it from moving.
void GrblController::takeCondition(const GrblReport& report) {
  if (report.feedOverride > 0) state_.feedOverride = 0.01 * report.feedOverride;
  // Somebody's: faster than was asked for is faster than the URDF may allow. Slower is an operator's right.
  if (report.feedOverride > kWholeOverride) link_->write(grblOverride(1.0));
  const GrblShows shows = report.shows();
  state_.held = shows == GrblShows::kHeld || shows == GrblShows::kHeldByDoor;
  if (report.state != "Alarm") locked_ = false;  // somebody reset it
  // A door holds where it is: closed, it waits for ~resume.
  if (state_.alarm.text == kDoorText && !report.doorIsOpen()) state_.alarm = {};
  if (shows == GrblShows::kRest && task_ == Task::kNone) {
    state_.alarm = {};  // cleared, here or at its panel
    clearing_ = false;
  }
  if (state_.alarm.present()) return;
  if (report.doorIsOpen())
    state_.alarm = {0, kDoorText, "close it, then call ~resume, or ~stop to cancel the motion"};
  else if (report.state == "Alarm" && report.substate > 0)
    takeAlarm(report.substate);
  else if (report.state == "Alarm" && task_ != Task::kHoming)
    state_.alarm = {0, "the control is locked", "home, or call ~clear_alarm"};
}

GrblController::Phase GrblController::phase() const {
  if (resetAsked_) return Phase::kResetting;
  if (stopAsked_) return Phase::kStopping;
  if (task_ == Task::kNone) return Phase::kFree;
  return answered_ ? Phase::kAnswered : Phase::kSent;
}

// By a report that was asked for at `sent`.
void GrblController::judge(double sent) {
  const Phase now = phase();
  const bool since = sent > (now == Phase::kStopping ? stopSent_.load() : taskBegan_);
  if (task_ == Task::kJog && now == Phase::kAnswered && !begun_ && sent - taskBegan_ <= kJogBegins) return;
  for (const Transition& row : kTransitions) {
    if (row.phase != now || (row.since && !since)) continue;
    if (std::count(row.shows.begin(), row.shows.end(), report_.shows()) == 0) continue;
    return (this->*row.then)();
  }
}

void GrblController::arrive() {
  if (task_ == Task::kHoming) state_.alarm = {};
  for (const std::size_t j : homing_) homed_[j] = true;
  finish(tripped_ ? Outcome::kTripped : Outcome::kReached);
}

// grblHAL stays locked until every axis is homed.
void GrblController::endHoming() {
  if (task_ != Task::kHoming) return;
  arrive();
  state_.alarm = grblAlarm(kGrblHomingRequired);
}

void GrblController::endStopInAlarm() {
  stopAsked_ = false;
  finish(Outcome::kStopped);
}

double GrblController::setting(int id) const {
  const auto found = settings_.find(id);
  return found == settings_.end() ? std::nan("") : found->second;
}

double GrblController::deceleration() const {
  double seconds = 0.0;
  for (std::size_t j = 0; j < motion_.speed.size(); ++j) {
    const double acceleration = setting(120 + static_cast<int>(map_->place(j)));
    if (acceleration > 0.0) seconds = std::max(seconds, motion_.speed[j] / (acceleration * map_->unit(j)));
  }
  return seconds;
}

// Commanded positions at the trip; when it was follows from the way to rest that came after it.
void GrblController::takeProbe(const GrblProbe& probe, double time) {
  if (task_ != Task::kProbing && task_ != Task::kGuarded) return;
  tripped_ = probe.tripped;
  if (!probe.tripped || probe.machine.size() < map_->needed()) return;
  ProbeEdge edge;
  const double rest = deceleration();
  edge.time = std::max(taskBegan_, time - rest - 0.5 * roundTrip_);
  edge.timeUncertainty = rest + roundTrip_ + kReportDelay;
  edge.probing = task_ == Task::kProbing;
  edge.motion = motion_.id;
  for (std::size_t j = 0; j < map_->size(); ++j) {
    edge.position.push_back(map_->toJoint(j, probe.machine[map_->place(j)]));
    const double way = motion_.target[j] - edge.position[j];
    edge.velocity.push_back(std::copysign(motion_.speed[j], way) * state_.feedOverride);
  }
  edges_.push_back(edge);
  state_.probeClosed = true;
}

void GrblController::takeAnswer(int code) {
  if (inFlight_.empty()) return;  // the answer to the empty line, or to one from before a reset
  inFlight_.pop_front();
  pump();
  if (code != 0 && clearing_) {
    clearing_ = false;
    if (code == kGrblCriticalEvent) locked_ = true;  // grblHAL: the next ~clear_alarm resets it first
    if (state_.alarm.present())
      state_.alarm.remedy = "the control refused to clear it, error " + std::to_string(code) + ": " +
                            grblError(code).text + "; " + grblAlarm(state_.alarm.code).remedy;
  }
  const bool last = inFlight_.empty() && waiting_.empty();
  if (code != 0 && task_ != Task::kNone) {
    const Alarm error = grblError(code);
    const std::string text = "the controller rejected it, error " + std::to_string(code) + ": " + error.text +
                             (error.remedy.empty() ? "" : "; " + error.remedy);
    finish(code == kGrblTargetBeyond ? Outcome::kLimit : Outcome::kAlarm, text);
    return;
  }
  if (!last || task_ == Task::kNone) return;
  answered_ = true;
  if (task_ != Task::kHoming) return;
  taskBegan_ = steadySeconds();  // a report from now on has the new zero
  questions_.clear();
}

void GrblController::takeAlarm(int code) {
  if (code == kGrblHomingRequired && task_ == Task::kHoming) return;  // of the other axes
  state_.alarm = grblAlarm(code);
  clearing_ = false;
  state_.velocity.assign(map_->size(), 0.0);  // of a control that says nothing more, too
  if (!grblAlarmKeepsPosition(code)) homed_.assign(map_->size(), false);
  if (emergency_) state_.alarm = {};
  forgetLines();
  report_.state = "Alarm";
  locked_ = grblAlarmIsLimit(code);
  const bool ended = stopAsked_ || emergency_;
  if (code == kGrblHardLimit && task_ == Task::kJog && !ended) {
    // The switch opened: grbl 1.1 takes any change of its pin for a limit. Where it is closed still, the
    // reports say so.
    clearing_ = begun_ = true;
    return endStop();
  }
  finish(ended ? Outcome::kStopped : locked_ ? Outcome::kLimit : Outcome::kAlarm);
}

// The control began anew: because it was told to, or because it lost its power.
void GrblController::takeWelcome(const std::string& line) {
  hal_ = line[0] == 'g' || line.rfind("GrblHAL", 0) == 0;
  forgetLines();
  locked_ = false;
  report_.state.clear();
  const bool asked = resetAsked_ || emergency_;
  while (!questions_.empty() && (!asked || questions_.front() <= resetAt_))
    questions_.pop_front();  // those from before a reset went with it
  if (asked) return endReset();
  if (lastReport_ == 0.0) return;  // the answer to opening the line
  if (state_.alarm.code >= kGrblHomingReset && state_.alarm.code <= kGrblHomingNoSwitch)
    return;  // its own, after these
  lastDirection_.assign(map_->size(), 0.0);
  ++state_.resets;
  homed_.assign(map_->size(), false);
  finish(Outcome::kLost);
}

// What was asked for meanwhile went with the reset, too; but the way off a limit switch goes on.
void GrblController::endReset() {
  resetAsked_ = false;
  if (stopSent_ <= resetAt_) stopAsked_ = false;  // else another feed hold is still on its way
  if (emergency_) homed_.assign(map_->size(), false);
  const bool clears = clearing_ && !emergency_;
  if (task_ != Task::kJog || !clears || stopAsked_) finish(Outcome::kStopped);
  if (clears) send("$X");
}

void GrblController::finish(Outcome outcome, const std::string& note) {
  if (task_ != Task::kNone && state_.outcome == Outcome::kUnderWay) {
    state_.outcome = outcome;
    state_.note = note;
  }
  task_ = Task::kNone;
  homing_.clear();
}

// At rest in feed hold: what is left of the motion is thrown away by a soft reset, which keeps the position.
void GrblController::endStop() {
  const std::lock_guard<std::mutex> lock(byteMutex_);
  resetAsked_ = true;
  resetAt_ = steadySeconds();
  link_->write(std::string(1, kGrblSoftReset));
}

Capabilities GrblController::capabilities() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Capabilities can;
  can.feedHold = can.feedOverride = can.moveOffLimit = true;
  can.guardsPositioning = guard_;
  can.homingByAxis = hal_ && (static_cast<int>(setting(22)) & kSingleAxes) != 0;
  for (std::size_t j = 0; j < map_->size(); ++j) {
    const int place = static_cast<int>(map_->place(j));
    AxisCapability axis;
    axis.maxVelocity = setting(110 + place) / 60.0 * map_->unit(j);
    axis.acceleration = setting(120 + place) * map_->unit(j);
    const double steps = setting(100 + place);
    axis.resolution = (steps > 0.0 ? 1.0 / steps + 0.001 : kStepSlack) * map_->unit(j);
    if (setting(20) == 1.0 && setting(130 + place) > 0.0) {
      const double ends[2] = {map_->toJoint(j, -setting(130 + place)), map_->toJoint(j, 0.0)};
      axis.lower = std::min(ends[0], ends[1]);
      axis.upper = std::max(ends[0], ends[1]);
      const ControllerAxis& urdf = map_->axis(j);
      if (urdf.lower < axis.lower - kSameLimit || urdf.upper > axis.upper + kSameLimit)
        can.notes.push_back("the URDF's limits of " + urdf.name + " reach beyond the control's soft limits");
    }
    can.axes.push_back(axis);
  }
  if (hal_ && !can.homingByAxis)
    can.notes.push_back(
        "single axes cannot be homed ($22 lacks 2): all are homed together, in the controller's own order");
  if (setting(1) < kAlwaysOn)
    can.notes.push_back(format(
        "the motors are switched off %g ms after a motion ($1); $1=255 keeps them powered", setting(1)));
  if (setting(22) == 0.0) can.notes.push_back("homing is not enabled at the control ($22=0)");
  if (setting(21) == 0.0) can.notes.push_back("hard limits are not enabled at the control ($21=0)");
  return can;
}

}  // namespace mm
