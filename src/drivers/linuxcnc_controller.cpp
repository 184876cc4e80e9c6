#include "drivers/linuxcnc_controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <thread>

#include "base/error.h"

namespace mm {
namespace {

constexpr double kSmallest = 1e-6;  // mm or deg, the last decimal of linuxcncrsh

constexpr const char* kModes = "G21 G90 G94 G8";  // mm, absolute, per minute, radius

constexpr int kHere = 5420;  // the first of LinuxCNC's parameters of where it is, in work coordinates

constexpr double kAnswer = 5e-3;  // s that a cycle waits for the answers to its questions

}  // namespace

LinuxCncController::LinuxCncController() = default;
LinuxCncController::~LinuxCncController() { close(); }

void LinuxCncController::open(const ControllerSetup& setup) {
  refuseUnknownParametersOf(
      setup, "linuxcnc",
      {"address", "axes", "sign", "zero", "coordinates", "connect_password", "enable_password", "poll_rate",
       "servo_period", "connect_timeout", "homing_timeout", "silence"});
  map_ = std::make_unique<AxisMap>(setup, kControlLetters);
  pollPeriod_ = 1.0 / numberParameterOf(setup, "poll_rate", 50.0, 1.0, 500.0);
  servoPeriod_ = numberParameterOf(setup, "servo_period", servoPeriod_, 1e-6, 0.1);
  connectTimeout_ = numberParameterOf(setup, "connect_timeout", connectTimeout_, 0.1, 60.0);
  silence_ = numberParameterOf(setup, "silence", silence_, 0.1, 60.0);
  homingTimeout_ = numberParameterOf(setup, "homing_timeout", homingTimeout_, 1.0, 3600.0);
  const auto text = [&](const char* name, std::string& value) {
    const auto found = setup.parameters.find(name);
    if (found != setup.parameters.end()) value = found->second;
  };
  std::string address = "tcp:127.0.0.1:5007", hello = "EMC", enable = "EMCTOO";
  text("address", address);
  text("coordinates", coordinates_);
  text("connect_password", hello);
  text("enable_password", enable);
  if (address.rfind("tcp:", 0) != 0)
    throw InputError("parameter 'address' of the linuxcnc controller is '" + address +
                     "'; linuxcncrsh listens on tcp:<host>:<port>");
  for (const std::string* word : {&hello, &enable})
    if (word->empty() || word->find_first_of(" \r\n") != std::string::npos)
      throw InputError("a password of the linuxcnc controller is empty or has a blank in it");
  for (std::size_t j = 0; j < map_->size(); ++j)
    if (coordinates_.find(map_->letter(j)) == std::string::npos)
      throw InputError("parameter 'coordinates' of the linuxcnc controller is '" + coordinates_ +
                       "'; it has no " + map_->letter(j) + ", which moves joint '" + map_->names()[j] + "'");
  state_.actual = true;
  LinuxCncTalk::Handlers handlers;
  handlers.answer = [this](const LinuxCncLine& line, double time) { take(line, time); };
  handlers.taken = [this](double time) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!talk_->commanding()) taken_ = time;  // not the commands of a task that began just now
  };
  handlers.refused = [this](const std::string& command) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (task_ == Task::kNone || stopAsked_ || failed_) return;  // what LinuxCNC itself says tells more
    failed_ = Outcome::kAlarm;
    note_ = "LinuxCNC refused it (" + command + ")";
  };
  handlers.stopRefused = [this](const std::string& command) {
    const std::lock_guard<std::mutex> lock(mutex_);
    refusedStop_ = command;
    refusedAt_ = steadySeconds();
  };
  handlers.damaged = [this] { damaged(); };
  talk_ = std::make_unique<LinuxCncTalk>(address, hello, enable, handlers);
  begin();
}

void LinuxCncController::begin() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    next_ = last_ = {};
    lastAsked_ = 0.0;
    resetting_ = false;
    trouble_.clear();
    refusedStop_.clear();
    damaged_ = 0;
  }
  talk_->connect(connectTimeout_);
  const double end = steadySeconds() + connectTimeout_;
  std::string why = "it gives no state";
  while (steadySeconds() < end) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (last_.came > 0.0) {
        if (last_.absolute.size() < map_->needed())
          throw InputError(talk_->address() + ": LinuxCNC reports " + std::to_string(last_.absolute.size()) +
                           " axes, " + std::to_string(map_->needed()) + " are needed");
        requireUnits();
        const std::lock_guard<std::mutex> feed(feedMutex_);
        giveBack_ = holding_ || last_.feedOverride == 0.0;  // a hold that nobody is left to end
        holding_ = false;
        return;
      }
      ask();
      if (!trouble_.empty()) why = trouble_;
    }
    if (why == trouble_) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  throw Error(talk_->address() + " does not answer as linuxcncrsh: " + why +
              "; is DISPLAY = linuxcncrsh in its .ini?");
}

