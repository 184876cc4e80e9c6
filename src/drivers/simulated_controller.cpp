#include "drivers/simulated_controller.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

constexpr double kHomingSpeed = 5e-3;  // m/s
constexpr double kHomingTurn = 0.2;    // rad/s
constexpr double kParkedAside = 2e-3;  // m: where the linear axes are found when switched on
constexpr double kStep = 10e-3;        // s, longest step of the motion: a trip stops it within that time

std::vector<std::string> splitSources(const std::string& text) {
  std::vector<std::string> sources;
  std::istringstream in(text);
  for (std::string one; std::getline(in, one, ';');) {
    const auto first = one.find_first_not_of(" \t");
    if (first != std::string::npos)
      sources.push_back(one.substr(first, one.find_last_not_of(" \t") - first + 1));
  }
  return sources;
}

double numberOf(const std::string& name, const std::string& text) {
  std::istringstream in(text);
  double value = 0.0;
  if (!(in >> value) || !(in >> std::ws).eof())
    throw InputError("parameter '" + name + "' of the simulated controller is '" + text + "', not a number");
  return value;
}

}  // namespace

SimulatedController::SimulatedController() = default;
SimulatedController::~SimulatedController() = default;

SimulatedController::Fault SimulatedController::faultOf(const std::string& name) {
  static const std::map<std::string, Fault> kFaults = {{"none", Fault::kNone},
                                                       {"probe_stuck", Fault::kProbeStuck},
                                                       {"probe_dead", Fault::kProbeDead},
                                                       {"temperature_frozen", Fault::kTemperatureFrozen},
                                                       {"temperature_lost", Fault::kTemperatureLost}};
  const auto found = kFaults.find(name);
  if (found != kFaults.end()) return found->second;
  std::string known;
  for (const auto& entry : kFaults) known += (known.empty() ? "" : ", ") + entry.first;
  throw InputError("parameter 'fault' of the simulated controller is '" + name + "'; possible are " + known);
}

void SimulatedController::open(const Machine& machine, const Parameters& parameters) {
  Plan plan;
  plan.source = "no plan";
  plan.text = "{}";
  SimulationRequest request;
  for (const auto& [name, value] : parameters) {
    if (name == "plan")
      plan = value.empty() ? plan : Plan::load(value, machine);
    else if (name == "hide")
      request.hide = splitSources(value);
    else if (name == "seed")
      request.seed = static_cast<std::uint64_t>(numberOf(name, value));
    else if (name == "bounce_s")
      bounce_ = numberOf(name, value);
    else if (name == "fault")
      fault_ = faultOf(value);
    else
      throw InputError(
          "parameter '" + name +
          "' is not known to the simulated controller; possible are plan, hide, seed, bounce_s, fault");
  }
  instrument_ = std::make_unique<SimulatedInstrument>(makeInstrument(machine, plan, request));
  std::vector<double> parked;
  for (const Joint& joint : machine.joints()) {
    axes_.push_back(joint.name);
    const bool bounded = joint.lower < joint.upper;
    homePosition_.push_back(bounded ? std::clamp(0.0, joint.lower, joint.upper) : 0.0);
    const double aside = joint.kind == JointKind::kLinear ? kParkedAside : 0.0;
    parked.push_back(bounded ? std::min(homePosition_.back() + aside, joint.upper) : homePosition_.back());
  }
  instrument_->machine.home(parked);
}

bool SimulatedController::arrived() const { return instrument_->machine.readings() == motion_.target; }

