#include "simulated_controller/simulated_controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "drivers/axis_map.h"
#include "session/csv_cells.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

constexpr double kOver = 1e-12;        // s: rounding of what is left of a step
constexpr double kHomingSpeed = 5e-3;  // m/s
constexpr double kHomingTurn = 0.2;    // rad/s
constexpr double kParkedAside = 2e-3;  // m: where the linear axes are found when switched on
constexpr double kStep = 10e-3;        // s, longest step of the motion: a trip stops it within that time
constexpr double kRampStep = 1e-3;     // s, while the speed changes
constexpr double kAcceleration = 0.5;  // m/s^2
constexpr double kTurning = 10.0;      // rad/s^2
constexpr double kLate = 0.3;          // s by which a slow device is late
constexpr double kGap = 0.2;           // s for which an intermittent device answers, and then does not
constexpr double kWrong = 5e-3;        // m by which a wrong device is wrong

/// Where the axes are at a trip, or where the laser is read.
ProbeEdge edgeOf(const Trip& trip, bool probing, MotionId motion) {
  ProbeEdge edge;
  edge.time = trip.time;
  edge.probing = probing;
  edge.actual = true;
  edge.motion = motion;
  edge.position = trip.position;
  edge.velocity = trip.velocity;
  return edge;
}

}  // namespace

SimulatedController::SimulatedController() = default;
SimulatedController::~SimulatedController() = default;

SimulatedController::Fault SimulatedController::faultOf(const std::string& name) {
  static const std::map<std::string, Fault> kFaults = {{"none", Fault::kNone},
                                                       {"ok", Fault::kNone},
                                                       {"off", Fault::kOff},
                                                       {"stuck", Fault::kStuck},
                                                       {"garbage", Fault::kGarbage},
                                                       {"wrong", Fault::kWrong},
                                                       {"slow", Fault::kSlow},
                                                       {"intermittent", Fault::kIntermittent},
                                                       {"probe_stuck", Fault::kProbeStuck},
                                                       {"probe_dead", Fault::kProbeDead},
                                                       {"temperature_frozen", Fault::kTemperatureFrozen},
                                                       {"temperature_lost", Fault::kTemperatureLost}};
  const auto found = kFaults.find(name);
  if (found != kFaults.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& entry : kFaults) known.push_back(entry.first);
  throw InputError("parameter 'fault' of the simulated controller is '" + name + "'; possible are " +
                   joined(known, ", "));
}

void SimulatedController::open(const ControllerSetup& setup) {
  const Machine machine(setup.urdf, setup.machine);
  Plan plan;
  plan.source = "no plan";
  plan.text = "{}";
  SimulationRequest request;
  refuseUnknownParametersOf(
      setup, "simulated",
      {"plan", "hide", "seed", "bounce_s", "acceleration_m_s2", "acceleration_rad_s2", "fault"});
  const std::string file = textParameterOf(setup, "plan", "");
  if (!file.empty()) plan = Plan::load(file, machine);
  const std::string hide = textParameterOf(setup, "hide", "");
  for (const std::string_view source : wordsIn(hide, ";"))
    if (!trim(source).empty()) request.hide.emplace_back(trim(source));
  request.seed = static_cast<std::uint64_t>(numberParameterOf(setup, "seed", 1.0, 0.0, 1e18));
  bounce_ = numberParameterOf(setup, "bounce_s", bounce_, 0.0, 60.0);
  const double linear = numberParameterOf(setup, "acceleration_m_s2", kAcceleration, 1e-9, 1e9);
  const double turning = numberParameterOf(setup, "acceleration_rad_s2", kTurning, 1e-9, 1e9);
  fault_ = faultOf(textParameterOf(setup, "fault", "none"));
  instrument_ = std::make_unique<SimulatedInstrument>(makeInstrument(machine, plan, request));
  std::vector<std::string> ofPlan;
  for (HiddenSource source : instrument_->known) {
    source.numbers.clear();
    ofPlan.push_back(source.text());
  }
  // As it was asked for: of `random` the answer stays hidden.
  errors_ = "simulated errors: of the plan " + (ofPlan.empty() ? "none" : joined(ofPlan, ", ")) +
            "; of `hide` " + (request.hide.empty() ? "none" : joined(request.hide, "; "));
  std::vector<double> parked;
  for (const Joint& joint : machine.joints()) {
    axes_.push_back(joint.name);
    const bool bounded = joint.lower < joint.upper;
    const bool slides = joint.kind == JointKind::kLinear;
    homePosition_.push_back(bounded ? std::clamp(0.0, joint.lower, joint.upper) : 0.0);
    acceleration_.push_back(slides ? linear : turning);
    const double aside = slides ? kParkedAside : 0.0;
    parked.push_back(bounded ? std::min(homePosition_.back() + aside, joint.upper) : homePosition_.back());
  }
  homed_.assign(axes_.size(), false);
  instrument_->machine.home(parked);
  breakDevice(fault_ == Fault::kOff ? "off" : "ok");
}

