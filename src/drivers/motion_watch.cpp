// What the controller says, cycle by cycle, and what ends a motion because of it.
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "base/error.h"
#include "base/format.h"
#include "base/units.h"
#include "drivers/motion_control.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

// An encoder at rest dithers by a digit, which its driver may call a velocity: rest is where the readings
// stay.
constexpr double kNoSpeed = 1e-6;                         // m/s or rad/s
constexpr double kDither = 1e-6, kRotaryDither = 1e-5;    // m, rad
constexpr double kDeeper = 0.1e-3, kTurnedDeeper = 1e-3;  // m, rad further in: it leads on, not out
constexpr double kStays = 0.1;                            // s

}  // namespace

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
  if (emergency()) controller_->emergencyStop();
}

std::optional<MotionControl::Observation> MotionControl::cycle(double elapsed, double host) {
  Observation seen;
  try {
    owe(true);
    const std::lock_guard<std::timed_mutex> device(device_);
    seen.state = controller_->poll(elapsed);
    seen.edges = controller_->takeProbeEdges();
    owe(false);
  } catch (const std::exception& e) {
    loseDevice(e.what());
    return std::nullopt;
  }
  bool stop = false, lost = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop = weigh(seen, host);
    lost = !lost_.empty();
  }
  if (stop) sendStop();
  changed_.notify_all();
  if (lost) return std::nullopt;
  return seen;
}

void MotionControl::owe(bool answer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  asking_.reset();
  if (answer) asking_ = Wall::now();
}

// Not the age of the last state: a process that was held up has not asked, and the controller is not to
// blame.
double MotionControl::owing() const {
  return asking_ ? std::chrono::duration<double>(Wall::now() - *asking_).count() : 0.0;
}

// It does not answer at all: what moves is told to stop, and the connection is made anew.
void MotionControl::loseDevice(const std::string& why) {
  bool stop = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    asking_.reset();
    stop = current_.has_value();
    lose(why, false);
    check_.forget();
    clock_.reset();
    forgetSurface();
  }
  if (stop) sendStop();
  changed_.notify_all();
  try {
    const std::lock_guard<std::timed_mutex> device(device_);
    regain();
  } catch (const std::exception&) {
    // Still away: the reason of the loss is what is said.
  }
}

// @return whether what moves must be told to stop. With `mutex_` held.
bool MotionControl::weigh(Observation& seen, double host) {
  const AxesState state = seen.state;
  const bool watched = current_ && current_->forced == Outcome::kUnderWay;
  if (state.resets != state_.resets) takeReset();
  if (states_ == 0 || state.time > state_.time || state.resets != state_.resets) fresh_ = Wall::now();
  if (current_ && current_->homing) check_.forget();
  std::string doubt = check_.complaint(state);
  if (doubt.empty() && Wall::now() - fresh_ > std::chrono::duration<double>(settings_.silence))
    doubt = "its state is older than " + shortSeconds(settings_.silence);
  if (!doubt.empty()) {
    if (check_.jumped()) forgetSurface();
    lose(doubt, check_.jumped());
    return current_.has_value();
  }
  if (regained_ && state.moving) {  // a motion that is asked for now would end with the stop of `regain`
    lost_ = "it answers again; its axes are brought to rest";
    state_.time = state.time;
    return false;
  }
  regained_ = false;
  lost_.clear();
  take(state, host);
  endByReason(seen);
  pause_ = 0.0;
  seen.state = state_;
  seen.host = clock_.toHost(state.time);
  seen.trips = probe_.take(seen.edges, state, current_ && current_->motion.probing);
  return watched && current_->forced != Outcome::kUnderWay;
}

// What ends a motion, whatever its controller says; the first that applies.
void MotionControl::endByReason(const Observation& seen) {
  const std::pair<Outcome, std::function<std::string()>> reasons[] = {
      {Outcome::kLost, [&] { return pauseWords(); }},
      {Outcome::kStopped, [&] { return owner_.lapse(); }},
      {Outcome::kStopped, [&] { return forbidden_; }},
      {Outcome::kTripped, [&] { return probeWords(seen); }},
      {Outcome::kLost, [&] { return lateWords(seen.state); }},
  };
  for (const auto& [outcome, words] : reasons) {
    if (!current_ || current_->forced != Outcome::kUnderWay) return;
    if (const std::string why = words(); !why.empty()) force(outcome, why);
  }
}

void MotionControl::takeReset() {
  check_.forget();
  clock_.reset();
  forgetSurface();
  if (!capabilities_.positionSurvivesReset) homedHere_ = false;
  force(Outcome::kLost, "the controller was reset");
}

std::string MotionControl::pauseWords() const {
  if (settings_.simulatedTime || pause_ <= settings_.silence) return {};
  return "the driver was suspended for " + shortSeconds(pause_) +
         ", during which the motion was not monitored";
}

std::string MotionControl::lateWords(const AxesState& state) const {
  const double behind = clock_.late() + state.timeUncertainty;
  if (settings_.simulatedTime || current_->homing || behind <= settings_.late) return {};
  return "the controller's states arrive " + shortSeconds(behind) +
         " late, so the motion cannot be monitored";
}

