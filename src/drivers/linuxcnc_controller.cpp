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

constexpr double kStill = 0.06;     // s without a change of position: at rest
constexpr double kUntaken = 5.0;    // s for a command to be taken
constexpr double kUnsaid = 1.0;     // s at rest after which nothing more is said of a motion
constexpr double kSmallest = 1e-6;  // mm or deg, the last decimal of linuxcncrsh
constexpr int kParts = 10;          // answers of a round that are needed
const char* const kQuestions =
    "get estop\r\nget machine\r\nget joint_homed\r\nget joint_limit\r\nget abs_act_pos\r\nget rel_act_pos\r\n"
    "get probe_value\r\nget mode\r\nget feed_override\r\nget error\r\nget operator_display\r\nget "
    "program_status\r\n";

}  // namespace

std::optional<LinuxCncLine> parseLinuxCncLine(const std::string& line) {
  for (const char c : line)
    if (static_cast<unsigned char>(c) < ' ' && c != '\t') return std::nullopt;
  const std::size_t first = line.find_first_not_of(' ');
  if (first == std::string::npos) return std::nullopt;
  const std::size_t blank = line.find(' ', first);
  LinuxCncLine parsed;
  parsed.word = line.substr(first, blank == std::string::npos ? std::string::npos : blank - first);
  const std::size_t rest = blank == std::string::npos ? blank : line.find_first_not_of(' ', blank);
  if (rest != std::string::npos) parsed.rest = line.substr(rest);
  return parsed;
}

std::vector<double> parseLinuxCncNumbers(const std::string& text) {
  std::vector<double> values;
  std::istringstream in(text);
  for (std::string word; in >> word;) {
    std::istringstream number(word);
    double value = 0.0;
    if (!(number >> value) || number.peek() != EOF || !std::isfinite(value)) return {};
    values.push_back(value);
  }
  return values;
}

LinuxCncController::LinuxCncController() = default;
LinuxCncController::~LinuxCncController() { close(); }

void LinuxCncController::open(const ControllerSetup& setup) {
  refuseUnknownParametersOf(
      setup, "linuxcnc",
      {"address", "axes", "sign", "zero", "coordinates", "connect_password", "enable_password", "poll_rate",
       "servo_period", "connect_timeout", "homing_timeout"});
  map_ = std::make_unique<AxisMap>(setup, kControlLetters);
  pollPeriod_ = 1.0 / numberParameterOf(setup, "poll_rate", 50.0, 1.0, 500.0);
  servoPeriod_ = numberParameterOf(setup, "servo_period", servoPeriod_, 1e-6, 0.1);
  connectTimeout_ = numberParameterOf(setup, "connect_timeout", connectTimeout_, 0.1, 60.0);
  homingTimeout_ = numberParameterOf(setup, "homing_timeout", homingTimeout_, 1.0, 3600.0);
  const auto text = [&](const char* name, std::string& value) {
    const auto found = setup.parameters.find(name);
    if (found != setup.parameters.end()) value = found->second;
  };
  std::string address = "tcp:127.0.0.1:5007";
  text("address", address);
  text("coordinates", coordinates_);
  text("connect_password", hello_);
  text("enable_password", enable_);
  if (address.rfind("tcp:", 0) != 0)
    throw InputError("parameter 'address' of the linuxcnc controller is '" + address +
                     "'; linuxcncrsh listens on tcp:<host>:<port>");
  for (const std::string* word : {&hello_, &enable_})
    if (word->empty() || word->find_first_of(" \r\n") != std::string::npos)
      throw InputError("a password of the linuxcnc controller is empty or has a blank in it");
  for (std::size_t j = 0; j < map_->size(); ++j)
    if (coordinates_.find(map_->letter(j)) == std::string::npos)
      throw InputError("parameter 'coordinates' of the linuxcnc controller is '" + coordinates_ +
                       "'; it has no " + map_->letter(j) + ", which moves joint '" + map_->names()[j] + "'");
  state_.actual = true;
  link_ = std::make_unique<DeviceLink>(address,
                                       [this](const std::string& line, double time) { take(line, time); });
  commandLink_ = std::make_unique<DeviceLink>(
      address, [this](const std::string& line, double time) { take(line, time); });
  stopLink_ = std::make_unique<DeviceLink>(address, [](const std::string&, double) {});
  begin();
}