// Positions come in the units of the machine, whatever those of the program are.
void LinuxCncController::requireUnits() const {
  if (last_.linearUnits != "MM")
    throw InputError(
        talk_->address() + ": LinuxCNC's machine counts in " + last_.linearUnits +
        ", the driver in MM: set LINEAR_UNITS = mm in [TRAJ] of its .ini, and what depends on it");
  if (last_.angularUnits != "DEG")
    throw InputError(talk_->address() + ": LinuxCNC's machine turns in " + last_.angularUnits +
                     ", the driver in DEG: set ANGULAR_UNITS = degree in [TRAJ] of its .ini");
}

void LinuxCncController::reconnect() {
  talk_->close();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    finish(Outcome::kLost);
  }
  begin();
}

void LinuxCncController::close() {
  if (!talk_) return;
  try {
    if (talk_->connected()) talk_->stop("abort");
  } catch (const std::exception&) {
    // Gone already.
  }
  talk_->close();
}

Capabilities LinuxCncController::capabilities() const {
  Capabilities can;
  can.feedHold = can.feedOverride = can.homingByAxis = can.guardsPositioning = can.positionSurvivesReset =
      true;
  can.notes.push_back("linuxcncrsh sends its passwords in clear text: only on a loopback or private network");
  for (std::size_t j = 0; j < map_->size(); ++j) {
    AxisCapability axis;
    axis.resolution = kSmallest * map_->unit(j);
    can.axes.push_back(axis);
  }
  return can;
}

std::size_t LinuxCncController::jointOf(std::size_t axis) const {
  return coordinates_.find(map_->letter(axis));
}

void LinuxCncController::damaged() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (++damaged_ >= kLinkDamaged) trouble_ = "what arrives is no language of linuxcncrsh";
}

void LinuxCncController::finish(Outcome outcome, const std::string& note) {
  if (task_ != Task::kNone && state_.outcome == Outcome::kUnderWay) {
    state_.outcome = outcome;
    state_.note = note;
  }
  task_ = Task::kNone;
  homing_.clear();
  state_.velocity.assign(map_->size(), 0.0);
  const std::lock_guard<std::mutex> feed(feedMutex_);
  giveBack_ = giveBack_ || holding_;
  holding_ = false;
}

// ---- being asked ------------------------------------------------------------------------------------------

AxesState LinuxCncController::poll(double) {
  std::unique_lock<std::mutex> lock(mutex_);
  const double now = steadySeconds();
  if (!talk_->connected()) throw Error(talk_->lost().empty() ? "not connected" : talk_->lost());
  if (!trouble_.empty()) throw Error(talk_->address() + ": " + trouble_);
  if (last_.came == 0.0) throw Error(talk_->address() + ": LinuxCNC has given no state yet");
  if (now - last_.came > silence_) {
    char text[120];
    std::snprintf(text, sizeof text, ": LinuxCNC has given no state for %.1f s; does it still run?",
                  now - last_.came);
    throw Error(talk_->address() + text);
  }
  talk_->goOn();
  if (now - lastAsked_ >= pollPeriod_) {
    ask();
    // An answer takes less than a millisecond: worth waiting for, above all after this process was held up.
    heard_.wait_for(lock, std::chrono::duration<double>(kAnswer), [&] { return next_.asked == 0.0; });
  }
  AxesState state = state_;
  state.moving = task_ != Task::kNone || stopAsked_ || others_;
  return state;
}

std::vector<ProbeEdge> LinuxCncController::takeProbeEdges() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<ProbeEdge> edges;
  edges.swap(edges_);
  return edges;
}

// ---- being told -------------------------------------------------------------------------------------------

void LinuxCncController::move(const AxesMotion& motion) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (last_.emergency || !last_.on) throw Error("LinuxCNC's machine is off; reset the emergency stop");
  const std::vector<std::string> lines = motionLines(motion);
  beginTask(motion.probing ? Task::kProbing : Task::kGo);
  motion_ = motion;
  state_.motion = motion.id;
  if (lines.empty()) return finish(Outcome::kReached);
  std::vector<std::string> commands;
  {
    const std::lock_guard<std::mutex> feed(feedMutex_);
    if (giveBack_) commands.push_back(overrideLine(false));  // of a motion that is over
  }
  if (!last_.mdi) commands.push_back("mode mdi");
  commands.insert(commands.end(), lines.begin(), lines.end());
  talk_->command(commands);
}

