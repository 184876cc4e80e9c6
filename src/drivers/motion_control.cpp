#include "drivers/motion_control.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"

namespace mm {
namespace {

constexpr double kReset = 2.0;     // s within which a controller leaves its emergency stop
constexpr double kNoSpeed = 1e-9;  // m/s or rad/s

std::vector<Joint> jointsOf(const AxisController& controller, const Machine& machine) {
  std::vector<Joint> joints;
  for (const std::string& axis : controller.axes()) {
    const int joint = machine.findJoint(axis);
    if (joint < 0)
      throw InputError("the controller moves joint '" + axis + "', which the machine does not have");
    joints.push_back(machine.joints()[joint]);
  }
  return joints;
}

std::string inSeconds(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g s", value);
  return text;
}

}  // namespace

MotionControl::MotionControl(std::shared_ptr<AxisController> controller, const Machine& machine,
                             Settings settings)
    : controller_(std::move(controller)),
      axes_(controller_->axes()),
      joints_(jointsOf(*controller_, machine)),
      settings_(std::move(settings)),
      capabilities_(controller_->capabilities()),
      check_(joints_, capabilities_.axes),
      fresh_(Wall::now()) {
  stagesOf({});
  cycle(0.0, 0.0);
  clock_.reset();
}

MotionControl::~MotionControl() {
  end();
  sendStop();
  try {
    controller_->close();
  } catch (const std::exception&) {
    // It is gone already.
  }
}

void MotionControl::end() {
  ending_ = true;
  changed_.notify_all();
}

// The controller is called by one thread at a time; what waits for it says so instead of waiting for ever.
template <typename Call>
void MotionControl::withDevice(const Call& call) const {
  const std::unique_lock<std::timed_mutex> lock(
      device_, std::chrono::duration_cast<Wall::duration>(std::chrono::duration<double>(settings_.silence)));
  if (!lock.owns_lock())
    throw Error("the controller has not answered for " + inSeconds(settings_.silence) +
                "; only stop and emergency stop reach it now");
  call();
}

void MotionControl::sendStop() {
  try {
    controller_->stop();
  } catch (const std::exception&) {
    // Lost: said by the next cycle.
  }
}

double MotionControl::toHost(double time) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return clock_.toHost(time);
}

std::string MotionControl::faultText() const {
  if (!lost_.empty()) return "the controller does not answer: " + lost_;
  if (emergency_ || state_.emergencyStop) return "emergency stop; reset it, then home again";
  if (state_.alarm.present())
    return "alarm" + (state_.alarm.code != 0 ? " " + std::to_string(state_.alarm.code) : std::string()) +
           ": " + state_.alarm.text + (state_.alarm.remedy.empty() ? "" : "; " + state_.alarm.remedy);
  return {};
}

MotionControl::View MotionControl::view() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  View view;
  view.state = state_;
  view.state.emergencyStop = state_.emergencyStop || emergency_;
  view.state.homed = state_.homed && homedHere_ && !view.state.emergencyStop;
  view.lost = lost_;
  view.fault = faultText();
  view.homing = current_ && current_->homing;
  view.probing = current_ && current_->motion.probing;
  view.unsuccessful = unsuccessful_;
  view.stops = stops_;
  view.stoppedBy = stoppedBy_;
  view.late = settings_.simulatedTime ? 0.0 : clock_.late();
  return view;
}

void MotionControl::force(Outcome outcome, const std::string& why) {
  if (!current_ || current_->forced != Outcome::kUnderWay) return;
  current_->forced = outcome;
  current_->why = why;
}

void MotionControl::lose(const std::string& why, bool zeroInDoubt) {
  lost_ = why;
  if (zeroInDoubt || !capabilities_.positionSurvivesReset) homedHere_ = false;
  force(Outcome::kLost, why);
}

void MotionControl::regain() {
  if (Wall::now() < nextReconnect_) return;
  nextReconnect_ = Wall::now() + std::chrono::duration_cast<Wall::duration>(
                                     std::chrono::duration<double>(settings_.reconnect));
  controller_->reconnect();
  regained_ = true;
  controller_->stop();  // it may have gone on alone
  if (emergency_) controller_->emergencyStop();
}

