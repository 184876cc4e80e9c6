#include "simulation/simulate.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "base/error.h"
#include "base/range.h"
#include "session/trial_block.h"
#include "simulation/wander.h"

namespace mm {
namespace {

/// Travel of each joint over the plan, m or rad; its limits where it does not move.
void rangesOf(const Plan& plan, const Machine& machine, std::vector<double>& lower,
              std::vector<double>& upper) {
  for (int j = 0; j < machine.jointCount(); ++j) {
    Range range;
    for (const PlanMove& move : plan.moves)
      if (move.kind != MoveKind::kGo) range.add(move.position[j]);
    const Joint& joint = machine.joints()[j];
    constexpr double kNotMoved = 1e-6;  // m or rad
    if (range.size() < kNotMoved && joint.upper > joint.lower) range = {joint.lower, joint.upper};
    lower.push_back(range.lower);
    upper.push_back(range.upper);
  }
}

/// Drives an instrument through a plan and writes down what it says.
class Recorder {
 public:
  Recorder(const Plan& plan, const SimulationRequest& request, SimulatedInstrument instrument)
      : plan_(plan),
        machine_(std::move(instrument.machine)),
        result_{Session(machine_.machine()), {}, {}, {}, {}, {}, nullptr, 0, {}},
        correction_(request.correction),
        correctedState_(request.correctedState),
        seed_(request.seed),
        noise_(request.seed, "records") {
    result_.known = std::move(instrument.known);
    result_.hidden = std::move(instrument.hidden);
    result_.rough = settings_.rough;
  }

  void run(const PlanMove& move) {
    stand(move);
    if (move.kind == MoveKind::kTouch) return touch(move);
    go(move);
    if (move.kind == MoveKind::kLaser) keep(machine_.readLaser(move.feature));
    if (byInstrument(move.kind)) reference(move);
  }

  Simulation finish() {
    Session& session = result_.session;
    session.artifact = plan_.artifact;
    for (const PlanPlacement& placement : plan_.placements) session.placements.push_back(placement.name);
    session.temperatures = machine_.temperatureLog();
    session.covariates = machine_.covariateLog();
    session.source = "simulation of " + plan_.source;
    session.prepare();
    result_.truth = std::make_shared<const Truth>(machine_.truth());
    return std::move(result_);
  }

 private:
  /// The operator turns the artifact, or changes the stylus, before the move. What is set down by hand lies
  /// somewhat beside; an offset that is not known is somewhat beside the stated one.
  void stand(const PlanMove& move) {
    if (!plan_.placements.empty() && move.placement != placement_) {
      const PlanPlacement& to = plan_.placements[static_cast<std::size_t>(move.placement)];
      const std::optional<TrialBlock> block = trialBlock(to.name);
      if (block && correctedState_ != 0)
        machine_.switchCorrection(block->state == correctedState_ ? correction_ : nullptr);
      if (placement_ < 0) flat_ = machine_.artifact();
      if (!block || !block->placement.empty()) putDown(to, block ? block->placement : to.name);
      placement_ = move.placement;
    }
    if (plan_.artifact.styli.empty() || move.stylus == stylus_) return;
    const Stylus& stylus = plan_.artifact.styli[static_cast<std::size_t>(move.stylus)];
    Random making(seed_, "stylus " + stylus.name);
    constexpr double kBeside = 50e-6;  // m: an offset that was read from a drawing
    Eigen::Vector3d offset = stylus.offset;
    for (int k = 0; k < 3 && !stylus.known; ++k) offset[k] += kBeside * making.normal();
    machine_.takeStylus(move.stylus, offset);
    stylus_ = move.stylus;
  }

  void putDown(const PlanPlacement& to, const std::string& name) {
    Random byHand(seed_, "placement " + name);
    TrueArtifact artifact = flat_;
    const auto beside = [&] { return settings_.placement.shift * byHand.normal(); };
    const Eigen::Vector3d shift = to.shift + Eigen::Vector3d(beside(), beside(), beside());
    artifact.turn(to.turn + settings_.placement.turn * byHand.normal(), to.about, shift);
    machine_.putDown(artifact);
  }

