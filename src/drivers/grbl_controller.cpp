#include "drivers/grbl_controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/format.h"

namespace mm {
namespace {

constexpr double kNoWay = 5e-4;    // mm or deg: half of the last digit that is sent
constexpr double kAgain = 0.3;     // s until a question is asked once more
constexpr double kNoAnswer = 0.5;  // s until a question counts as one that was answered together with another
constexpr double kUnwelcome = 1.5;  // s for the greeting after a soft reset

}  // namespace

GrblController::~GrblController() { close(); }

void GrblController::open(const ControllerSetup& setup) {
  refuseUnknownParametersOf(setup, "grbl",
                            {"address", "axes", "sign", "zero", "report_rate", "guard", "connect_timeout",
                             "homing_timeout", "off_limit_mm", "silence", "dead_man", "helper"});
  map_ = std::make_unique<AxisMap>(setup, kControlLetters);
  reportPeriod_ = 1.0 / numberParameterOf(setup, "report_rate", 20.0, 1.0, 200.0);
  connectTimeout_ = numberParameterOf(setup, "connect_timeout", connectTimeout_, 0.1, 60.0);
  homingTimeout_ = numberParameterOf(setup, "homing_timeout", homingTimeout_, 1.0, 3600.0);
  silence_ = numberParameterOf(setup, "silence", silence_, 0.1, 60.0);
  offLimit_ = numberParameterOf(setup, "off_limit_mm", offLimit_, 0.01, 100.0);
  const std::string guard = textParameterOf(setup, "guard", "true");
  if (guard != "true" && guard != "false")
    throw InputError("parameter 'guard' of the grbl controller is '" + guard + "'; true or false");
  guard_ = guard == "true";
  const std::string address = textParameterOf(setup, "address", "");
  if (address.empty())
    throw InputError(
        "parameter 'address' of the grbl controller is missing: tcp:<host>:<port> or "
        "serial:<device>[:<baud>]");
  homed_.assign(map_->size(), false);
  lastDirection_.assign(map_->size(), 0.0);
  link_ = std::make_unique<DeviceLink>(address,
                                       [this](const std::string& line, double time) { take(line, time); });
  guardian_ = std::make_unique<DeviceLink>(
      "line_guard",
      std::vector<std::string>{textParameterOf(setup, "helper", programBeside("line_guard")), "--silence",
                               std::to_string(numberParameterOf(setup, "dead_man", 0.5, 0.2, 60.0))},
      [this](const std::string&, double) {  // it has stopped what moved; what is left of that is given up
        if (task_ != Task::kNone) stop();
      });
  begin();
}

void GrblController::begin() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    forgetLines();
    questions_.clear();
    lastAsked_ = lastReport_ = 0.0;
    away_.clear();
    trouble_.clear();
    damaged_ = 0;
    offset_.clear();
    report_ = {};
    resetAsked_ = locked_ = clearing_ = false;
    state_.alarm = {};  // it says so again
    lastDirection_.assign(map_->size(), 0.0);
  }
  link_->connect(connectTimeout_);
  guardian_->connect(connectTimeout_, link_->descriptor());
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
  const double end = steadySeconds() + seconds, mute = end - 0.5 * seconds;
  bool settingsAsked = false, woken = false;
  for (double next = 0.0; steadySeconds() < end;) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const bool reported = lastReport_ > 0.0;
      const bool ready = report_.state == "Idle" || report_.state == "Alarm" || report_.state == "Door";
      const bool busy = !ready && !report_.state.empty();
      // It moves for somebody who has gone; or waits for a reset after a limit, or homes, and says nothing.
      const bool wake = !reported && !woken && steadySeconds() > mute;
      if (!resetAsked_ && ((reported && busy) || wake)) {
        endStop();
        settingsAsked = false;  // what was asked goes with the reset
      }
      woken = woken || wake;
      if (reported && ready && !resetAsked_ && !settingsAsked) {
        settings_.clear();
        send("$$");
        send("$I");
        settingsAsked = true;
      }
      if (reported && settingsAsked && settings_.count(110) > 0 && !offset_.empty() && inFlight_.empty()) {
        if (report_.machine.size() < map_->needed())
          throw InputError(link_->address() + ": the control reports " +
                           std::to_string(report_.machine.size()) + " axes, " +
                           std::to_string(map_->needed()) + " are needed; is it built for that many?");
        if (std::abs(setting(13)) > 0.0)
          throw InputError(link_->address() +
                           ": the control reports in inches ($13=1), mm are needed; set $13=0");
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
  if (lastReport_ > 0.0) why = "it reports '" + report_.state + "', but does not report its settings ($$)";
  if (lastReport_ > 0.0 && settings_.count(110) > 0) why = "its status reports contain no WCO";
  if (!trouble_.empty()) why = trouble_;
  throw Error(link_->address() + " does not answer as grbl 1.1 or grblHAL: " + why +
              "; check its power supply, the address and the baud rate");
}

