#include "drivers/grbl_controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include "base/error.h"

namespace mm {
namespace {

constexpr char kSoftReset = '\x18';
constexpr double kAgain = 0.3;        // s until a question is asked once more
constexpr double kUnwelcome = 1.5;    // s for the greeting after a soft reset
constexpr double kStepSlack = 0.002;  // mm or deg: reports have three decimals

}  // namespace

GrblController::GrblController() = default;
GrblController::~GrblController() { close(); }

void GrblController::open(const ControllerSetup& setup) {
  refuseUnknownParametersOf(setup, "grbl",
                            {"address", "axes", "sign", "zero", "report_rate", "guard", "connect_timeout",
                             "homing_timeout", "off_limit_mm"});
  map_ = std::make_unique<AxisMap>(setup, kControlLetters);
  reportPeriod_ = 1.0 / numberParameterOf(setup, "report_rate", 20.0, 1.0, 200.0);
  connectTimeout_ = numberParameterOf(setup, "connect_timeout", connectTimeout_, 0.1, 60.0);
  homingTimeout_ = numberParameterOf(setup, "homing_timeout", homingTimeout_, 1.0, 3600.0);
  offLimit_ = numberParameterOf(setup, "off_limit_mm", offLimit_, 0.01, 100.0);
  const auto guard = setup.parameters.find("guard");
  if (guard != setup.parameters.end()) {
    if (guard->second != "true" && guard->second != "false")
      throw InputError("parameter 'guard' of the grbl controller is '" + guard->second + "'; true or false");
    guard_ = guard->second == "true";
  }
  const auto address = setup.parameters.find("address");
  if (address == setup.parameters.end() || address->second.empty())
    throw InputError(
        "parameter 'address' of the grbl controller is missing: tcp:<host>:<port> or "
        "serial:<device>[:<baud>]");
  homed_.assign(map_->size(), false);
  lastDirection_.assign(map_->size(), 0.0);
  link_ = std::make_unique<DeviceLink>(address->second,
                                       [this](const std::string& line, double time) { take(line, time); });
  begin();
}

void GrblController::begin() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    forgetLines();
    asked_ = lastAsked_ = lastReport_ = 0.0;
    away_.clear();
    trouble_.clear();
    damaged_ = 0;
    offset_.clear();
    resetAsked_ = false;
  }
  link_->connect(connectTimeout_);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    connected_ = steadySeconds();
    send("");  // ends whatever half a line it has
    ask();
  }
  awaitReady(connectTimeout_);
}

// Asks until the control has reported, with the offset of its work coordinates, and said its settings.
void GrblController::awaitReady(double seconds) {
  const double end = steadySeconds() + seconds;
  bool settingsAsked = false;
  for (double next = 0.0; steadySeconds() < end;) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const bool reported = lastReport_ > 0.0;
      const bool busy = report_.state != "Idle" && report_.state != "Alarm";
      if (reported && busy && !resetAsked_) endStop();  // it moves for somebody who has gone
      if (reported && !busy && !settingsAsked) {
        settings_.clear();
        send("$$");
        send("$I");
        settingsAsked = true;
      }
      if (reported && settingsAsked && settings_.count(110) > 0 && !offset_.empty() && inFlight_.empty()) {
        if (report_.machine.size() < map_->needed())
          throw InputError(link_->address() + ": the control reports " +
                           std::to_string(report_.machine.size()) + " axes, " +
                           std::to_string(map_->needed()) + " are needed; is it built for as many?");
        return;
      }
      if (steadySeconds() >= next) {
        next = steadySeconds() + 0.05;
        ask();
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string why = "no status report came";
  if (lastReport_ > 0.0) why = "it reports, but does not say its settings ($$)";
  if (lastReport_ > 0.0 && settings_.count(110) > 0) why = "its reports have no WCO";
  if (!trouble_.empty()) why = trouble_;
  throw Error(link_->address() + " does not answer as grbl 1.1 or grblHAL: " + why +
              "; look at its power, the address and the baud rate");
}

void GrblController::reconnect() {
  link_->close();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    homed_.assign(map_->size(), false);
    finish(Outcome::kLost);
  }
  try {
    begin();
  } catch (const std::exception& e) {
    const std::lock_guard<std::mutex> lock(mutex_);
    away_ = e.what();  // what it says now and then does not tell which lines it has taken
    throw;
  }
  if (emergency_) emergencyStop();
}

void GrblController::close() {
  if (!link_) return;
  try {
    if (link_->connected()) link_->write("!");
  } catch (const std::exception&) {
    // Gone already.
  }
  link_->close();
}