std::optional<MotionControl::Observation> MotionControl::cycle(double elapsed, double host) {
  Observation seen;
  bool stop = false;
  try {
    const std::lock_guard<std::timed_mutex> device(device_);
    seen.state = controller_->poll(elapsed);
    seen.edges = controller_->takeProbeEdges();
  } catch (const std::exception& e) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop = current_.has_value();
      lose(e.what(), false);
      check_.forget();
      clock_.reset();
    }
    if (stop) sendStop();
    changed_.notify_all();
    try {
      const std::lock_guard<std::timed_mutex> device(device_);
      regain();
    } catch (const std::exception&) {
      // Still away: the reason of the loss is what is said.
    }
    return std::nullopt;
  }
  const AxesState& state = seen.state;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (state.resets != state_.resets) {
      check_.forget();
      clock_.reset();
      if (!capabilities_.positionSurvivesReset) homedHere_ = false;
      force(Outcome::kLost, "the controller was reset");
    }
    if (current_ && current_->homing) check_.forget();
    const std::string wrong = check_.complaint(state);
    const Wall::time_point now = Wall::now();
    if (states_ == 0 || state.time > state_.time || state.resets != state_.resets) fresh_ = now;
    const double age = std::chrono::duration<double>(now - fresh_).count();
    if (!wrong.empty()) {
      stop = current_.has_value();
      lose(wrong, check_.jumped());
    } else if (elapsed > 0.0 && age > settings_.silence) {
      stop = current_.has_value();
      lose("its state is older than " + inSeconds(settings_.silence), false);
    } else if (regained_ && state.moving) {
      // A motion that is asked for now would end with the stop of `regain`.
      lost_ = "it answers again; its axes are brought to rest";
      state_.time = state.time;
    } else {
      regained_ = false;
      lost_.clear();
      take(state, host);
      if (current_ && current_->forced == Outcome::kUnderWay) {
        watchProbe(state, seen.edges);
        const double behind = clock_.late() + state.timeUncertainty;
        if (!settings_.simulatedTime && !current_->homing && behind > settings_.late)
          force(Outcome::kLost, "the controller's states arrive " + inSeconds(behind) +
                                    " late, so that the motion cannot be watched");
        stop = current_->forced != Outcome::kUnderWay;
      }
      seen.state = state_;
      seen.host = clock_.toHost(state.time);
      for (const ProbeEdge& edge : seen.edges) seen.edgeHost.push_back(clock_.toHost(edge.time));
    }
    if (!lost_.empty() && !stop) {
      changed_.notify_all();
      return std::nullopt;
    }
  }
  if (stop) sendStop();
  changed_.notify_all();
  if (stop) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!lost_.empty()) return std::nullopt;
  }
  return seen;
}

void MotionControl::take(const AxesState& state, double host) {
  const std::size_t axes = axes_.size();
  state_ = state;
  if (state_.velocity.empty()) state_.velocity.assign(axes, std::nan(""));
  if (state_.limitSwitch.empty()) state_.limitSwitch.assign(axes, 0);
  if (state_.axisHomed.empty()) state_.axisHomed.assign(axes, state.homed);
  if (!state.homed) homedHere_ = false;
  if (!settings_.simulatedTime) clock_.add(state.time, host);
  ++states_;
}

std::string MotionControl::tripWords(const Current& current) const {
  std::string text =
      current.homing ? "the probe tripped while homing at" : "the probe tripped while positioning at";
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const bool turns = joints_[j].kind == JointKind::kRotary;
    char one[64];
    std::snprintf(one, sizeof one, " %s %.4g %s", axes_[j].c_str(),
                  state_.position[j] / (turns ? 3.14159265358979 / 180.0 : 1e-3), turns ? "deg" : "mm");
    text += one;
  }
  return text + "; all axes were stopped. Look for a collision, then move away slowly";
}

// Outside of probing a trip is a collision; whoever leaves a surface has the probe closed at first.
void MotionControl::watchProbe(const AxesState& state, const std::vector<ProbeEdge>& edges) {
  Current& current = *current_;
  if (current.motion.probing) return;
  if (current.armed) {
    bool closed = state.probeClosed;
    for (const ProbeEdge& edge : edges) closed = closed || (edge.closed && !edge.probing);
    if (closed) force(Outcome::kTripped, tripWords(current));
    return;
  }
  if (!state.probeClosed) {
    if (!current.openSince) current.openSince = state.time;
    current.armed = state.time - *current.openSince >= settings_.settle;
    return;
  }
  current.openSince.reset();
  if (current.homing) return;
  double way = 0.0;
  for (std::size_t j = 0; j < axes_.size(); ++j)
    if (joints_[j].kind == JointKind::kLinear) way = std::hypot(way, state.position[j] - current.from[j]);
  if (way <= settings_.escape) return;
  char text[160];
  std::snprintf(text, sizeof text,
                "the probe stayed closed for %.3g mm of the way; it sticks, or the way leads into something. "
                "All axes were stopped",
                1e3 * way);
  force(Outcome::kTripped, text);
}

