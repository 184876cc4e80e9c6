#pragma once
#include <memory>
#include <string>
#include <vector>

#include "compensation/compensation_table.h"
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

/// Exchanges the words `a` and `b` in the first line of a table.
inline std::string withExchangedColumns(const std::string& table, const std::string& a,
                                        const std::string& b) {
  const std::size_t end = table.find('\n');
  std::string header = table.substr(0, end);
  const std::size_t atA = header.find(a), atB = header.find(b);
  header.replace(std::max(atA, atB), atA > atB ? a.size() : b.size(), atA > atB ? b : a);
  header.replace(std::min(atA, atB), atA < atB ? a.size() : b.size(), atA < atB ? b : a);
  return header + table.substr(end);
}

/// The same table with every correction to the other side. @param column a number: of the first correction.
inline std::string toTheOtherSide(const std::string& table, int corrections) {
  std::string out;
  std::size_t begin = 0;
  for (bool first = true; begin < table.size(); first = false) {
    const std::size_t end = table.find('\n', begin);
    std::string line = table.substr(begin, end - begin);
    std::size_t comma = line.size();
    for (int c = 0; c < corrections && !first; ++c) {
      comma = line.rfind(',', comma - 1);
      if (line[comma + 1] == '-')
        line.erase(comma + 1, 1);
      else
        line.insert(comma + 1, "-");
    }
    out += line + "\n";
    begin = end + 1;
  }
  return out;
}

/// A machine that was calibrated, and what its controller may have loaded.
struct LoadedController {
  Machine machine = Machine::load("three_axis");
  Calibration calibration;
  Plan short_;        // for the fresh points
  std::string table;  // the right one

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
    table = compensationTable(Compensator(calibration), 3);
  }

  /// @param loadedTable empty: nothing is loaded.
  Session measure(std::uint64_t seed, const std::string& loadedTable, const std::string& rough = {},
                  const std::vector<std::string>& errors = loadedErrors()) const {
    SimulationRequest request;
    request.hide = errors;
    request.seed = seed;
    request.rough = rough;
    if (!loadedTable.empty())
      request.correction =
          std::make_shared<const CorrectionTable>(CorrectionTable::parse(loadedTable, "table.csv", machine));
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
