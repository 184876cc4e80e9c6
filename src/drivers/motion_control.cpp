#include "drivers/motion_control.h"

#include "base/error.h"
#include "base/format.h"

namespace mm {
namespace {

constexpr double kReset = 2.0;  // s within which a controller leaves its emergency stop, or an alarm

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

}  // namespace

MotionControl::MotionControl(std::shared_ptr<AxisController> controller, const Machine& machine,
                             Settings settings)
    : controller_(std::move(controller)),
      axes_(controller_->axes()),
      joints_(jointsOf(*controller_, machine)),
      settings_(std::move(settings)),
      capabilities_(controller_->capabilities()),
      check_(joints_, capabilities_.axes),
      probe_(settings_.probe),
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
void MotionControl::withDevice(const std::function<void()>& call) const {
#if defined(__SANITIZE_THREAD__)  // that of GCC 12 does not see what a wait by the steady clock takes
  using Clock = std::chrono::system_clock;
#else
  using Clock = Wall;
#endif
  const auto silence = std::chrono::duration<double>(settings_.silence);
  const std::unique_lock<std::timed_mutex> lock(
      device_, Clock::now() + std::chrono::duration_cast<Clock::duration>(silence));
  if (!lock.owns_lock())
    throw Error("the controller has not answered for " + shortSeconds(settings_.silence) +
                "; only stop and emergency stop are sent to it");
  call();
}

std::string MotionControl::shortSeconds(double value) { return format("%.2g s", value); }

MotionControl::EndOfMotion::~EndOfMotion() {
  {
    const std::lock_guard<std::mutex> lock(control.mutex_);
    control.current_.reset();
  }
  control.owner_.end();
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
  if (!forbidden_.empty()) return forbidden_;
  if (emergency() || state_.emergencyStop) return "emergency stop; reset it, then home again";
  if (state_.alarm.present())
    return "alarm" + (state_.alarm.code != 0 ? " " + std::to_string(state_.alarm.code) : std::string()) +
           ": " + state_.alarm.text + (state_.alarm.remedy.empty() ? "" : "; " + state_.alarm.remedy);
  return {};
}

MotionControl::View MotionControl::view() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  View view;
  view.state = state_;
  view.state.emergencyStop = state_.emergencyStop || emergency();
  view.state.homed = state_.homed && homedHere_ && !view.state.emergencyStop;
  view.lost = lost_;
  view.fault = faultText();
  view.homing = current_ && current_->homing;
  view.probing = current_ && current_->motion.probing;
  view.unsuccessful = unsuccessful_;
  view.stops = stops_;
  view.stoppedBy = stoppedBy();
  view.late = settings_.simulatedTime ? 0.0 : clock_.late();
  view.probe = switchWords();
  view.bounces = probe_.bounces();
  view.jolts = probe_.jolts();
  return view;
}

void MotionControl::forbid(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  forbidden_ = why;
}

void MotionControl::paused(double seconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  clock_.reset();
  pause_ = seconds;
}

// The name first: whoever sees that it was stopped says by whom.
void MotionControl::countStop(const std::string& who) {
  {
    const std::lock_guard<std::mutex> lock(stopperMutex_);
    stopper_ = who;
  }
  ++stops_;
}

std::string MotionControl::stoppedBy() const {
  const std::lock_guard<std::mutex> lock(stopperMutex_);
  return stopper_;
}

void MotionControl::stop(const std::string& who) {
  struct Stopping {
    std::atomic<int>& count;
    explicit Stopping(std::atomic<int>& c) : count(c) { ++count; }
    ~Stopping() { --count; }
  } const stopping(stopping_);
  owner_.revoke("stopped by " + who);
  countStop(who);
  sendStop();
  changed_.notify_all();
  std::unique_lock<std::mutex> lock(mutex_);
  if (awaitRest(lock)) return;
  throw Error("stop was sent, but it is unknown whether the axes have stopped" +
              (lost_.empty() ? std::string() : ": " + lost_) + "; use the emergency stop");
}

bool MotionControl::shutDown(const std::string& who) {
  leaving_ = true;
  try {
    stop(who);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

std::string MotionControl::emergencyStop(const std::string& who) {
  ++emergencies_;
  std::string failed;
  try {
    controller_->emergencyStop();
  } catch (const std::exception& e) {
    failed = e.what();
  }
  ++emergencies_;
  countStop(who + " (emergency stop)");
  owner_.revoke("emergency stop by " + who);
  changed_.notify_all();
  return failed;
}

void MotionControl::resetEmergencyStop() {
  const std::uint32_t before = stops_, undone = emergencies_;
  withDevice([&] { controller_->resetEmergencyStop(); });
  std::unique_lock<std::mutex> lock(mutex_);
  homedHere_ = false;
  if (!awaitState(lock, kReset + settings_.silence, [&] { return !state_.emergencyStop; }))
    throw Error(lost_.empty() ? "the controller stays in its emergency stop; look at its button and its panel"
                              : "the controller does not answer: " + lost_);
  if (stops_ != before ||
      emergencies_ != undone) {  // it holds, and at the controller again, which may have been reset after it
    controller_->emergencyStop();
    throw Error("stopped again by " + stoppedBy());
  }
  undone_ = undone;
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
  if (!awaitState(lock, kReset + settings_.silence, [&] { return !state_.alarm.present(); }))
    throw Error("not cleared: " + faultText());
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