void LinuxCncController::begin() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    next_ = last_ = {};
    welcomed_ = false;
    lastAsked_ = 0.0;
    unanswered_ = 0;
    resetting_ = false;
    trouble_.clear();
    damaged_ = 0;
  }
  for (DeviceLink* link : {link_.get(), commandLink_.get(), stopLink_.get()}) link->connect(connectTimeout_);
  const std::string hello = "hello " + hello_ + " measuring_machine 1.0\r\nset echo off\r\n";
  for (DeviceLink* link : {link_.get(), commandLink_.get(), stopLink_.get()}) link->write(hello);
  const double end = steadySeconds() + connectTimeout_;
  while (steadySeconds() < end) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (last_.came > 0.0) {
        if (last_.absolute.size() < map_->needed())
          throw InputError(link_->address() + ": LinuxCNC reports " + std::to_string(last_.absolute.size()) +
                           " axes, " + std::to_string(map_->needed()) + " are needed");
        return;
      }
      if (welcomed_ && next_.asked == 0.0)
        ask();  // one round at a time: answers do not say to which they belong
      if (!trouble_.empty()) break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string why = welcomed_ ? "it gives no state" : "it does not answer 'hello'";
  if (!trouble_.empty()) why = trouble_;
  throw Error(link_->address() + " does not answer as linuxcncrsh: " + why +
              "; is DISPLAY = linuxcncrsh in its .ini, and the password right?");
}

void LinuxCncController::reconnect() {
  for (DeviceLink* link : {link_.get(), commandLink_.get(), stopLink_.get()}) link->close();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    finish(Outcome::kLost);
  }
  begin();
}

void LinuxCncController::close() {
  if (!link_) return;
  try {
    if (stopLink_->connected()) urgent("set abort");
  } catch (const std::exception&) {
    // Gone already.
  }
  for (DeviceLink* link : {link_.get(), commandLink_.get(), stopLink_.get()}) link->close();
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

// ---- sending ----------------------------------------------------------------------------------------------

// Control belongs to the connection that took it last, so each command takes it again. The question behind
// the commands is answered when LinuxCNC has taken them; those of before are answered first.
void LinuxCncController::send(const std::string& commands) {
  ++unanswered_;
  commandLink_->write("set enable " + enable_ + "\r\n" + commands + "get echo\r\n");
}

void LinuxCncController::urgent(const std::string& command) {
  stopLink_->write("set enable " + enable_ + "\r\n" + command + "\r\n");
}

void LinuxCncController::ask() {
  next_ = {};
  next_.asked = lastAsked_ = steadySeconds();
  link_->write(kQuestions);
}

// ---- hearing ----------------------------------------------------------------------------------------------

void LinuxCncController::take(const std::string& line, double time) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto parsed = parseLinuxCncLine(line);
  try {
    if (parsed) return takePart(*parsed, time);
  } catch (const std::exception& e) {
    trouble_ = e.what();
    return;
  }
  if (++damaged_ >= kLinkDamaged) trouble_ = "what arrives is no language of linuxcncrsh";
}