bool MotionControl::atRest() const {
  if (state_.moving) return false;
  return std::all_of(state_.velocity.begin(), state_.velocity.end(),
                     [](double v) { return std::isnan(v) || std::abs(v) < kNoSpeed; });
}

// At rest by a state that was made after the call: the one that comes next may be older.
bool MotionControl::awaitRest(std::unique_lock<std::mutex>& lock, double seconds) {
  const std::uint64_t first = states_ + 1;
  return changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] {
    return ending_ || (states_ > first && lost_.empty() && atRest());
  }) && !ending_;
}

void MotionControl::requireReady(bool homedToo) const {
  if (stopping_ > 0) throw Error("a stop is under way; wait until the axes rest");
  const std::string fault = faultText();
  if (!fault.empty()) throw Error(fault);
  if (homedToo && !(state_.homed && homedHere_)) throw Error("not homed; call ~home first");
}

MotionControl::Report MotionControl::move(AxesMotion motion, const Mover& mover, std::uint32_t stopsSeen,
                                          const Watch& watch) {
  checkTarget(joints_, motion.target);
  checkSpeeds(joints_, motion);
  owner_.begin(mover, motion.probing ? "a probing motion" : "a motion");
  struct End {
    MotionControl& control;
    ~End() {
      {
        const std::lock_guard<std::mutex> lock(control.mutex_);
        control.current_.reset();
      }
      control.owner_.end();
    }
  } const end{*this};
  withDevice([&] {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      requireReady(true);
      if (motion.probing && state_.probeClosed)
        throw Error("the probe is closed before the probing move; retract it, or check whether it sticks");
      if (stops_ != stopsSeen) throw Error("stopped by " + stoppedBy_);
      motion.id = ++lastId_;
      motion.leaving = state_.probeClosed;
      Current current;
      current.motion = motion;
      current.armed = !motion.leaving;
      current.from = state_.position;
      current_ = current;
    }
    controller_->move(motion);
  });
  if (stops_ != stopsSeen) sendStop();
  bool cancelled = false;
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ending_) {
    changed_.wait_for(lock, std::chrono::milliseconds(20));
    if (!current_) break;
    if (stops_ != stopsSeen) force(Outcome::kStopped, "stopped by " + stoppedBy_);
    if (current_->forced != Outcome::kUnderWay) break;
    const double age = std::chrono::duration<double>(Wall::now() - fresh_).count();
    if (age > settings_.silence) {
      force(Outcome::kLost, "the controller has not answered for " + inSeconds(age) + "; stop was sent");
      break;
    }
    if (state_.held && !current_->heldSince) current_->heldSince = Wall::now();
    if (!state_.held) current_->heldSince.reset();
    if (current_->heldSince &&
        Wall::now() - *current_->heldSince > std::chrono::duration<double>(settings_.holdLimit)) {
      force(Outcome::kHeld, "in feed hold for longer than " + inSeconds(settings_.holdLimit));
      break;
    }
    if (state_.motion == motion.id && state_.outcome != Outcome::kUnderWay && !state_.moving) break;
    if (watch) {
      const AxesState now = state_;
      lock.unlock();
      cancelled = !watch(now);
      lock.lock();
      if (cancelled) break;
    }
  }
  if (!current_ || ending_) throw Error("the driver ends");
  if (cancelled || current_->forced != Outcome::kUnderWay) {
    lock.unlock();
    sendStop();
    lock.lock();
    const bool rests = awaitRest(lock, settings_.restTimeout);
    if (!rests && current_)
      current_->why += "; whether the axes rest is not known" + (lost_.empty() ? "" : ": " + lost_);
  }
  if (motion.probing && current_) {
    const bool tripped = current_->forced == Outcome::kUnderWay && state_.outcome == Outcome::kTripped;
    if (tripped) unsuccessful_ = 0;
    if (!tripped && state_.outcome == Outcome::kReached) ++unsuccessful_;
  }
  return judge(*current_, cancelled);
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
      report.message = "stopped at the controller";
      return report;
    default:
      report.message = state_.note.empty() ? faultText() : state_.note;
      if (report.message.empty())
        report.message = "the controller ended the motion: " + outcomeName(state_.outcome);
      return report;
  }
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const bool turns = joints_[j].kind == JointKind::kRotary;
    double tolerance = turns ? settings_.rotaryTolerance : settings_.tolerance;
    if (j < capabilities_.axes.size()) tolerance = std::max(tolerance, capabilities_.axes[j].resolution);
    const double away = state_.position[j] - current.motion.target[j];
    if (std::abs(away) <= tolerance) continue;
    report.outcome = Outcome::kAlarm;
    char text[200];
    const double unit = turns ? 3.14159265358979 / 180.0 : 1e-3;
    std::snprintf(text, sizeof text,
                  "%s rests %.6g %s beside its target of %.6g, beyond the tolerance of %.3g; the motion is "
                  "not counted as done",
                  axes_[j].c_str(), away / unit, turns ? "deg" : "mm", current.motion.target[j] / unit,
                  tolerance / unit);
    report.message = text;
    break;
  }
  return report;
}

