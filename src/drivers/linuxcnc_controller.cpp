#include "drivers/linuxcnc_controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/format.h"

namespace mm {
namespace {

constexpr double kSmallest = 1e-6;                    // mm or deg, the last decimal of a target
constexpr const char* kModes = "mdi G21 G90 G94 G8";  // mm, absolute, per minute, radius
constexpr int kHere = 5420;          // the first of LinuxCNC's parameters of where it is, in work coordinates
constexpr double kStopAgain = 0.25;  // s until an emergency stop is said again
constexpr double kStopRefused = 1.5;  // s until that is hopeless

}  // namespace

LinuxCncController::~LinuxCncController() { close(); }

void LinuxCncController::open(const ControllerSetup& setup) {
  refuseUnknownParametersOf(setup, "linuxcnc",
                            {"axes", "sign", "zero", "coordinates", "poll_rate", "servo_period",
                             "connect_timeout", "homing_timeout", "silence", "dead_man", "helper"});
  map_ = std::make_unique<AxisMap>(setup, kControlLetters);
  period_ = 1.0 / numberParameterOf(setup, "poll_rate", 1.0 / period_, 1.0, 500.0);
  servoPeriod_ = numberParameterOf(setup, "servo_period", servoPeriod_, 1e-6, 0.1);
  connectTimeout_ = numberParameterOf(setup, "connect_timeout", connectTimeout_, 0.1, 60.0);
  silence_ = numberParameterOf(setup, "silence", silence_, 0.1, 60.0);
  deadMan_ = numberParameterOf(setup, "dead_man", deadMan_, 0.2, 60.0);
  homingTimeout_ = numberParameterOf(setup, "homing_timeout", homingTimeout_, 1.0, 3600.0);
  coordinates_ = textParameterOf(setup, "coordinates", coordinates_);
  for (std::size_t j = 0; j < map_->size(); ++j)
    if (coordinates_.find(map_->letter(j)) == std::string::npos)
      throw InputError("parameter 'coordinates' of the linuxcnc controller is '" + coordinates_ +
                       "'; it has no " + map_->letter(j) + ", which moves joint '" + map_->names()[j] + "'");
  state_.actual = true;
  const std::string helper = textParameterOf(setup, "helper", programBeside("linuxcnc_helper"));
  const auto link = [&](const char* role) {
    return std::make_unique<DeviceLink>(
        std::string("linuxcnc_helper ") + role,
        std::vector<std::string>{helper, role, "--period", std::to_string(period_), "--silence",
                                 std::to_string(deadMan_)},
        [this](const std::string& line, double) { take(line); });
  };
  watch_ = link("watch");
  act_ = link("act");
  begin();
}

void LinuxCncController::begin() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_.reset();
    resetting_ = false;
    trouble_.clear();
    taken_ = serial_ = 0;
    settledAt_ = steadySeconds();
    sent_ = 0;
    stopSaid_ = emergencySaid_ = emergencySince_ = 0.0;
  }
  watch_->connect(connectTimeout_);
  act_->connect(connectTimeout_);
  std::unique_lock<std::mutex> lock(mutex_);
  first_.wait_for(lock, std::chrono::duration<double>(connectTimeout_),
                  [&] { return last_ || !trouble_.empty() || !watch_->connected(); });
  if (!trouble_.empty()) throw Error(trouble_);
  if (!last_)
    throw Error(watch_->connected() ? "LinuxCNC reports no state; is its task running?"
                                    : "linuxcnc_helper has exited");
  requireFit(*last_);
  giveBack_ = holding_ || last_->override == 0.0;  // a hold that nobody is left to end
  holding_ = false;
}

// Positions come in the units of the machine, whatever those of the program are.
void LinuxCncController::requireFit(const LinuxCncState& first) const {
  for (std::size_t j = 0; j < map_->size(); ++j)
    if ((first.axes >> map_->place(j) & 1) == 0)
      throw InputError(std::string("LinuxCNC has no axis ") + map_->letter(j) + ", which moves joint '" +
                       map_->names()[j] + "': see COORDINATES in [TRAJ] of its .ini");
  if (std::abs(first.linear - 1.0) > 1e-9)
    throw InputError(
        "LinuxCNC's linear unit is not mm: set LINEAR_UNITS = mm in [TRAJ] of its .ini, and the settings "
        "that depend on it");
  if (std::abs(first.angular - 1.0) > 1e-9)
    throw InputError(
        "LinuxCNC's angular unit is not degrees: set ANGULAR_UNITS = degree in [TRAJ] of its .ini");
}