void LinuxCncController::takePart(const LinuxCncLine& line, double time) {
  const std::string &word = line.word, &rest = line.rest;
  const auto part = [&] {
    damaged_ = 0;
    ++next_.parts;
  };
  if (word == "HELLO") {
    if (rest.rfind("ACK", 0) == 0)
      welcomed_ = true;
    else
      trouble_ = "it refuses the password";
  } else if (word == "ESTOP") {
    next_.emergency = rest == "ON";
    part();
  } else if (word == "MACHINE") {
    next_.on = rest == "ON";
    part();
  } else if (word == "JOINT_HOMED") {
    std::istringstream in(rest);
    for (std::string one; in >> one;) next_.homed.push_back(one == "YES");
    part();
  } else if (word == "JOINT_LIMIT") {
    // OK, MINSOFT, MINHARD, MAXSOFT, MAXHARD
    std::istringstream in(rest);
    for (std::string one; in >> one;)
      next_.limits.push_back(one.rfind("MIN", 0) == 0 ? -1 : one.rfind("MAX", 0) == 0 ? 1 : 0);
    part();
  } else if (word == "ABS_ACT_POS") {
    next_.absolute = parseLinuxCncNumbers(rest);
    if (!next_.absolute.empty()) part();
  } else if (word == "REL_ACT_POS") {
    next_.relative = parseLinuxCncNumbers(rest);
    if (!next_.relative.empty()) part();
  } else if (word == "MODE") {
    next_.mdi = rest == "MDI";
    part();
  } else if (word == "ECHO") {
    damaged_ = 0;
    if (unanswered_ > 0 && --unanswered_ == 0) taken_ = steadySeconds();
  } else if (word == "PROBE_VALUE") {
    next_.probe = rest != "0";
    part();
  } else if (word == "FEED_OVERRIDE") {
    const std::vector<double> percent = parseLinuxCncNumbers(rest);
    if (percent.size() == 1) next_.feedOverride = 0.01 * percent[0], part();
  } else if (word == "ERROR") {
    damaged_ = 0;
    if (rest != "OK") takeError(rest);
  } else if (word == "OPERATOR_DISPLAY") {
    damaged_ = 0;
    if (rest != "OK") takeMessage(rest);
  } else if (word == "PROGRAM_STATUS") {
    next_.idle = rest == "IDLE";
    part();
    next_.came = time;
    if (next_.parts == kParts && next_.asked > 0.0) takeSnapshot();
  } else if (word == "SET" && rest.find("NAK") != std::string::npos) {
    damaged_ = 0;
    if (task_ != Task::kNone && unanswered_ == 1 && !stopAsked_ && rest.rfind("ENABLE", 0) != 0) {
      failed_ = Outcome::kAlarm;
      note_ = "LinuxCNC refused it (" + rest + ")";
    }
  } else if (word == "set" || word == "get" || word == "hello") {
    damaged_ = 0;  // an echo
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
  const bool limit = text.find("limit") != std::string::npos;
  failed_ = tripped ? Outcome::kTripped : limit ? Outcome::kLimit : Outcome::kAlarm;
  note_ = tripped ? "" : "LinuxCNC: " + text;
}

void LinuxCncController::takeSnapshot() {
  const Snapshot now = next_;
  if (now.absolute.size() < map_->needed() || now.relative.size() != now.absolute.size()) return;
  const double at = 0.5 * (now.asked + now.came), gone = at - state_.time;
  const std::size_t axes = map_->size();
  std::vector<double> position(axes), velocity(axes, 0.0);
  bool changed = last_.absolute.size() != now.absolute.size();
  for (std::size_t j = 0; j < axes; ++j) {
    const std::size_t place = map_->place(j);
    position[j] = map_->toJoint(j, now.absolute[place]);
    changed = changed || std::abs(now.absolute[place] - last_.absolute[place]) > 2.0 * kSmallest;
    if ((task_ != Task::kNone || stopAsked_) && gone > 0.0 && state_.position.size() == axes)
      velocity[j] = (position[j] - state_.position[j]) / gone;
  }
  if (changed || still_ == 0.0) still_ = now.came;
  state_.time = std::max(state_.time, at);
  state_.timeUncertainty = 0.5 * (now.came - now.asked);
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
  if (unanswered_ == 0 && now.asked > taken_) resetting_ = false;
  state_.emergencyStop = now.emergency || resetting_;
  state_.feedOverride = now.feedOverride;
  state_.held = task_ != Task::kNone && now.feedOverride == 0.0 && now.came - still_ >= kStill;
  state_.alarm = {};
  if (!now.emergency && !now.on)
    state_.alarm = {0, "LinuxCNC's machine is off", "call ~clear_alarm to switch it on"};
  if (now.probe != state_.probeClosed) {
    if (now.probe && task_ == Task::kProbing) {
      tripSeen_ = at;
    } else {
      ProbeEdge edge;
      edge.time = state_.time;
      edge.timeUncertainty = pollPeriod_ + state_.timeUncertainty;
      edge.closed = now.probe;
      edge.motion = state_.motion;
      edges_.push_back(edge);
    }
  }
  state_.probeClosed = now.probe;
  last_ = now;
  next_ = {};

  const bool rests = now.came - still_ >= kStill;
  if (stopAsked_ && last_.asked > stopSent_ && rests) {
    stopAsked_ = false;
    finish(Outcome::kStopped);
  }
  if (task_ == Task::kNone || last_.asked <= taskBegan_) return;
  const bool taken = taken_ > 0.0 && last_.asked > taken_;
  if (now.emergency || (!last_.on && (taken || task_ != Task::kHoming)))  // homing switches it on
    return finish(Outcome::kStopped, "LinuxCNC was switched off");
  if (!rests || state_.held) return;
  if (failed_) return finish(*failed_, note_);
  if (!taken) {
    if (last_.asked - taskBegan_ <= kUntaken) return;
    trouble_ = "LinuxCNC does not take commands";  // nor would the next: the connections are made anew
    return finish(Outcome::kLost, trouble_);
  }
  if (task_ == Task::kHoming) {
    bool homed = true;
    for (const std::size_t j : homing_) homed = homed && state_.axisHomed[j];
    if (homed && last_.asked - taken_ > kStill) return finish(Outcome::kReached);
    if (last_.asked - taskBegan_ > homingTimeout_)
      finish(Outcome::kAlarm, "homing has not ended within its time");
    return;
  }
  if (!last_.idle) return;
  if (task_ == Task::kGo) return finish(Outcome::kReached);
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
    for (std::size_t j = 0; j < axes; ++j) {
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

void LinuxCncController::finish(Outcome outcome, const std::string& note) {
  if (task_ != Task::kNone && state_.outcome == Outcome::kUnderWay) {
    state_.outcome = outcome;
    state_.note = note;
  }
  task_ = Task::kNone;
  homing_.clear();
  state_.velocity.assign(map_->size(), 0.0);
}

// ---- being asked ------------------------------------------------------------------------------------------

AxesState LinuxCncController::poll(double) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now = steadySeconds();
  for (const DeviceLink* link : {link_.get(), commandLink_.get(), stopLink_.get()})
    if (!link->connected()) throw Error(link->lost().empty() ? "not connected" : link->lost());
  if (!trouble_.empty()) throw Error(link_->address() + ": " + trouble_);
  if (last_.came == 0.0) throw Error(link_->address() + ": LinuxCNC has given no state yet");
  if (now - last_.came > kLinkSilence) {
    char text[120];
    std::snprintf(text, sizeof text, ": LinuxCNC has given no state for %.1f s; does it still run?",
                  now - last_.came);
    throw Error(link_->address() + text);
  }
  if (next_.asked == 0.0 && now - lastAsked_ >= pollPeriod_) ask();
  AxesState state = state_;
  state.moving = task_ != Task::kNone || stopAsked_;
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
  std::string words;
  double seconds = 0.0, linear = 0.0, turning = 0.0;
  for (std::size_t j = 0; j < map_->size(); ++j) {
    const std::size_t place = map_->place(j);
    const double to = map_->toControl(j, motion.target[j]), way = to - last_.absolute[place];
    if (motion.speed[j] > 0.0)
      seconds = std::max(seconds, std::abs(motion.target[j] - state_.position[j]) / motion.speed[j]);
    if (std::abs(way) < kSmallest) continue;
    (map_->axis(j).rotary ? turning : linear) += way * way;
    const double offset = motion.probing ? last_.absolute[place] - last_.relative[place] : 0.0;
    char word[48];
    std::snprintf(word, sizeof word, " %c%.6f", map_->letter(j), to - offset);
    words += word;
  }
  motion_ = motion;
  task_ = motion.probing ? Task::kProbing : Task::kGo;
  state_.motion = motion.id;
  state_.outcome = Outcome::kUnderWay;
  state_.note.clear();
  stopAsked_ = false;
  taken_ = 0.0;
  latched_.reset();
  failed_.reset();
  note_.clear();
  taskBegan_ = steadySeconds();
  tripSeen_ = 0.0;
  if (words.empty() || !(seconds > 0.0)) return finish(Outcome::kReached);
  // The feed is that of the linear axes where one moves, else that of the rotary ones (LinuxCNC, G94).
  char feed[64], said[64];
  std::snprintf(feed, sizeof feed, " F%.6f", 60.0 * std::sqrt(linear > 0.0 ? linear : turning) / seconds);
  const auto id = static_cast<unsigned long long>(motion.id);
  std::string commands = last_.mdi ? "" : "set mode mdi\r\n";
  commands +=
      std::string("set mdi G21 G90 G94 ") + (motion.probing ? "G38.3" : "G53 G1") + words + feed + "\r\n";
  std::snprintf(said, sizeof said, "(DEBUG,mm %llu #5070 #5061 #5062 #5063", id);
  if (motion.probing) commands += std::string("set mdi ") + said + " #5064 #5065 #5066)\r\n";
  send(commands);
}

void LinuxCncController::home(const std::vector<std::size_t>& axes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (last_.emergency) throw Error("emergency stop; reset it, then home again");
  task_ = Task::kHoming;
  homing_ = axes;
  state_.outcome = Outcome::kUnderWay;
  stopAsked_ = false;
  taken_ = 0.0;
  failed_.reset();
  note_.clear();
  taskBegan_ = steadySeconds();
  std::string commands = "set machine on\r\nset mode manual\r\nset teleop_enable off\r\n";
  if (axes.size() == map_->size())
    commands += "set home -1\r\n";
  else
    for (const std::size_t j : axes) commands += "set home " + std::to_string(jointOf(j)) + "\r\n";
  send(commands);
}

void LinuxCncController::clearAlarm() {
  const std::lock_guard<std::mutex> lock(mutex_);
  send("set machine on\r\n");
}

void LinuxCncController::resetEmergencyStop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  resetting_ = true;
  taken_ = 0.0;
  send("set estop off\r\nset machine on\r\n");
}

// These take no lock but that of writing; nothing else is on their connection.
void LinuxCncController::stop() {
  stopAsked_ = true;
  stopSent_ = steadySeconds();
  urgent("set abort");
}

void LinuxCncController::emergencyStop() { urgent("set estop on"); }

void LinuxCncController::feedHold(bool hold) {
  char text[64];
  std::snprintf(text, sizeof text, "set feed_override %.0f", hold ? 0.0 : 100.0 * share_);
  urgent(text);
}

void LinuxCncController::setOverride(double share) {
  share_ = share;
  feedHold(false);
}

}  // namespace mm