// Empty where the axes are there already.
std::vector<std::string> LinuxCncController::motionLines(const AxesMotion& motion) const {
  std::string words;
  double seconds = 0.0, linear = 0.0, turning = 0.0;
  std::vector<double> way(std::string(kControlLetters).size(), 0.0);
  for (std::size_t j = 0; j < map_->size(); ++j) {
    const std::size_t place = map_->place(j);
    const double to = map_->toControl(j, motion.target[j]);
    // From where it was commanded to, as LinuxCNC counts, not from where it is shown.
    way[place] = to - (motion.probing ? last_.commanded : last_.absolute)[place];
    if (motion.speed[j] > 0.0)
      seconds = std::max(seconds, std::abs(motion.target[j] - state_.position[j]) / motion.speed[j]);
    if (std::abs(way[place]) < kSmallest) way[place] = 0.0;
    if (way[place] == 0.0) continue;
    (map_->axis(j).rotary ? turning : linear) += way[place] * way[place];
    char word[48];
    std::snprintf(word, sizeof word, " %c%.6f", map_->letter(j), to);
    words += word;
  }
  if (words.empty() || !(seconds > 0.0)) return {};
  // The feed is that of the linear axes where one moves, else that of the rotary ones (LinuxCNC, G94).
  char feed[64], said[160];
  std::snprintf(feed, sizeof feed, " F%.6f", 60.0 * std::sqrt(linear > 0.0 ? linear : turning) / seconds);
  if (!motion.probing) return {std::string("mdi ") + kModes + " G53 G1" + words + feed};
  std::snprintf(said, sizeof said,
                "mdi (DEBUG,mm %llu #5070 #5061 #5062 #5063 #5064 #5065 #5066 #5420 #5421 #5422 #5423 #5424 "
                "#5425 #<_mm_r>)",
                static_cast<unsigned long long>(motion.id));
  return {std::string("mdi ") + kModes + " #<_mm_r>=#[5210+20*#5220]", "mdi G38.3" + probingWords(way) + feed,
          said};
}

// G38 takes work coordinates only, and what these are made of (G54 to G59.3 with their rotation about Z, G92,
// the tool) linuxcncrsh does not tell in full. So LinuxCNC itself adds the way, turned by that rotation, to
// where it is (#5420 to #5425); nothing of the user's is changed.
std::string LinuxCncController::probingWords(const std::vector<double>& way) const {
  std::string words;
  char word[96];
  if (way[0] != 0.0 || way[1] != 0.0) {
    const auto add = [&](char letter, int at, double along, double across) {
      if (coordinates_.find(letter) == std::string::npos) return;
      std::snprintf(word, sizeof word, " %c[#%d%+.6f*COS[#<_mm_r>]%+.6f*SIN[#<_mm_r>]]", letter, at, along,
                    across);
      words += word;
    };
    add('X', kHere, way[0], way[1]);
    add('Y', kHere + 1, way[1], -way[0]);
  }
  for (std::size_t place = 2; place < way.size(); ++place) {
    if (way[place] == 0.0) continue;
    std::snprintf(word, sizeof word, " %c[#%d%+.6f]", kControlLetters[place], kHere + static_cast<int>(place),
                  way[place]);
    words += word;
  }
  return words;
}

void LinuxCncController::beginTask(Task task) {
  if (stopAsked_) throw Error("a stop is under way; wait until the axes rest");
  if (others_) throw Error("another client of LinuxCNC moves the axes; wait until they rest, or call ~stop");
  task_ = task;
  state_.outcome = Outcome::kUnderWay;
  state_.note.clear();
  taken_ = tripSeen_ = homedSince_ = 0.0;
  fell_ = went_ = false;
  age_ = 0.0;
  openSeen_ = !state_.probeClosed;
  latched_.reset();
  failed_.reset();
  note_.clear();
  taskBegan_ = steadySeconds();
}

void LinuxCncController::home(const std::vector<std::size_t>& axes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (last_.emergency) throw Error("emergency stop; reset it, then home again");
  beginTask(Task::kHoming);
  homing_ = axes;
  std::vector<std::string> commands = {"machine on", "mode manual", "teleop_enable off"};
  if (axes.size() == map_->size())
    commands.push_back("home -1");
  else
    for (const std::size_t j : axes) commands.push_back("home " + std::to_string(jointOf(j)));
  talk_->command(commands);
}

void LinuxCncController::clearAlarm() { talk_->command({"machine on"}); }

void LinuxCncController::resetEmergencyStop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  resetting_ = state_.emergencyStop = true;  // until a round that was asked after it says otherwise
  taken_ = 0.0;
  talk_->command({"estop off", "machine on"});
}

// These take no lock but that of the conversation.
void LinuxCncController::stop() {
  stopAsked_ = true;
  stopSent_ = steadySeconds();
  talk_->stop("abort");
}

void LinuxCncController::emergencyStop() { talk_->emergencyStop("estop on"); }

// A motion that is asked for in a hold stays held: who held it may have meant that one.
void LinuxCncController::feedHold(bool hold) {
  const std::lock_guard<std::mutex> feed(feedMutex_);
  holding_ = hold;
  if (!hold) stands_ = giveBack_ = owed_ = false;
  talk_->command({overrideLine(hold)});
}

void LinuxCncController::setOverride(double share) {
  const std::lock_guard<std::mutex> feed(feedMutex_);
  share_ = share;
  if (holding_) return;  // with the end of the hold
  owed_ = stands_;
  if (!stands_) talk_->command({overrideLine(false)});
}

std::string LinuxCncController::overrideLine(bool hold) const {
  char text[64];
  std::snprintf(text, sizeof text, "feed_override %.0f", hold ? 0.0 : 100.0 * share_);
  return text;
}

}  // namespace mm