void GrblController::reconnect() {
  guardian_->close();
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
  if (!guardian_) return;
  try {
    if (link_->connected()) link_->write("!");
  } catch (const std::exception&) {
    // Gone already.
  }
  guardian_->close();
  link_->close();
}

// What stops the axes where nobody else does. Homing hears no feed hold.
void GrblController::beat() {
  beatAt_ = steadySeconds();
  const bool moves = task_ != Task::kNone || stopAsked_ || report_.moves();
  guardian_->write(std::string(1, task_ == Task::kHoming ? kGrblSoftReset : moves ? '!' : '\0'));
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
  if (!questions_.empty() && now - lastAsked_ < kAgain) return;
  link_->write("?");
  lastAsked_ = now;
  questions_.push_back(now);
}

// Two questions that the control reads together have one answer. What is left open of them must not be taken
// for the next one's: after an answer nothing is asked until the rest has come, or cannot come any more.
bool GrblController::askNow(double now) const {
  if (questions_.empty()) return now - lastAsked_ >= reportPeriod_;
  return now - lastAsked_ > (lastReport_ > questions_.front() ? kNoAnswer : kAgain);
}

// When that was asked for which came at `time`: not later than it was asked, so that no report from before an
// order is taken for one from after it.
double GrblController::questionOf(double time) {
  if (questions_.empty()) return std::min(lastAsked_, time);  // of its own accord
  const double sent = questions_.front();
  questions_.pop_front();
  return sent;
}

void GrblController::forgetLines() {
  waiting_.clear();
  inFlight_.clear();
}

// ---- being asked ------------------------------------------------------------------------------------------

AxesState GrblController::poll(double) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now = steadySeconds();
  for (const DeviceLink* link : {link_.get(), guardian_.get()})
    if (!link->connected()) throw Error(link->lost().empty() ? "not connected" : link->lost());
  if (now - beatAt_ > kLinkBeat) beat();
  if (!away_.empty()) throw Error(away_);
  if (!trouble_.empty()) throw Error(link_->address() + ": " + trouble_);
  if (askNow(now)) {
    if (now - lastAsked_ > kNoAnswer) questions_.clear();
    ask();
  }
  if (locked_ && stopAsked_ && !resetAsked_) stopAsked_ = false;  // nothing moves in that alarm
  const bool homes = task_ == Task::kHoming;                      // grbl 1.1 does not report meanwhile
  const bool quiet = homes || locked_;
  if (homes && now - taskBegan_ > homingTimeout_) {
    finish(Outcome::kAlarm, "homing did not finish in time");
    if (!resetAsked_) endStop();
  } else if (!quiet && now - std::max({lastReport_, connected_, resetAt_.load()}) > silence_) {
    throw Error(link_->address() +
                format(": no status report for %.1f s; check its power supply and its cable",
                       now - std::max(lastReport_, connected_)));
  }
  if (resetAsked_ && now - resetAt_ > kUnwelcome)
    throw Error(link_->address() + ": no response to a reset; check its power supply and its cable");
  // At rest after a reset nothing is reported for a while; what moves has the time of its reports.
  const bool beginsAnew = now - resetAt_ < silence_ && task_ == Task::kNone;
  if (quiet || beginsAnew) state_.time = std::max(state_.time, now);
  AxesState state = state_;
  state.moving = task_ != Task::kNone || stopAsked_ || report_.moves();  // also for another sender
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
    if (std::abs(way) < kNoWay) continue;
    square += way * way;
    const double shift = place < offset_.size() ? offset_[place] : 0.0;
    words += format(" %c%.4f", map_->letter(j), to - shift);
  }
  return words.empty() ? words : words + format(" F%.3f", 60.0 * std::sqrt(square) / seconds);
}