Capabilities GrblController::capabilities() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto setting = [&](int id) {
    const auto found = settings_.find(id);
    return found == settings_.end() ? std::nan("") : found->second;
  };
  Capabilities can;
  can.feedHold = can.feedOverride = can.moveOffLimit = true;
  can.guardsPositioning = guard_;
  can.homingByAxis = hal_;
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
      if (urdf.lower < axis.lower - 1e-9 || urdf.upper > axis.upper + 1e-9)
        can.notes.push_back("the URDF's limits of " + urdf.name + " reach beyond the control's soft limits");
    }
    can.axes.push_back(axis);
  }
  if (setting(22) == 0.0) can.notes.push_back("homing is not enabled at the control ($22=0)");
  if (setting(21) == 0.0) can.notes.push_back("hard limits are not enabled at the control ($21=0)");
  return can;
}

double GrblController::deceleration() const {
  double seconds = 0.0;
  for (std::size_t j = 0; j < motion_.speed.size(); ++j) {
    const auto found = settings_.find(120 + static_cast<int>(map_->place(j)));
    if (found != settings_.end() && found->second > 0.0)
      seconds = std::max(seconds, motion_.speed[j] / (found->second * map_->unit(j)));
  }
  return seconds;
}

// ---- sending ----------------------------------------------------------------------------------------------

void GrblController::send(const std::string& line) {
  waiting_.push_back(line + "\n");
  pump();
}

// Character counting: never more on the way than the control's receive buffer holds.
void GrblController::pump() {
  std::size_t flying = 0;
  for (const std::size_t characters : inFlight_) flying += characters;
  while (!waiting_.empty() && flying + waiting_.front().size() < buffer_) {
    link_->write(waiting_.front());
    flying += waiting_.front().size();
    inFlight_.push_back(waiting_.front().size());
    waiting_.pop_front();
  }
}

void GrblController::ask() {
  const double now = steadySeconds();
  if (asked_ > 0.0 && now - lastAsked_ < kAgain) return;
  link_->write("?");
  lastAsked_ = now;
  if (asked_ == 0.0) asked_ = now;
}

void GrblController::forgetLines() {
  waiting_.clear();
  inFlight_.clear();
}

// ---- hearing ----------------------------------------------------------------------------------------------

void GrblController::take(const std::string& line, double time) {
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    if (const auto report = parseGrblReport(line)) return takeReport(*report, time);
    if (const auto answer = parseGrblAnswer(line)) return takeAnswer(*answer);
    if (const auto alarm = parseGrblAlarm(line)) return takeAlarm(*alarm);
    if (const auto probe = parseGrblProbe(line)) return takeProbe(*probe, time);
    if (const auto setting = parseGrblSetting(line)) {
      settings_[setting->first] = setting->second;
      damaged_ = 0;
      return;
    }
    if (isGrblWelcome(line)) {
      hal_ = line[0] == 'g' || line.rfind("GrblHAL", 0) == 0;
      return takeWelcome();
    }
    if (line.rfind("[OPT:", 0) == 0) {
      // [OPT:VNM,35,254]: the last number is the receive buffer.
      const std::size_t comma = line.find(',', line.find(',') + 1);
      const int size = comma == std::string::npos ? 0 : std::atoi(line.c_str() + comma + 1);
      if (size >= 64 && size <= 65536) buffer_ = static_cast<std::size_t>(size);
    }
    if (line.rfind("[FIRMWARE:grblHAL]", 0) == 0) hal_ = true;
    if (line.front() == '[' && line.back() == ']') {
      damaged_ = 0;
      return;
    }
    if (line.front() == '$' || line.front() == '>') return;  // echoes of start-up blocks
    if (++damaged_ >= kLinkDamaged) {
      trouble_ = "what arrives is no language of grbl (last: '" + line.substr(0, 40) + "')";
      for (char& c : trouble_)
        if (static_cast<unsigned char>(c) < ' ' || static_cast<unsigned char>(c) > '~') c = '.';
    }
  } catch (const std::exception& e) {
    trouble_ = e.what();  // of writing: lost
  }
}