  void sample(double time, const std::vector<double>& velocity) {
    if (settings_.noise.missingVelocityShare == 0.0)
      result_.motion.push_back({time, machine_.readings(), velocity});
  }

  void moveTo(const std::vector<double>& target, double speed) {
    const std::vector<double> before = machine_.readings();
    const double started = machine_.time();
    machine_.moveTo(target, speed > 0.0 ? speed : plan_.rapid, plan_.rapidRotary);
    const double lasted = machine_.time() - started;
    if (lasted <= 0.0) return;
    std::vector<double> velocity(before.size());
    for (std::size_t j = 0; j < before.size(); ++j) velocity[j] = (target[j] - before[j]) / lasted;
    sample(machine_.time(), velocity);
  }

  void go(const PlanMove& move) {
    moveTo(move.position, move.speed);
    if (move.wait > 0.0) machine_.wait(move.wait);
    sample(machine_.time(), machine_.velocity());
  }

  void touch(const PlanMove& move) {
    moveTo(move.position, 0.0);
    if (move.wait > 0.0) machine_.wait(move.wait);
    std::optional<Trip> trip;
    try {
      trip = machine_.touch(move.target, move.speed, move.feature);
    } catch (const InputError& e) {
      throw InputError(plan_.source + ":" + std::to_string(move.line) + ": " + e.what());
    }
    keep(trip);
    if (trip) sample(trip->time, trip->velocity);
    moveTo(move.position, 0.0);
  }

  Observation& append(double time) {
    Observation o;
    o.time = time;
    o.row = static_cast<std::int64_t>(result_.session.observations.size()) + 1;
    result_.session.observations.push_back(std::move(o));
    return result_.session.observations.back();
  }

  void keep(const std::optional<Trip>& trip) {
    const double draw = noise_.uniform();
    if (!trip) {
      ++result_.missed;
      return;
    }
    Observation& o = append(trip->time);
    o.position = trip->position;
    o.velocity = trip->velocity;
    o.travel = trip->travel;
    o.approach = trip->approach;
    o.laserReading = trip->laserReading;
    o.feature = trip->feature;
    o.placement = std::max(0, placement_);
    o.stylus = std::max(0, stylus_);
    if (draw < settings_.noise.missingVelocityShare) {
      std::fill(o.velocity.begin(), o.velocity.end(), kNotMeasured);
      std::fill(o.travel.begin(), o.travel.end(), 0.0);
    }
    result_.states.push_back(static_cast<const TrueState&>(*trip));
    result_.truePositions.push_back(trip->truePosition);
  }

  double setupZero(const std::string& setup, bool linear) {
    if (setup.empty()) return 0.0;
    // Where the instrument was set to zero nobody knows.
    constexpr double kSetting = 5e-6, kSettingAngular = 2e-5;  // m, rad: standard deviation
    return Random(seed_, "setup " + setup).normal() * (linear ? kSetting : kSettingAngular);
  }

  void reference(const PlanMove& move) {
    Observation& o = append(machine_.time());
    Session& session = result_.session;
    o.placement = std::max(0, placement_);
    o.position = machine_.readings();
    o.velocity = machine_.velocity();
    o.travel = machine_.travel();
    if (!move.setup.empty()) {
      const auto found = std::find(session.setups.begin(), session.setups.end(), move.setup);
      o.setup = static_cast<int>(found - session.setups.begin());
      if (found == session.setups.end()) session.setups.push_back(move.setup);
    }
    if (move.kind == MoveKind::kDeviation) {
      o.kind = ObservationKind::kDeviation;
      o.deviation.assign(o.position.size(), kNotMeasured);
      const bool linear = machine_.machine().joints()[move.joint].kind == JointKind::kLinear;
      o.deviation[move.joint] = machine_.measureDeviation(move.joint) + setupZero(move.setup, linear);
    } else if (move.kind == MoveKind::kLength) {
      o.kind = ObservationKind::kLength;
      o.feature = move.feature;
      const Eigen::Vector3d from = machine_.artifact().centre(move.feature, kReferenceTemperature);
      o.length = (machine_.measurePosition() - from).norm() + setupZero(move.setup, true);
    } else {
      o.kind = ObservationKind::kPosition;
      o.reference = machine_.measurePosition();
    }
    result_.states.push_back({o.time, o.position, o.velocity, o.travel});
    result_.truePositions.push_back(machine_.trueTip());
  }

