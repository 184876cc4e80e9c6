#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "session/motion.h"
#include "session/plan.h"
#include "session/progress.h"
#include "session/session.h"
#include "simulation/catalogue.h"
#include "simulation/simulated_machine.h"

namespace mm {

/// What to hide in a simulated session, and the seed of everything random.
struct SimulationRequest {
  std::vector<std::string> hide;  // as for hideSource
  std::uint64_t seed = 1;
  std::string rough;  // how the session is rougher than the plan says: words as for Roughness::change
  ControllerAdds correction = {};  // what the controller adds; null: nothing
  char correctedState = 0;  // A or B: it corrects in the blocks of a blind trial with this state; 0: always
  const std::vector<SourceKind>* kinds = &sourceKinds();  // that can be hidden
};

/// Standard deviation of one measured value of a plan, RMS over its measurements.
struct SimulatedRepeatability {
  double linear = 0.0;   // m, of contacts, laser readings and lengths; that of a contact where there are none
  double angular = 0.0;  // rad, of measured angles; that of a reading of a rotary joint where there are none
  double all = 0.0;      // of both together: m, or rad where only angles are measured
};
/// Standard deviations that the noise of the plan gives, m and rad.
SimulatedRepeatability repeatabilityOf(const Machine& machine, const Plan& plan, const NoiseSettings& noise);

/// An instrument that is ready to measure, and what is wrong with it.
struct SimulatedInstrument {
  SimulatedMachine machine;
  std::vector<HiddenSource> known, hidden;
};

/// A simulated session and its truth.
struct Simulation {
  Session session;
  std::vector<MotionSample> motion;  // for /joint_states; empty where velocities are to be missing
  std::vector<HiddenSource> known;   // of the plan: every such instrument has them
  std::vector<HiddenSource> hidden;  // asked for
  std::vector<TrueState> states;     // of each observation, without noise of travel or velocity being missing
  std::vector<Eigen::Vector3d>
      truePositions;  // of each observation: tip centre or surface point, workpiece, m
  std::shared_ptr<const Truth> truth;
  int missed = 0;   // moves without a measurement: nothing touched, laser out of range or dropped out
  Roughness rough;  // of the plan and asked for
};

/// Builds the instrument of a plan. @throw InputError
SimulatedInstrument makeInstrument(const Machine& machine, const Plan& plan,
                                   const SimulationRequest& request);

/// Runs a plan on a simulated instrument, faster than real time. @throw InputError, Cancelled (from
/// `progress`).
Simulation simulate(const Machine& machine, const Plan& plan, const SimulationRequest& request,
                    const ProgressCallback& progress = {});

/// The answer to what was hidden, as YAML.
std::string truthYaml(const Simulation& simulation, const SimulationRequest& request);

}  // namespace mm