void GrblController::takeReport(const GrblReport& report, double time) {
  damaged_ = 0;
  trouble_.clear();
  std::vector<double> machine = report.machine;
  if (!report.offset.empty()) offset_ = report.offset;
  if (machine.empty()) {
    if (offset_.size() != report.work.size()) {
      asked_ = 0.0;
      return;  // WCO comes with one of the next
    }
    for (std::size_t i = 0; i < report.work.size(); ++i) machine.push_back(report.work[i] + offset_[i]);
  }
  const double sent = asked_ > 0.0 ? asked_ : time;
  asked_ = 0.0;
  roundTrip_ = std::max(0.0, time - sent);
  lastReport_ = time;
  const std::string before = report_.pins;
  report_ = report;
  report_.machine = machine;
  if (machine.size() < map_->needed()) return;

  const double at = 0.5 * (sent + time);
  const double gone = at - state_.time;
  std::vector<double> position(map_->size()), velocity(map_->size(), 0.0);
  const bool moves = report.state == "Run" || report.state == "Jog" || report.state == "Home" ||
                     (report.state == "Hold" && report.substate != 0);
  for (std::size_t j = 0; j < map_->size(); ++j) {
    position[j] = map_->toJoint(j, machine[map_->place(j)]);
    if (moves && state_.position.size() == position.size() && gone > 0.0)
      velocity[j] = (position[j] - state_.position[j]) / gone;
  }
  state_.time = std::max(state_.time, at);
  state_.timeUncertainty = 0.5 * roundTrip_;
  state_.position = position;
  state_.velocity = velocity;
  state_.limitSwitch.assign(map_->size(), 0);
  for (std::size_t j = 0; j < map_->size(); ++j) {
    if (report.pins.find(map_->letter(j)) == std::string::npos) continue;
    const ControllerAxis& axis = map_->axis(j);
    const bool upper =
        lastDirection_[j] != 0.0 ? lastDirection_[j] > 0.0 : position[j] > 0.5 * (axis.lower + axis.upper);
    state_.limitSwitch[j] = upper ? 1 : -1;
  }
  const bool closed = report.pins.find('P') != std::string::npos;
  if (closed != state_.probeClosed && task_ != Task::kProbing) {
    ProbeEdge edge;
    edge.time = state_.time;
    edge.timeUncertainty = reportPeriod_ + state_.timeUncertainty;
    edge.closed = closed;
    edge.motion = state_.motion;
    edges_.push_back(edge);
  }
  state_.probeClosed = closed;
  if (report.feedOverride > 0) state_.feedOverride = 0.01 * report.feedOverride;
  state_.held = report.state == "Hold" && report.substate <= 0;
  if (report.state == "Alarm") {
    if (!state_.alarm.present()) {
      if (report.substate > 0) {
        takeAlarm(report.substate);
      } else if (task_ != Task::kHoming) {
        state_.alarm = {0, "the control is locked", "home, or call ~clear_alarm"};
      }
    }
  } else if (!clearing_ && report.state == "Idle") {
    if (state_.alarm.present() && task_ == Task::kNone) state_.alarm = {};  // cleared at its panel
  }
  if (report.state == "Idle") clearing_ = false;

  if (stopAsked_ && !resetAsked_) {
    if (report.state == "Hold" && report.substate <= 0) endStop();
    if ((report.state == "Idle" || report.state == "Alarm") && sent > stopSent_) {
      stopAsked_ = false;
      finish(Outcome::kStopped);
    }
    return;
  }
  if (report.state == "Run" || report.state == "Jog") begun_ = true;
  // A motion has ended when its line was answered and a report that was asked for later says Idle.
  const bool rests = report.state == "Idle" && sent > taskBegan_;
  if (task_ == Task::kJog && answered_ && rests && (begun_ || sent - taskBegan_ > 0.2))
    finish(Outcome::kReached);
  if (task_ == Task::kHoming && answered_ && rests) {
    for (const std::size_t j : homing_) homed_[j] = true;
    state_.alarm = {};
    finish(Outcome::kReached);
  }
  if (task_ == Task::kPlain && answered_ && rests) finish(Outcome::kReached);
  if ((task_ == Task::kGuarded || task_ == Task::kProbing) && answered_ && rests)
    finish(tripped_.value_or(false) ? Outcome::kTripped : Outcome::kReached);
}