  const Plan& plan_;
  SimulatedMachine machine_;
  const InstrumentSettings& settings_ = machine_.settings();
  Simulation result_;
  ControllerAdds correction_;  // of the blocks with that state
  char correctedState_;
  std::uint64_t seed_;
  Random noise_;
  int placement_ = -1, stylus_ = -1;
  TrueArtifact flat_;  // as it lies where its file says
};

/// What an instrument without errors goes through at each measurement of a plan.
std::vector<Condition> rehearse(const Machine& machine, const Plan& plan, InstrumentSettings settings,
                                const Physics& sound, const SimulationRequest& request) {
  // What is hidden may depend on where a session goes, but not on how rough it is.
  settings.rough = {};
  SimulationRequest uncorrected = request;
  uncorrected.correction = nullptr;
  Recorder recorder(plan, uncorrected,
                    {SimulatedMachine(machine, plan.artifact, settings, sound, request.seed), {}, {}});
  for (const PlanMove& move : plan.moves) recorder.run(move);
  const Simulation run = recorder.finish();
  std::vector<Condition> visits;
  for (const TrueState& state : run.states) visits.push_back(run.truth->condition(state));
  return visits;
}

/// What is rough in the machine and its artifact; the rest is in its readings.
void roughen(const Machine& machine, const Plan& plan, const InstrumentSettings& settings, std::uint64_t seed,
             const std::function<const std::vector<Condition>&()>& visits, Physics& physics) {
  const Roughness& rough = settings.rough;
  const SimulatedRepeatability size = repeatabilityOf(machine, plan, settings.noise);
  if (rough.form > 0.0) {
    Random making(seed, "rough artifact");
    physics.artifact.misshape(rough.form * size.linear, making);
  }
  if (rough.drift == 0.0) return;
  std::vector<double> times;
  for (const Condition& visit : visits()) times.push_back(visit.time);
  for (int j = 0; j < machine.jointCount(); ++j) {
    const Joint& joint = machine.joints()[j];
    Random wandering(seed, "rough drift " + joint.name);
    const double rms = rough.drift * (joint.kind == JointKind::kLinear ? size.linear : size.angular);
    if (rms > 0.0) physics.sources.emplace_back(Wander(j, rms, times, wandering));
  }
}

}  // namespace

SimulatedInstrument makeInstrument(const Machine& machine, const Plan& plan,
                                   const SimulationRequest& request) {
  InstrumentSettings settings = InstrumentSettings::parse(plan.text, plan.source);
  settings.rough.change(request.rough, "--rough");
  const Chain chain(machine);
  const ThermalModel thermal = settings.thermalModel();
  Physics physics;
  physics.gap.assign(machine.joints().size(), 0.0);
  physics.covariates = settings.covariates;
  physics.artifact = TrueArtifact(plan.artifact);
  const std::string sensor =
      plan.artifact.temperatureSensor.empty() ? "bed" : plan.artifact.temperatureSensor;
  physics.artifactBody = thermal.findBody(sensor);
  if (physics.artifactBody < 0)
    throw InputError(plan.source + ": the artifact's temperature_sensor is '" + sensor +
                     "'; possible are motor, frame, bed, air");
  Random placing(request.seed, "placement");
  if (!plan.artifact.poseKnown)
    physics.artifact.place(settings.placement.shift, settings.placement.turn, placing);
  physics.artifact.scatterFree(plan.artifact, settings.placement.freeCentres, placing);

  const Physics sound = physics;
  std::vector<Condition> visits;
  const auto rehearsed = [&]() -> const std::vector<Condition>& {
    if (visits.empty()) visits = rehearse(machine, plan, settings, sound, request);
    return visits;
  };
  Workshop workshop{machine, chain, plan.artifact, thermal,  settings, *request.kinds, false,
                    {},      {},    physics,       rehearsed};
  workshop.touches = std::any_of(plan.moves.begin(), plan.moves.end(),
                                 [](const PlanMove& move) { return move.kind == MoveKind::kTouch; });
  rangesOf(plan, machine, workshop.lower, workshop.upper);
  const auto hideAll = [&](const std::vector<std::string>& texts, const std::string& where,
                           const std::string& stream) {
    std::vector<HiddenSource> sources;
    for (std::size_t i = 0; i < texts.size(); ++i)
      sources.push_back(hideSource(texts[i], where, request.seed, stream + std::to_string(i), workshop));
    return sources;
  };
  roughen(machine, plan, settings, request.seed, rehearsed, physics);
  std::vector<HiddenSource> known = hideAll(settings.errors, plan.source + ": errors", "known "),
                            hidden = hideAll(request.hide, "--hide", "hidden ");
  SimulatedInstrument instrument{SimulatedMachine(machine, plan.artifact, settings, physics, request.seed),
                                 std::move(known), std::move(hidden)};
  if (request.correction) instrument.machine.loadCorrection(request.correction);
  return instrument;
}

SimulatedRepeatability repeatabilityOf(const Machine& machine, const Plan& plan, const NoiseSettings& noise) {
  double linear = 0.0, angular = 0.0;
  int lengths = 0, angles = 0;
  for (const PlanMove& move : plan.moves) {
    if (move.kind == MoveKind::kGo) continue;
    if (move.kind == MoveKind::kDeviation && machine.joints()[move.joint].kind == JointKind::kRotary) {
      angular += noise.referenceAngular * noise.referenceAngular;
      ++angles;
      continue;
    }
    const double one = move.kind == MoveKind::kTouch   ? noise.repeatability
                       : move.kind == MoveKind::kLaser ? std::hypot(noise.laser, noise.repeatability)
                                                       : noise.reference;
    linear += one * one;
    ++lengths;
  }
  SimulatedRepeatability size{noise.repeatability, noise.angularRepeatability, noise.repeatability};
  if (lengths + angles > 0) size.all = std::sqrt((linear + angular) / (lengths + angles));
  if (lengths > 0) size.linear = std::sqrt(linear / lengths);
  if (angles > 0) size.angular = std::sqrt(angular / angles);
  return size;
}

Simulation simulate(const Machine& machine, const Plan& plan, const SimulationRequest& request,
                    const ProgressCallback& progress) {
  Recorder recorder(plan, request, makeInstrument(machine, plan, request));
  for (std::size_t i = 0; i < plan.moves.size(); ++i) {
    recorder.run(plan.moves[i]);
    if (progress && i % 64 == 0) progress(static_cast<double>(i) / plan.moves.size());
  }
  return recorder.finish();
}

std::string truthYaml(const Simulation& simulation, const SimulationRequest& request) {
  std::ostringstream out;
  out.precision(9);
  out << "seed: " << request.seed << "\nmachine: " << simulation.session.machine.name() << "\n";
  if (!simulation.rough.none()) out << "rough: " << simulation.rough.text() << "\n";
  const auto list = [&](const char* name, const std::vector<HiddenSource>& sources) {
    out << name << ":" << (sources.empty() ? " []" : "") << "\n";
    for (const HiddenSource& source : sources) out << "  - " << source.text() << "\n";
  };
  list("hidden", simulation.hidden);
  list("known", simulation.known);
  const TrueArtifact& artifact = simulation.truth->physics().artifact;
  out << "features_mm:\n";
  for (std::size_t f = 0; f < simulation.session.artifact.features.size(); ++f) {
    const Eigen::Vector3d centre = artifact.centre(static_cast<int>(f), kReferenceTemperature) / kMillimetre;
    out << "  " << simulation.session.artifact.features[f].name << ": [" << centre.x() << ", " << centre.y()
        << ", " << centre.z() << "]\n";
  }
  return out.str();
}

}  // namespace mm