// The stop that is under way would end what is begun now, or be forgotten.
void GrblController::requireNoStop() const {
  if (emergency_) throw Error("emergency stop; reset it, then home again");
  if (stopAsked_ || resetAsked_) throw Error("a stop is under way; wait until the axes rest");
  if (locked_)
    throw Error("alarm " + std::to_string(state_.alarm.code) + ": " + state_.alarm.text +
                "; the control waits for a reset; call ~clear_alarm first");
}

void GrblController::start(Task task) {
  task_ = task;
  taskBegan_ = steadySeconds();
  answered_ = begun_ = tripped_ = false;
  homing_.clear();
  state_.outcome = Outcome::kUnderWay;
  state_.note.clear();
  beat();
}

void GrblController::move(const AxesMotion& motion) {
  const std::lock_guard<std::mutex> lock(mutex_);
  requireNoStop();
  if (state_.alarm.present()) throw Error(state_.alarm.text + "; " + state_.alarm.remedy);
  double seconds = 0.0;
  for (std::size_t j = 0; j < map_->size(); ++j)
    if (motion.speed[j] > 0.0)
      seconds = std::max(seconds, std::abs(motion.target[j] - state_.position[j]) / motion.speed[j]);
  motion_ = motion;
  state_.motion = motion.id;
  start(motion.probing ? Task::kProbing : guard_ && !motion.leaving ? Task::kGuarded : Task::kPlain);
  const std::string words = seconds > 0.0 ? block(motion.target, state_.position, seconds) : "";
  if (words.empty()) return finish(Outcome::kReached);  // it is there
  for (std::size_t j = 0; j < map_->size(); ++j)
    if (motion.speed[j] > 0.0) lastDirection_[j] = motion.target[j] - state_.position[j];
  send((task_ == Task::kPlain ? "G21 G90 G94 G1" : "G21 G90 G94 G38.3") + words);
  if (task_ == Task::kPlain) send("G4 P0.01");  // is answered when the axes have come to rest
}

void GrblController::home(const std::vector<std::size_t>& axes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  requireNoStop();
  start(Task::kHoming);
  homing_ = axes;
  for (const std::size_t j : axes) {
    homed_[j] = false;
    lastDirection_[j] = 0.0;
  }
  if (axes.size() == map_->size()) return send("$H");
  for (const std::size_t j : axes) send(std::string("$H") + map_->letter(j));
}

void GrblController::clearAlarm() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (emergency_) throw Error("emergency stop; reset it");
  clearing_ = true;  // until it is idle, or refuses
  if (!locked_) return send("$X");
  endStop();  // with which it listens again; its greeting is answered with $X
}

void GrblController::moveOffLimit() {
  const std::lock_guard<std::mutex> lock(mutex_);
  requireNoStop();
  std::string words;
  for (std::size_t j = 0; j < map_->size(); ++j) {
    if (state_.limitSwitch[j] == 0) continue;
    if (lastDirection_[j] == 0.0 && !homed_[j])
      throw Error("which of the two limit switches of " + map_->names()[j] +
                  " is closed is unknown: grbl reports both as one, and the axis has been neither homed nor "
                  "moved from here; move it off by hand, then home");
    words += format(" %c%.4f", map_->letter(j), -state_.limitSwitch[j] * map_->sign(j) * offLimit_);
  }
  if (words.empty()) throw Error("no axis stands on a limit switch");
  start(Task::kJog);
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
  return std::exchange(edges_, {});
}

// These take no lock but that of writing a byte. A feed hold does not end homing, a reset does.
void GrblController::stop() {
  if (task_ == Task::kHoming) {
    stopAsked_ = true;
    stopSent_ = steadySeconds();
    return endStop();
  }
  const std::lock_guard<std::mutex> lock(byteMutex_);
  stopAsked_ = true;
  stopSent_ = steadySeconds();
  link_->write("!");
}

void GrblController::emergencyStop() {
  emergency_ = true;
  const std::lock_guard<std::mutex> lock(byteMutex_);
  resetAt_ = steadySeconds();
  link_->write(std::string(1, kGrblSoftReset));
}

void GrblController::feedHold(bool hold) { link_->write(hold ? "!" : "~"); }

void GrblController::setOverride(double share) { link_->write(grblOverride(share)); }

}  // namespace mm