// Commanded positions at the trip; when it was follows from the way to rest that came after it.
void GrblController::takeProbe(const GrblProbe& probe, double time) {
  damaged_ = 0;
  if (task_ != Task::kProbing && task_ != Task::kGuarded) return;
  tripped_ = probe.tripped;
  if (!probe.tripped || probe.machine.size() < map_->needed()) return;
  ProbeEdge edge;
  const double rest = deceleration();
  edge.time = std::max(taskBegan_, time - rest - 0.5 * roundTrip_);
  edge.timeUncertainty = rest + roundTrip_ + 5e-3;
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
  damaged_ = 0;
  if (inFlight_.empty()) return;  // the answer to the empty line, or to one from before a reset
  inFlight_.pop_front();
  pump();
  const bool last = inFlight_.empty() && waiting_.empty();
  if (code != 0 && task_ != Task::kNone) {
    const GrblWords words = grblError(code);
    const std::string text = "the control refused it, error " + std::to_string(code) + ": " + words.text +
                             (words.remedy.empty() ? "" : "; " + words.remedy);
    finish(code == 15 ? Outcome::kLimit : Outcome::kAlarm, text);
    return;
  }
  if (!last || task_ == Task::kNone) return;
  answered_ = true;
  taskBegan_ =
      task_ == Task::kHoming ? steadySeconds() : taskBegan_;  // a report from now on has the new zero
  asked_ = task_ == Task::kHoming ? 0.0 : asked_;
}

void GrblController::takeAlarm(int code) {
  damaged_ = 0;
  const GrblWords words = grblAlarm(code);
  state_.alarm = {code, words.text, words.remedy};
  if (!grblAlarmKeepsPosition(code)) homed_.assign(map_->size(), false);
  if (emergency_) state_.alarm = {};
  forgetLines();
  finish(emergency_ || stopAsked_ ? Outcome::kStopped
         : code == 1 || code == 2 ? Outcome::kLimit
                                  : Outcome::kAlarm);
}

// The control began anew: because it was told to, or because it lost its power.
void GrblController::takeWelcome() {
  damaged_ = 0;
  forgetLines();
  asked_ = 0.0;
  if (resetAsked_ || emergency_) {
    resetAsked_ = false;
    if (emergency_) homed_.assign(map_->size(), false);
    stopAsked_ = false;
    finish(Outcome::kStopped);  // what was asked for meanwhile went with the reset, too
    if (clearing_) send("$X");
    return;
  }
  if (lastReport_ == 0.0) return;  // the answer to opening the line
  ++state_.resets;
  homed_.assign(map_->size(), false);
  finish(Outcome::kLost);
}

void GrblController::finish(Outcome outcome, const std::string& note) {
  if (task_ != Task::kNone && state_.outcome == Outcome::kUnderWay) {
    state_.outcome = outcome;
    state_.note = note;
  }
  task_ = Task::kNone;
  homes_ = false;
  homing_.clear();
}

// At rest in feed hold: what is left of the motion is thrown away by a soft reset, which keeps the position.
void GrblController::endStop() {
  resetAsked_ = true;
  resetAt_ = steadySeconds();
  link_->write(std::string(1, kSoftReset));
}

// ---- being asked ------------------------------------------------------------------------------------------

AxesState GrblController::poll(double) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now = steadySeconds();
  if (!link_->connected()) throw Error(link_->lost().empty() ? "not connected" : link_->lost());
  if (!away_.empty()) throw Error(away_);
  if (!trouble_.empty()) throw Error(link_->address() + ": " + trouble_);
  if (asked_ == 0.0 ? now - lastAsked_ >= reportPeriod_ : now - lastAsked_ > kAgain) ask();
  const bool quiet = task_ == Task::kHoming;  // grbl 1.1 does not report while it homes
  if (quiet && now - taskBegan_ > homingTimeout_) {
    finish(Outcome::kAlarm, "homing has not ended within its time");
  } else if (!quiet && now - std::max({lastReport_, connected_, resetAt_.load()}) > kLinkSilence) {
    char text[120];
    std::snprintf(text, sizeof text, ": no status report for %.1f s; look at its power and its cable",
                  now - std::max(lastReport_, connected_));
    throw Error(link_->address() + text);
  }
  if (resetAsked_ && now - resetAt_ > kUnwelcome)
    throw Error(link_->address() + ": the control did not answer its reset; look at its power and its cable");
  if (quiet || now - resetAt_ < kLinkSilence) state_.time = std::max(state_.time, now);
  AxesState state = state_;
  state.moving = task_ != Task::kNone || stopAsked_;
  state.axisHomed = homed_;
  state.homed = std::all_of(homed_.begin(), homed_.end(), [](bool homed) { return homed; });
  state.emergencyStop = emergency_;
  if (state.held && !state.moving) state.held = false;
  return state;
}

// ---- being told -------------------------------------------------------------------------------------------