void LinuxCncController::reconnect() {
  watch_->close();
  act_->close();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    finish(Outcome::kLost, {});
  }
  begin();
}

// The helpers stop what moves for this driver, as at any end of it.
void LinuxCncController::close() {
  if (!act_) return;
  watch_->close();
  act_->close();
}

Capabilities LinuxCncController::capabilities() const {
  Capabilities can;
  can.feedHold = can.feedOverride = can.homingByAxis = can.guardsPositioning = can.positionSurvivesReset =
      true;
  can.axes.resize(map_->size());
  for (std::size_t j = 0; j < map_->size(); ++j) can.axes[j].resolution = kSmallest * map_->unit(j);
  return can;
}

std::size_t LinuxCncController::jointOf(std::size_t axis) const {
  return coordinates_.find(map_->letter(axis));
}

// ---- being asked ------------------------------------------------------------------------------------------

AxesState LinuxCncController::poll(double) {
  const double now = steadySeconds();
  const bool emergency = emergencySaid_ > 0.0;
  // It is said until LinuxCNC shows that it has come.
  if (emergency && now - emergencySaid_ > kStopAgain) urgent("estop", emergencySaid_);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!trouble_.empty()) throw Error(trouble_);
  for (const DeviceLink* link : {watch_.get(), act_.get()})
    if (!link->connected()) throw Error(link->lost().empty() ? "not connected" : link->lost());
  if (emergency && now - emergencySince_ > kStopRefused)
    throw Error("LinuxCNC does not enter its emergency stop; press the machine's emergency stop button");
  if (!last_) throw Error("LinuxCNC has given no state yet");
  if (now - last_->time > silence_)
    throw Error(format("LinuxCNC has reported no state for %.1f s; is it still running?", now - last_->time));
  if (now - beatAt_ > kLinkBeat) beat();
  AxesState state = state_;
  state.moving = task_ != Task::kNone || stopSaid_ > 0.0 || others_;
  return state;
}

std::vector<ProbeEdge> LinuxCncController::takeProbeEdges() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(edges_, {});
}

// ---- being told -------------------------------------------------------------------------------------------

void LinuxCncController::beat() {
  beatAt_ = steadySeconds();
  const std::string line = std::to_string(sent_) + (task_ == Task::kNone ? " beat 0\n" : " beat 1\n");
  watch_->write(line);
  act_->write(line);
}

void LinuxCncController::give(const std::vector<std::string>& commands) {
  for (const std::string& command : commands) act_->write(std::to_string(++sent_) + " " + command + "\n");
}

// To both, so that neither can block it. Takes no lock but those of the links.
void LinuxCncController::urgent(const char* word, std::atomic<double>& said) {
  said = steadySeconds();
  const std::string line = std::to_string(++sent_) + " " + word + "\n";
  std::string failed;
  int reached = 0;
  for (DeviceLink* link : {watch_.get(), act_.get()}) {
    try {
      link->write(line);
      ++reached;
    } catch (const std::exception& e) {
      failed = e.what();
    }
  }
  if (reached == 0) throw Error(failed);
}

void LinuxCncController::stop() { urgent("stop", stopSaid_); }

void LinuxCncController::emergencyStop() {
  if (emergencySaid_ == 0.0) emergencySince_ = steadySeconds();
  urgent("estop", emergencySaid_);
}

void LinuxCncController::beginTask(Task task) {
  if (!last_) throw Error("LinuxCNC has given no state yet");
  if (stopSaid_ > 0.0) throw Error("a stop is under way; wait until the axes rest");
  if (others_) throw Error("another client of LinuxCNC moves the axes; wait until they rest, or call ~stop");
  task_ = task;
  state_.outcome = Outcome::kUnderWay;
  state_.note.clear();
  error_.clear();
  tripSeen_ = 0.0;
  lapses_ = last_->lapses;
  openSeen_ = !state_.probeClosed;
  began_ = steadySeconds();
  beat();  // from here on the helpers end it where this process does not live
}

void LinuxCncController::move(const AxesMotion& motion) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!last_ || last_->emergency || !last_->on)
    throw Error("LinuxCNC's machine is off; reset the emergency stop");
  const std::vector<std::string> lines = motionLines(motion);
  beginTask(motion.probing ? Task::kProbing : Task::kGo);
  motion_ = motion;
  state_.motion = motion.id;
  goal_ = last_->commanded;
  for (std::size_t j = 0; j < map_->size(); ++j) goal_[map_->place(j)] = map_->toControl(j, motion.target[j]);
  if (lines.empty()) return finish(Outcome::kReached, {});
  if (giveBack_) giveOverride(share_);  // of a motion that is over
  give(lines);
}