std::vector<std::vector<std::size_t>> MotionControl::stagesOf(const std::vector<std::string>& names) const {
  const auto index = [&](const std::string& name) {
    const auto found = std::find(axes_.begin(), axes_.end(), name);
    if (found == axes_.end()) throw InputError("joint '" + name + "' is not moved by this driver");
    return static_cast<std::size_t>(found - axes_.begin());
  };
  std::vector<std::size_t> wanted;
  for (const std::string& name : names) wanted.push_back(index(name));
  for (std::size_t j = 0; names.empty() && j < axes_.size(); ++j) wanted.push_back(j);
  std::vector<std::vector<std::size_t>> stages;
  std::vector<bool> listed(axes_.size(), false);
  for (const std::vector<std::string>& stage : settings_.homingOrder) {
    stages.emplace_back();
    for (const std::string& name : stage) {
      const std::size_t j = index(name);
      if (listed[j]) throw InputError("joint '" + name + "' stands twice in the order of homing");
      listed[j] = true;
      if (std::count(wanted.begin(), wanted.end(), j) > 0) stages.back().push_back(j);
    }
  }
  std::vector<std::size_t> rest;
  for (const std::size_t j : wanted)
    if (!listed[j]) rest.push_back(j);
  stages.push_back(rest);
  stages.erase(std::remove_if(stages.begin(), stages.end(), [](const auto& s) { return s.empty(); }),
               stages.end());
  return stages;
}

void MotionControl::home(const std::vector<std::string>& names, const Mover& mover) {
  std::vector<std::vector<std::size_t>> stages = stagesOf(names);
  if (!capabilities_.homingByAxis) {
    if (!names.empty() && names.size() < axes_.size())
      throw Error("this controller homes all axes together; call ~home");
    stages.assign(1, {});
    for (std::size_t j = 0; j < axes_.size(); ++j) stages[0].push_back(j);
  }
  const std::uint32_t stopsSeen = stops_;
  owner_.begin(mover, "homing");
  struct End {
    MotionControl& control;
    ~End() {
      {
        const std::lock_guard<std::mutex> lock(control.mutex_);
        control.current_.reset();
      }
      control.owner_.end();
    }
  } const end{*this};
  for (const std::vector<std::size_t>& stage : stages) {
    withDevice([&] {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        const bool alarmed = lost_.empty() && !emergency_ && !state_.emergencyStop;
        if (!alarmed) requireReady(false);  // an alarm may be what homing ends
        if (stops_ != stopsSeen) throw Error("stopped by " + stoppedBy_);
        Current current;
        current.homing = true;
        current.armed = !state_.probeClosed;
        current.from = state_.position;
        current_ = current;
      }
      controller_->home(stage);
    });
    if (stops_ != stopsSeen) sendStop();
    awaitHoming(stage, stopsSeen);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state_.homed) homedHere_ = true;
}

void MotionControl::awaitHoming(const std::vector<std::size_t>& stage, std::uint32_t stopsSeen) {
  std::unique_lock<std::mutex> lock(mutex_);
  const std::uint64_t first = states_ + 1;
  std::string why;
  while (why.empty()) {
    changed_.wait_for(lock, std::chrono::milliseconds(20));
    if (ending_) throw Error("the driver ends");
    const double age = std::chrono::duration<double>(Wall::now() - fresh_).count();
    if (stops_ != stopsSeen)
      why = "stopped by " + stoppedBy_;
    else if (current_->forced != Outcome::kUnderWay)
      why = current_->why;
    else if (age > settings_.silence)
      why = "the controller has not answered for " + inSeconds(age);
    else if (states_ > first && !state_.moving)
      break;
  }
  if (why.empty() &&
      std::all_of(stage.begin(), stage.end(), [&](std::size_t j) { return state_.axisHomed[j]; }))
    return;
  if (why.empty()) why = faultText();
  if (why.empty()) why = "the controller stopped on the way";
  lock.unlock();
  sendStop();
  lock.lock();
  awaitRest(lock, settings_.restTimeout);
  throw Error("homing did not end: " + why);
}