void SimulatedController::breakDevice(const std::string& fault) {
  const Fault asked = faultOf(fault);
  if (fault != "ok") fault_ = asked;
  if (fault == "ok" && fault_ <= Fault::kIntermittent) fault_ = Fault::kNone;
  if (fault_ != Fault::kOff) return;
  powered_ = false;
  finish(Outcome::kLost);
}

void SimulatedController::reconnect() {
  if (fault_ == Fault::kOff) throw Error("the simulated device is off");
  if (powered_) return;
  powered_ = true;  // its counters begin anew
  ++resets_;
  homed_.assign(axes_.size(), false);
}

Capabilities SimulatedController::capabilities() const {
  Capabilities can;
  can.feedHold = can.feedOverride = can.homingByAxis = true;
  can.notes.push_back(errors_);
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const Joint& joint = instrument_->machine.machine().joints()[j];
    can.axes.push_back({joint.lower, joint.upper, joint.maxVelocity, acceleration_[j]});
  }
  return can;
}

bool SimulatedController::answers() const {
  return fault_ != Fault::kProbeStuck && fault_ != Fault::kProbeDead;
}

void SimulatedController::finish(Outcome outcome) {
  if (moving_) outcome_ = outcome;
  moving_ = false;
  held_ = false;
  homing_.clear();
  ending_.reset();
  ramp_ = 0.0;
}

void SimulatedController::takeOrders() {
  const bool stop = stopAsked_.exchange(false);
  if (emergency_) {
    finish(Outcome::kStopped);
    homed_.assign(axes_.size(), false);
  } else if (stop && moving_ && !ending_) {
    ending_ = Outcome::kStopped;
  }
}

AxesState SimulatedController::poll(double elapsed) {
  ++polls_;
  if (fault_ == Fault::kOff || !powered_) throw Error("the simulated device is off");
  const double end = instrument_->machine.time() + elapsed;
  for (double left = elapsed; left > kOver; left = end - instrument_->machine.time()) {
    takeOrders();
    const double reach = moving_ && (ramp_ < override_ || ending_ || held_) ? kRampStep : kStep;
    advance(std::min(left, reach));
  }
  takeOrders();
  AxesState state = stateNow();
  if (!(elapsed > 0.0) && !moving_) state.velocity.assign(axes_.size(), 0.0);
  last_ = broken(state);
  return *last_;
}

AxesState SimulatedController::stateNow() const {
  const SimulatedMachine& machine = instrument_->machine;
  AxesState state;
  state.time = machine.time();
  state.position = machine.readings();
  state.velocity = machine.velocity();
  state.actual = true;
  state.limitSwitch.assign(axes_.size(), 0);
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const Joint& joint = machine.machine().joints()[j];
    if (!(joint.lower < joint.upper)) continue;
    if (state.position[j] <= joint.lower) state.limitSwitch[j] = -1;
    if (state.position[j] >= joint.upper) state.limitSwitch[j] = 1;
  }
  state.axisHomed = homed_;
  state.homed = std::all_of(homed_.begin(), homed_.end(), [](bool homed) { return homed; });
  state.moving = moving_;
  state.held = moving_ && held_ && ramp_ == 0.0;
  state.emergencyStop = emergency_;
  state.probeClosed = fault_ == Fault::kProbeStuck || (touching_ && fault_ != Fault::kProbeDead);
  state.feedOverride = override_;
  state.resets = resets_;
  state.motion = motion_.id;
  state.outcome = moving_ ? Outcome::kUnderWay : outcome_;
  return state;
}

/// What a device that is broken says in place of its state.
AxesState SimulatedController::broken(const AxesState& state) {
  AxesState told = state;
  switch (fault_) {
    case Fault::kStuck:
      if (last_) told = *last_;
      break;
    case Fault::kGarbage:
      if (polls_ % 2 == 0)
        told.position.assign(axes_.size(), std::nan(""));
      else
        told.position.resize(axes_.size() + 2, 1e300);
      break;
    case Fault::kWrong:
      told.position[0] += kWrong;
      break;
    case Fault::kSlow:
      late_.push_back(state);
      while (late_.size() > 1 && late_[1].time <= state.time - kLate) late_.pop_front();
      told = late_.front();
      break;
    case Fault::kIntermittent:
      if (std::fmod(state.time, 2.0 * kGap) > kGap)
        throw Error("the simulated device answers only now and then; look at its cable");
      break;
    default:
      break;
  }
  if (fault_ != Fault::kSlow) late_.clear();
  return told;
}

