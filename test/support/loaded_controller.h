#pragma once
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "compensation/compensator.h"
#include "session/plan_selection.h"
#include "simulation/simulate.h"
#include "verification/verification_plan.h"
#include "verification/verify.h"
#include "workflow/recalibration.h"

namespace mm::test {

/// What is wrong with the machine of these tests; loadedModel() describes it.
/// @param backlash of x, um. @param warmer um/m by which every axis is longer than when it was calibrated.
inline std::vector<std::string> loadedErrors(double backlash = 3.0, double warmer = 0.0) {
  const auto scale = [&](const char* axis, double own) {
    return "scale:" + std::string(axis) + "=" + std::to_string(own + warmer) + "um/m";
  };
  return {scale("x", 150.0),        scale("y", -200.0),       scale("z", 120.0),
          "squareness:y/x=250urad", "squareness:x/z=150urad", "backlash:x=" + std::to_string(backlash) + "um",
          "backlash:y=4um",         "backlash:z=2um"};
}
inline ModelSpec loadedModel() {
  return parseModelSpec(
      "effects: [{type: scale, axis: x}, {type: scale, axis: y}, {type: scale, axis: z}, {type: squareness, "
      "axis: y, of: x}, {type: squareness, axis: x, of: z}, {type: backlash, axis: x}, {type: backlash, "
      "axis: "
      "y}, {type: backlash, axis: z}]",
      "model");
}

/// A plate of nine balls, `points` touches each, without heat.
inline std::string loadedPlan(int points) {
  return R"(
artifact:
  name: nine_ball_plate
  pose: free
  probe: {tip_radius_mm: 1.0, repeatability_um: 0.3}
  balls:
    - {name: b0, centre_mm: [-13.0, -8.0, -9.0], radius_mm: 3.9685}
    - {name: b1, centre_mm: [0.0, -8.0, -2.0], radius_mm: 3.9685}
    - {name: b2, centre_mm: [13.0, -8.0, 5.0], radius_mm: 3.9685}
    - {name: b3, centre_mm: [-13.0, 10.0, 5.0], radius_mm: 3.9685}
    - {name: b4, centre_mm: [0.0, 10.0, -9.0], radius_mm: 3.9685}
    - {name: b5, centre_mm: [13.0, 10.0, -2.0], radius_mm: 3.9685}
    - {name: b6, centre_mm: [-13.0, 28.0, -2.0], radius_mm: 3.9685}
    - {name: b7, centre_mm: [0.0, 28.0, 5.0], radius_mm: 3.9685}
    - {name: b8, centre_mm: [13.0, 28.0, -9.0], radius_mm: 3.9685}
clearance: {z_mm: 14}
touch: {features: all, points: )" +
         std::to_string(points) + R"(, cone_deg: 105, order: interleaved, speeds_mm_s: [1, 2]}
instrument:
  noise: {repeatability_um: 0.3}
)";
}

/// What a controller adds whose corrections of two joints are exchanged.
/// @param tables also the positions and directions by which they are.
inline ControllerAdds withExchanged(const ControllerAdds& adds, std::size_t a, std::size_t b, bool tables) {
  return [=](std::vector<double> command, std::vector<double> travel, const auto& temperatures) {
    if (tables) std::swap(command[a], command[b]), std::swap(travel[a], travel[b]);
    std::vector<double> added = adds(command, travel, temperatures);
    std::swap(added[a], added[b]);
    return added;
  };
}

/// The same with the corrections of these joints to the other side.
inline ControllerAdds toTheOtherSide(const ControllerAdds& adds, const std::vector<std::size_t>& joints) {
  return [=](const auto& command, const auto& travel, const auto& temperatures) {
    std::vector<double> added = adds(command, travel, temperatures);
    for (const std::size_t j : joints) added[j] = -added[j];
    return added;
  };
}