/// The words of a motion, in work coordinates: G38 knows no others. The feed is that of
/// the vector of all axes, mm and deg alike, as grbl counts it.
std::string GrblController::block(const std::vector<double>& target, const std::vector<double>& from,
                                  double seconds) const {
  std::string words;
  double square = 0.0;
  for (std::size_t j = 0; j < map_->size(); ++j) {
    const std::size_t place = map_->place(j);
    const double to = map_->toControl(j, target[j]), way = to - map_->toControl(j, from[j]);
    if (std::abs(way) < 5e-4) continue;
    square += way * way;
    const double shift = place < offset_.size() ? offset_[place] : 0.0;
    char word[48];
    std::snprintf(word, sizeof word, " %c%.4f", map_->letter(j), to - shift);
    words += word;
  }
  if (words.empty()) return {};
  char feed[48];
  std::snprintf(feed, sizeof feed, " F%.3f", 60.0 * std::sqrt(square) / seconds);
  return words + feed;
}

void GrblController::move(const AxesMotion& motion) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (emergency_) throw Error("emergency stop; reset it, then home again");
  if (state_.alarm.present()) throw Error(state_.alarm.text + "; " + state_.alarm.remedy);
  double seconds = 0.0;
  for (std::size_t j = 0; j < map_->size(); ++j)
    if (motion.speed[j] > 0.0)
      seconds = std::max(seconds, std::abs(motion.target[j] - state_.position[j]) / motion.speed[j]);
  motion_ = motion;
  stopAsked_ = false;
  state_.motion = motion.id;
  state_.outcome = Outcome::kUnderWay;
  state_.note.clear();
  answered_ = begun_ = false;
  tripped_.reset();
  taskBegan_ = steadySeconds();
  task_ = motion.probing ? Task::kProbing : guard_ && !motion.leaving ? Task::kGuarded : Task::kPlain;
  const std::string words = seconds > 0.0 ? block(motion.target, state_.position, seconds) : "";
  if (words.empty()) return finish(Outcome::kReached);  // it is there
  for (std::size_t j = 0; j < map_->size(); ++j)
    if (motion.speed[j] > 0.0) lastDirection_[j] = motion.target[j] - state_.position[j];
  send((task_ == Task::kPlain ? "G21 G90 G94 G1" : "G21 G90 G94 G38.3") + words);
  if (task_ == Task::kPlain) send("G4 P0.01");  // is answered when the axes have come to rest
}

void GrblController::home(const std::vector<std::size_t>& axes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (emergency_) throw Error("emergency stop; reset it, then home again");
  task_ = Task::kHoming;
  homes_ = true;
  homing_ = axes;
  stopAsked_ = false;
  state_.outcome = Outcome::kUnderWay;
  answered_ = false;
  taskBegan_ = steadySeconds();
  for (const std::size_t j : axes) homed_[j] = false;
  if (axes.size() == map_->size()) return send("$H");
  for (const std::size_t j : axes) send(std::string("$H") + map_->letter(j));
}

void GrblController::clearAlarm() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (emergency_) throw Error("emergency stop; reset it");
  const bool locked = state_.alarm.code == 1 || state_.alarm.code == 2;  // these wait for a reset
  state_.alarm = {};
  clearing_ = true;
  if (!locked) return send("$X");
  endStop();
}

void GrblController::moveOffLimit() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string words;
  for (std::size_t j = 0; j < map_->size(); ++j) {
    if (state_.limitSwitch[j] == 0) continue;
    char word[48];
    std::snprintf(word, sizeof word, " %c%.4f", map_->letter(j),
                  -state_.limitSwitch[j] * map_->sign(j) * offLimit_);
    words += word;
  }
  if (words.empty()) throw Error("no axis stands on a limit switch");
  task_ = Task::kJog;
  answered_ = begun_ = false;
  state_.outcome = Outcome::kUnderWay;
  taskBegan_ = steadySeconds();
  send("$J=G91 G21" + words + " F100");
}

void GrblController::resetEmergencyStop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  emergency_ = false;
  homed_.assign(map_->size(), false);
  if (report_.state == "Alarm") send("$X");  // homing makes the zero again
}

std::vector<ProbeEdge> GrblController::takeProbeEdges() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<ProbeEdge> edges;
  edges.swap(edges_);
  return edges;
}

// These take no lock but that of writing a byte. A feed hold does not end homing, a reset does.
void GrblController::stop() {
  stopAsked_ = true;
  stopSent_ = steadySeconds();
  if (homes_) return endStop();
  link_->write("!");
}

void GrblController::emergencyStop() {
  emergency_ = true;
  link_->write(std::string(1, kSoftReset));
}

void GrblController::feedHold(bool hold) { link_->write(hold ? "!" : "~"); }

void GrblController::setOverride(double share) { link_->write(grblOverride(share)); }

}  // namespace mm