// Empty where the axes are there already.
std::vector<std::string> LinuxCncController::motionLines(const AxesMotion& motion) const {
  double seconds = 0.0, linear = 0.0, turning = 0.0;
  std::vector<double> way(last_->commanded.size(), 0.0), to(way);
  for (std::size_t j = 0; j < map_->size(); ++j) {
    const std::size_t place = map_->place(j);
    to[place] = map_->toControl(j, motion.target[j]);
    // From where it was commanded to, as LinuxCNC counts, not from where it is shown.
    way[place] = to[place] - (motion.probing ? last_->commanded : last_->actual)[place];
    if (motion.speed[j] > 0.0)
      seconds = std::max(seconds, std::abs(motion.target[j] - state_.position[j]) / motion.speed[j]);
    if (std::abs(way[place]) < kSmallest) way[place] = 0.0;
    (map_->axis(j).rotary ? turning : linear) += way[place] * way[place];
  }
  if (linear + turning == 0.0 || !(seconds > 0.0)) return {};
  std::string line = motion.probing ? "mdi G38.3" + probingWords(way) : std::string(kModes) + " G53 G1";
  for (std::size_t place = 0; place < way.size() && !motion.probing; ++place)
    if (way[place] != 0.0) line += format(" %c%.6f", kControlLetters[place], to[place]);
  // The feed is that of the linear axes where one moves, else that of the rotary ones (LinuxCNC, G94).
  line += format(" F%.6f", 60.0 * std::sqrt(linear > 0.0 ? linear : turning) / seconds);
  if (!motion.probing) return {"mdi_mode", line};
  return {"mdi_mode", std::string(kModes) + " #<_mm_r>=#[5210+20*#5220]", line};
}

// G38 takes work coordinates only (G54 to G59.3 with their rotation about Z, G92, the tool). So LinuxCNC
// itself adds the way, turned by that rotation, to where it is in them (#5420 to #5425).
std::string LinuxCncController::probingWords(const std::vector<double>& way) const {
  std::string words;
  const auto add = [&](char letter, int at, double along, double across) {
    if ((along == 0.0 && across == 0.0) || coordinates_.find(letter) == std::string::npos) return;
    words += format(" %c[#%d%+.6f*COS[#<_mm_r>]%+.6f*SIN[#<_mm_r>]]", letter, at, along, across);
  };
  add('X', kHere, way[0], way[1]);
  add('Y', kHere + 1, way[1], -way[0]);
  for (std::size_t place = 2; place < way.size(); ++place)
    if (way[place] != 0.0)
      words += format(" %c[#%d%+.6f]", kControlLetters[place], kHere + static_cast<int>(place), way[place]);
  return words;
}

// The flags fall first, so that they say when it has ended.
void LinuxCncController::home(const std::vector<std::size_t>& axes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!last_ || last_->emergency) throw Error("emergency stop; reset it, then home again");
  beginTask(Task::kHoming);
  homing_ = axes;
  std::vector<std::string> joints = {"-1"};
  if (axes.size() != map_->size()) {
    joints.clear();
    for (const std::size_t j : axes) joints.push_back(std::to_string(jointOf(j)));
  }
  give({"on", "joint_mode"});
  for (const char* word : {"unhome ", "home "})
    for (const std::string& joint : joints) give({word + joint});
}

void LinuxCncController::clearAlarm() {
  const std::lock_guard<std::mutex> lock(mutex_);
  give({"on"});
}

void LinuxCncController::resetEmergencyStop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  resetting_ = state_.emergencyStop = true;  // until a state after it says otherwise
  emergencySaid_ = 0.0;
  give({"estop_off", "on"});
}

// A motion that is asked for in a hold stays held: who held it may have meant that one.
void LinuxCncController::feedHold(bool hold) {
  const std::lock_guard<std::mutex> lock(mutex_);
  holding_ = hold;
  if (!hold) giveBack_ = owed_ = false;
  giveOverride(hold ? 0.0 : share_);
}

void LinuxCncController::setOverride(double share) {
  const std::lock_guard<std::mutex> lock(mutex_);
  share_ = share;
  if (holding_) return;  // with the end of the hold
  owed_ = last_ && last_->override == 0.0;
  if (!owed_) giveOverride(share);
}

void LinuxCncController::giveOverride(double share) { give({"override " + std::to_string(share)}); }

}  // namespace mm