void MotionControl::take(const AxesState& state, double host) {
  const std::size_t axes = axes_.size();
  const bool zeroed = !state.axisHomed.empty() && state.axisHomed != state_.axisHomed;
  if (zeroed || state.homed != state_.homed) forgetSurface();
  state_ = state;
  if (state_.velocity.empty()) state_.velocity.assign(axes, std::nan(""));
  if (state_.limitSwitch.empty()) state_.limitSwitch.assign(axes, 0);
  if (state_.axisHomed.empty()) state_.axisHomed.assign(axes, state.homed);
  if (!state.homed) homedHere_ = false;
  takeRest(state);
  takeSurface(state);
  if (!settings_.simulatedTime) clock_.add(state.time, host);
  ++states_;
}

void MotionControl::takeRest(const AxesState& state) {
  bool moved = restsAt_.size() != state.position.size() || state.time < restsSince_;
  for (std::size_t j = 0; !moved && j < axes_.size(); ++j)
    moved = std::abs(state.position[j] - restsAt_[j]) >
            (joints_[j].kind == JointKind::kRotary ? kRotaryDither : kDither);
  if (!moved) return;
  restsAt_ = state.position;
  restsSince_ = state.time;
}

// The place where the probe closed is of the zero that was, and so is a trip that has not settled.
void MotionControl::forgetSurface() {
  probe_.forget();
  closedAt_.reset();
  openSince_.reset();
}

// A switch that chatters has opened for good when it stays open for a while.
void MotionControl::takeSurface(const AxesState& state) {
  if (state.probeClosed) {
    if (!closedAt_) closedAt_ = state.position;
    openSince_.reset();
  } else if (closedAt_) {
    if (!openSince_) openSince_ = state.time;
    if (state.time - *openSince_ < settings_.settle) return;
    closedAt_.reset();
    openSince_.reset();
  }
}

std::string MotionControl::switchWords() const {
  if (!probe_.complaint().empty() || unsuccessful_ < settings_.silentMoves) return probe_.complaint();
  return "the probe does not trigger: " + std::to_string(unsuccessful_) +
         " consecutive probing moves ended without a contact; check the stylus, the cable and the position "
         "of the artifact";
}

std::string MotionControl::tripWords(const Current& current) const {
  std::string text =
      current.homing ? "the probe tripped while homing at" : "the probe tripped while positioning at";
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const JointUnit unit = readingUnit(joints_[j]);
    text += format(" %s %.4g %s", axes_[j].c_str(), state_.position[j] / unit.factor, unit.symbol);
  }
  return text + "; all axes were stopped. Look for a collision, then move away slowly";
}

// Outside of probing a trip is a collision; whoever leaves a surface has the probe closed at first.
std::string MotionControl::probeWords(const Observation& seen) {
  Current& current = *current_;
  const AxesState& state = seen.state;
  if (current.motion.probing) return {};
  if (current.armed) {
    bool closed = state.probeClosed;
    for (const ProbeEdge& edge : seen.edges) closed = closed || (edge.closed && !edge.probing);
    return closed ? tripWords(current) : std::string();
  }
  if (!state.probeClosed) {
    if (!current.openSince) current.openSince = state.time;
    current.armed = state.time - *current.openSince >= settings_.settle;
    return {};
  }
  current.openSince.reset();
  // With a probe that is broken, too, a machine must find its zero.
  return current.homing ? std::string() : stuckWords(current);
}

// However many motions lead on from where the probe closed: what a surface lets go of opens within a short
// way. Whoever stands deeper than that already, as after a fast collision, may move as long as it leads out.
std::string MotionControl::stuckWords(const Current& current) const {
  const std::vector<double>& surface = closedAt_ ? *closedAt_ : current.from;
  const auto away = [&](const std::vector<double>& at, JointKind kind) {
    double sum = 0.0;
    for (std::size_t j = 0; j < axes_.size(); ++j)
      if (joints_[j].kind == kind) sum = std::hypot(sum, at[j] - surface[j]);
    return sum;
  };
  const auto beyond = [&](JointKind kind, double escape, double slack) {
    const double now = away(state_.position, kind);
    return now > escape && now > away(current.from, kind) + slack ? now : 0.0;
  };
  const double way = beyond(JointKind::kLinear, settings_.escape, kDeeper);
  double gone = 0.0;  // since this motion began: who retracts along a way may turn as far as he likes
  for (std::size_t j = 0; j < axes_.size(); ++j)
    if (joints_[j].kind == JointKind::kLinear) gone = std::hypot(gone, state_.position[j] - current.from[j]);
  const double turn =
      gone > kDeeper ? 0.0 : beyond(JointKind::kRotary, settings_.rotaryEscape, kTurnedDeeper);
  if (!(way > 0.0) && !(turn > 0.0)) return {};
  return format(
      "the probe stayed closed over %.3g %s of travel; it sticks, or there is an obstacle. All axes were "
      "stopped",
      way > 0.0 ? way / kMillimetre : turn / kDegree, way > 0.0 ? "mm" : "deg");
}

bool MotionControl::atRest() const {
  if (state_.moving) return false;
  const bool slow = std::all_of(state_.velocity.begin(), state_.velocity.end(),
                                [](double v) { return std::isnan(v) || std::abs(v) < kNoSpeed; });
  return slow || state_.time - restsSince_ >= kStays;
}

bool MotionControl::awaitRest(std::unique_lock<std::mutex>& lock) {
  return awaitState(lock, settings_.restTimeout, [&] { return atRest(); });
}

// By a state that was made after the call: the one that comes next may be older.
bool MotionControl::awaitState(std::unique_lock<std::mutex>& lock, double seconds,
                               const std::function<bool()>& shows) {
  const std::uint64_t first = states_ + 1;
  return changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] {
    return ending_ || (states_ > first && lost_.empty() && shows());
  }) && !ending_;
}

}  // namespace mm