/// Share of the motion's speed after `seconds` more: rises and falls by the acceleration, and falls in time
/// to rest at the target.
double SimulatedController::rampAfter(double seconds) const {
  const std::vector<double>& now = instrument_->machine.readings();
  const double wanted = ending_ || held_ ? 0.0 : override_.load();
  if (!(rise_ > 0.0)) return wanted;
  double left = 0.0;  // s at the whole speed
  for (std::size_t j = 0; j < now.size(); ++j)
    if (motion_.speed[j] > 0.0)
      left = std::max(left, std::abs(motion_.target[j] - now[j]) / motion_.speed[j]);
  const double change = seconds / rise_;
  const double next = std::clamp(wanted, ramp_ - change, ramp_ + change);
  return std::min(next, std::max(std::sqrt(2.0 * left / rise_), change));
}

void SimulatedController::advance(double seconds) {
  SimulatedMachine& machine = instrument_->machine;
  if (!moving_) {
    machine.wait(seconds);
    return;
  }
  ramp_ = rampAfter(seconds);
  if (ramp_ <= 0.0) {
    ramp_ = 0.0;
    machine.wait(seconds);
    if (ending_) finish(*ending_);
    return;
  }
  std::vector<double> speed = motion_.speed;
  for (double& one : speed) one *= ramp_;
  machine.step(motion_.target, speed, seconds);
  const std::optional<Trip> trip = machine.takeTrip();
  if (trip && answers()) {
    addEdges(edgeOf(*trip, motion_.probing, motion_.id));
    if (motion_.probing) ending_ = Outcome::kTripped;
  }
  if (touching_ && !machine.touching() && answers()) {
    ProbeEdge opened;
    opened.time = machine.time();
    opened.closed = false;
    opened.probing = motion_.probing;
    opened.motion = motion_.id;
    edges_.push_back(opened);
  }
  touching_ = machine.touching();
  if (machine.readings() != motion_.target) return;
  for (const std::size_t j : homing_) homed_[j] = true;
  finish(ending_.value_or(Outcome::kReached));
}

/// The switch closes, opens again and closes, within the time that it bounces.
void SimulatedController::addEdges(const ProbeEdge& edge) {
  edges_.push_back(edge);
  if (!(bounce_ > 0.0)) return;
  for (const double part : {0.4, 1.0}) {
    ProbeEdge later = edge;
    later.time += part * bounce_;
    later.closed = part == 1.0;
    for (std::size_t j = 0; j < edge.position.size(); ++j)
      later.position[j] += edge.velocity[j] * part * bounce_;
    edges_.push_back(later);
  }
}

void SimulatedController::requirePower() const {
  if (!powered_) throw Error("the simulated device is off");
  if (emergency_) throw Error("emergency stop; reset it, then home again");
}

void SimulatedController::home(const std::vector<std::size_t>& axes) {
  requirePower();
  const SimulatedMachine& machine = instrument_->machine;
  std::vector<double> target = machine.readings();
  for (const std::size_t j : axes) {
    target[j] = homePosition_[j];
    homed_[j] = false;
  }
  const MotionId id = motion_.id;
  motion_ = straightMotion(machine.machine().joints(), machine.readings(), target, kHomingSpeed, kHomingTurn);
  motion_.id = id;
  start();
  homing_ = axes;
}

void SimulatedController::move(const AxesMotion& motion) {
  requirePower();
  for (const bool homed : homed_)
    if (!homed) throw Error("not homed; home first");
  motion_ = motion;
  start();
}

void SimulatedController::start() {
  stopAsked_ = held_ = false;
  ending_.reset();
  homing_.clear();
  ramp_ = rise_ = 0.0;
  for (std::size_t j = 0; j < axes_.size(); ++j) rise_ = std::max(rise_, motion_.speed[j] / acceleration_[j]);
  moving_ = true;
}

void SimulatedController::resetEmergencyStop() {
  takeOrders();
  emergency_ = false;
}

std::vector<ProbeEdge> SimulatedController::takeProbeEdges() { return std::exchange(edges_, {}); }

std::optional<ProbeEdge> SimulatedController::readLaser() {
  const std::optional<Trip> trip = instrument_->machine.readLaser();
  if (!trip) return std::nullopt;
  ProbeEdge edge = edgeOf(*trip, true, 0);
  edge.laserReading = trip->laserReading;
  return edge;
}

std::vector<std::pair<std::string, double>> SimulatedController::temperatures() {
  SimulatedMachine& machine = instrument_->machine;
  const std::vector<double> values = machine.temperatures();
  std::vector<std::pair<std::string, double>> readings;
  for (std::size_t s = 0; s < values.size(); ++s) readings.emplace_back(machine.sensorNames()[s], values[s]);
  if (fault_ == Fault::kTemperatureLost && !readings.empty()) readings.front().second = std::nan("");
  if (fault_ != Fault::kTemperatureFrozen) return readings;
  if (frozen_.empty()) frozen_ = readings;
  return frozen_;
}

std::optional<std::array<double, 3>> SimulatedController::trueTip() const {
  const Eigen::Vector3d tip = instrument_->machine.trueTip();
  return std::array<double, 3>{tip.x(), tip.y(), tip.z()};
}

}  // namespace mm