AxesState SimulatedController::poll(double elapsed) {
  const double end = instrument_->machine.time() + elapsed;
  for (double left = elapsed; left > 1e-12; left = end - instrument_->machine.time())
    advance(std::min(left, kStep));
  const SimulatedMachine& machine = instrument_->machine;
  AxesState state;
  state.time = machine.time();
  state.position = machine.readings();
  state.velocity = moving_ || elapsed > 0.0 ? machine.velocity() : std::vector<double>(axes_.size(), 0.0);
  state.limitSwitch.assign(axes_.size(), 0);
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const Joint& joint = machine.machine().joints()[j];
    if (!(joint.lower < joint.upper)) continue;
    if (state.position[j] <= joint.lower) state.limitSwitch[j] = -1;
    if (state.position[j] >= joint.upper) state.limitSwitch[j] = 1;
  }
  state.homed = homed_;
  state.moving = moving_;
  state.emergencyStop = stopped_;
  state.probeClosed = fault_ == Fault::kProbeStuck || (touching_ && fault_ != Fault::kProbeDead);
  if (stopped_) state.fault = "emergency stop; reset it, then home again";
  return state;
}

void SimulatedController::advance(double seconds) {
  SimulatedMachine& machine = instrument_->machine;
  if (!moving_) {
    machine.wait(seconds);
    return;
  }
  machine.step(motion_.target, motion_.speed, seconds);
  const std::optional<Trip> trip = machine.takeTrip();
  const bool answers =
      fault_ == Fault::kNone || fault_ == Fault::kTemperatureFrozen || fault_ == Fault::kTemperatureLost;
  if (trip && answers) {
    addEdges(trip->time, trip->position, trip->velocity);
    if (motion_.probing) moving_ = false;
  }
  if (touching_ && !machine.touching() && answers) {
    ProbeEdge opened;
    opened.time = machine.time();
    opened.closed = false;
    opened.probing = motion_.probing;
    edges_.push_back(opened);
  }
  touching_ = machine.touching();
  if (!arrived()) return;
  moving_ = false;
  if (homing_) homed_ = true;
  homing_ = false;
}

/// The switch closes, opens again and closes, within the time that it bounces.
void SimulatedController::addEdges(double time, const std::vector<double>& position,
                                   const std::vector<double>& velocity) {
  ProbeEdge edge;
  edge.time = time;
  edge.probing = motion_.probing;
  edge.position = position;
  edge.velocity = velocity;
  edges_.push_back(edge);
  if (!(bounce_ > 0.0)) return;
  for (const double part : {0.4, 1.0}) {
    ProbeEdge later = edge;
    later.time = time + part * bounce_;
    later.closed = part == 1.0;
    for (std::size_t j = 0; j < position.size(); ++j) later.position[j] += velocity[j] * part * bounce_;
    edges_.push_back(later);
  }
}

void SimulatedController::requirePower() const {
  if (stopped_) throw Error("emergency stop; reset it, then home again");
}

void SimulatedController::home() {
  requirePower();
  const SimulatedMachine& machine = instrument_->machine;
  motion_ = straightMotion(machine.machine().joints(), machine.readings(), homePosition_, kHomingSpeed,
                           kHomingTurn);
  homed_ = false;
  homing_ = moving_ = true;
}

void SimulatedController::move(const AxesMotion& motion) {
  requirePower();
  if (!homed_) throw Error("not homed; home first");
  motion_ = motion;
  moving_ = true;
}

void SimulatedController::stop() { moving_ = homing_ = false; }

void SimulatedController::emergencyStop() {
  stop();
  stopped_ = true;
  homed_ = false;
}

void SimulatedController::resetEmergencyStop() { stopped_ = false; }

std::vector<ProbeEdge> SimulatedController::takeProbeEdges() {
  std::vector<ProbeEdge> edges;
  edges.swap(edges_);
  return edges;
}

std::optional<ProbeEdge> SimulatedController::readLaser() {
  const std::optional<Trip> trip = instrument_->machine.readLaser();
  if (!trip) return std::nullopt;
  ProbeEdge edge;
  edge.time = trip->time;
  edge.probing = true;
  edge.position = trip->position;
  edge.velocity = trip->velocity;
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

std::optional<Eigen::Vector3d> SimulatedController::trueTip() const { return instrument_->machine.trueTip(); }

}  // namespace mm