void MotionControl::stop(const std::string& who) {
  struct Stopping {
    std::atomic<int>& count;
    explicit Stopping(std::atomic<int>& c) : count(c) { ++count; }
    ~Stopping() { --count; }
  } const stopping(stopping_);
  owner_.revoke("stopped by " + who);
  if (std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock); lock.owns_lock()) stoppedBy_ = who;
  ++stops_;
  sendStop();
  changed_.notify_all();
  std::unique_lock<std::mutex> lock(mutex_);
  stoppedBy_ = who;
  if (awaitRest(lock, settings_.restTimeout)) return;
  throw Error("stop was sent, but whether the axes rest is not known" +
              (lost_.empty() ? std::string() : ": " + lost_) + "; use the emergency stop");
}

std::string MotionControl::emergencyStop(const std::string& who) {
  emergency_ = true;
  std::string failed;
  try {
    controller_->emergencyStop();
  } catch (const std::exception& e) {
    failed = e.what();
  }
  ++stops_;
  owner_.revoke("emergency stop by " + who);
  if (std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock); lock.owns_lock())
    stoppedBy_ = who + " (emergency stop)";
  changed_.notify_all();
  return failed;
}

void MotionControl::resetEmergencyStop() {
  const std::uint32_t before = stops_;
  withDevice([&] { controller_->resetEmergencyStop(); });
  std::unique_lock<std::mutex> lock(mutex_);
  homedHere_ = false;
  const std::uint64_t first = states_ + 1;
  const bool reset = changed_.wait_for(lock, std::chrono::duration<double>(kReset + settings_.silence), [&] {
    return ending_ || (states_ > first && lost_.empty() && !state_.emergencyStop);
  });
  if (!reset || ending_)
    throw Error(lost_.empty() ? "the controller stays in its emergency stop; look at its button and its panel"
                              : "the controller does not answer: " + lost_);
  if (stops_ != before) throw Error("stopped again by " + stoppedBy_);
  emergency_ = false;
}

void MotionControl::hold(bool on) {
  if (!capabilities_.feedHold) throw Error("this controller has no feed hold; use ~stop");
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (on && !current_) throw Error("nothing moves");
    if (!on && !faultText().empty()) throw Error(faultText());
  }
  controller_->feedHold(on);
}

void MotionControl::setOverride(double share) {
  if (!(share > 0.0) || share > 1.0)
    throw InputError("the override is " + std::to_string(share) + "; it must be above 0 and at most 1");
  if (!capabilities_.feedOverride) throw Error("this controller has no override");
  controller_->setOverride(share);
}

void MotionControl::clearAlarm() {
  withDevice([&] { controller_->clearAlarm(); });
  std::unique_lock<std::mutex> lock(mutex_);
  const std::uint64_t first = states_ + 1;
  const bool cleared = changed_.wait_for(lock, std::chrono::duration<double>(2.0 + settings_.silence), [&] {
    return ending_ || (states_ > first && lost_.empty() && !state_.alarm.present());
  });
  if (!cleared || ending_) throw Error("not cleared: " + faultText());
}

void MotionControl::moveOffLimit(const Mover& mover) {
  if (!capabilities_.moveOffLimit) throw Error("this controller cannot move off a limit; do it at its panel");
  const std::uint32_t stopsSeen = stops_;
  owner_.begin(mover, "moving off a limit");
  struct End {
    MotionOwner& owner;
    ~End() { owner.end(); }
  } const end{owner_};
  withDevice([&] { controller_->moveOffLimit(); });
  if (stops_ != stopsSeen) sendStop();
  std::unique_lock<std::mutex> lock(mutex_);
  const std::uint64_t first = states_ + 1;
  if (!changed_.wait_for(lock, std::chrono::seconds(60), [&] {
        return ending_ || stops_ != stopsSeen || !lost_.empty() || (states_ > first && !state_.moving);
      }))
    throw Error("the axes did not come off the limit within 60 s");
  if (stops_ != stopsSeen) throw Error("stopped by " + stoppedBy_);
  for (std::size_t j = 0; j < state_.limitSwitch.size(); ++j)
    if (state_.limitSwitch[j] != 0) throw Error("the limit switch of " + axes_[j] + " is still closed");
}

void MotionControl::breakDevice(const std::string& fault) {
  withDevice([&] { controller_->breakDevice(fault); });
}

std::optional<ProbeEdge> MotionControl::readLaser() {
  std::optional<ProbeEdge> reading;
  withDevice([&] { reading = controller_->readLaser(); });
  return reading;
}

std::vector<std::pair<std::string, double>> MotionControl::temperatures() {
  std::vector<std::pair<std::string, double>> readings;
  withDevice([&] { readings = controller_->temperatures(); });
  return readings;
}

}  // namespace mm