/// What makes the tip go where it is sent: linear in position and direction of travel, as the models of these
/// tests are, and constant beyond the calibrated range, as tables are.
inline ControllerAdds neededOf(const Calibration& calibration) {
  const Compensator compensator(calibration);
  const auto needed = [&](const Eigen::Vector3d& position, const Eigen::Vector3d& travel) -> Eigen::Vector3d {
    State state = middleState(compensator);
    for (int j = 0; j < 3; ++j) state.position[j] = position[j], state.travel[j] = travel[j];
    compensator.model().place(state);
    const Eigen::Vector3d wanted =
        compensator.model().machine().nominal(state.position.data(), kNotMeasured).position;
    const std::vector<double> found =
        compensator.correctTarget(wanted, MovingState(state), state.travel).position;
    return Eigen::Vector3d(found[0], found[1], found[2]) - position;
  };
  constexpr double kStep = 0.01;  // m
  const Eigen::Vector3d forward = Eigen::Vector3d::Ones(), start = needed(Eigen::Vector3d::Zero(), forward);
  Eigen::Matrix3d byPosition, byTravel;
  for (int j = 0; j < 3; ++j) {
    Eigen::Vector3d back = forward;
    back[j] = -1.0;
    byPosition.col(j) = (needed(kStep * Eigen::Vector3d::Unit(j), forward) - start) / kStep;
    byTravel.col(j) = (start - needed(Eigen::Vector3d::Zero(), back)) / 2.0;
  }
  const std::vector<double> lower = calibration.domain.lower, upper = calibration.domain.upper;
  return [=](std::vector<double> command, const auto& travel, const auto&) {
    for (std::size_t j = 0; j < 3; ++j) command[j] = std::clamp(command[j], lower[j], upper[j]);
    const Eigen::Vector3d added = start + byPosition * Eigen::Vector3d(command[0], command[1], command[2]) +
                                  byTravel * (Eigen::Vector3d(travel[0], travel[1], travel[2]) - forward);
    return std::vector<double>{added[0], added[1], added[2]};
  };
}

/// A machine that was calibrated, and what its controller may have loaded.
struct LoadedController {
  Machine machine = Machine::load("three_axis");
  Calibration calibration;
  Plan short_;          // for the fresh points
  ControllerAdds adds;  // what is right

  /// @param seed of the calibrated session. @param rough as SimulationRequest::rough. @param model, errors
  /// what is fitted and what is hidden, if not loadedModel and loadedErrors.
  explicit LoadedController(std::uint64_t seed, const std::string& rough = {}, const std::string& model = {},
                            const std::vector<std::string>& errors = loadedErrors()) {
    const Plan plan = Plan::parse(loadedPlan(30), "plan.yaml", ".", machine);
    SimulationRequest request;
    request.hide = errors;
    request.seed = seed;
    request.rough = rough;
    const Simulation simulation = simulate(machine, plan, request);
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    calibration = recalibrate(simulation.session,
                              model.empty() ? loadedModel() : parseModelSpec(model, "model"), options)
                      .calibration;
    calibration.id = "test";
    short_ = Plan::parse(planSelection(plan, machine, verificationMoves(plan, calibration, {}), "verify"),
                         "verify.yaml", ".", machine);
    adds = neededOf(calibration);
  }

  /// @param loaded what the controller adds; null: nothing is loaded.
  Session measure(std::uint64_t seed, const ControllerAdds& loaded, const std::string& rough = {},
                  const std::vector<std::string>& errors = loadedErrors()) const {
    SimulationRequest request;
    request.hide = errors;
    request.seed = seed;
    request.rough = rough;
    request.correction = loaded;
    return simulate(machine, short_, request).session;
  }

  Verification judge(const Session& session, bool loaded = true) const {
    VerifyOptions options;
    options.loaded = loaded;
    options.calibrate.threads = 1;
    return verify(session, calibration, options);
  }
};

}  // namespace mm::test
