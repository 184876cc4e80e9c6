#include "compensation/compensation_table.h"

#include <set>

#include "base/error.h"
#include "base/format.h"
#include "base/units.h"
#include "effects/inputs.h"
#include "machine/linear_inverse.h"
#include "session/session.h"

namespace mm {
namespace {

std::set<int> travelsOf(const Model& model) {
  std::set<int> joints;
  for (const EffectPtr& effect : model.effects())
    for (const int joint : inputsOf(*effect, model.domain()).travels) joints.insert(joint);
  return joints;
}

}  // namespace

std::string compensationTable(const Compensator& compensator, int points) {
  const Model& model = compensator.model();
  const Domain& domain = model.domain();
  const std::vector<int> linear = linearJoints(model.machine().joints());
  if (linear.empty())
    throw InputError(
        "the machine has no linear joint, so its correction cannot be a table of positions; use the node "
        "compensation");
  const std::set<int> travels = travelsOf(model);
  std::string out;
  for (const int j : linear) out += domain.joints[static_cast<std::size_t>(j)].name + "_mm,";
  for (const int j : travels) out += domain.joints[static_cast<std::size_t>(j)].name + "_travel,";
  for (const int j : linear)
    out += "correction_" + domain.joints[static_cast<std::size_t>(j)].name + "_um" +
           (j == linear.back() ? "\n" : ",");

  std::size_t nodes = std::size_t{1} << travels.size();
  for (std::size_t i = 0; i < linear.size(); ++i) nodes *= static_cast<std::size_t>(points);
  State state = middleState(compensator);
  for (std::size_t node = 0; node < nodes; ++node) {
    std::size_t rest = node;
    for (const int joint : travels) {
      state.travel[static_cast<std::size_t>(joint)] = (rest & 1U) != 0 ? 1.0 : -1.0;
      rest >>= 1U;
    }
    for (const int joint : linear) {
      const std::size_t j = static_cast<std::size_t>(joint);
      const double share = static_cast<double>(rest % static_cast<std::size_t>(points)) / (points - 1);
      state.position[j] = domain.lower[j] + share * (domain.upper[j] - domain.lower[j]);
      rest /= static_cast<std::size_t>(points);
    }
    State now = state;
    model.place(now);
    const Eigen::Vector3d wanted =
        model.machine().nominal(now.position.data(), domain.laser ? now.laserReading : kNotMeasured).position;
    const TargetReadings found = compensator.correctTarget(wanted, MovingState(now), now.travel);
    std::string place, added;
    for (const int joint : linear) {
      const std::size_t j = static_cast<std::size_t>(joint);
      place += format("%.9g,", state.position[j] / kMillimetre);
      added +=
          format("%s%.6f", added.empty() ? "" : ",", (found.position[j] - state.position[j]) / kMicrometre);
    }
    // Limits of motion are the controller's: a node at the end of the travel may lie beyond by its
    // correction.
    if (!found.correction.valid) {
      place.pop_back();
      throw InputError("calibration '" + compensator.id() + "' at " + place +
                       " mm: " + (found.reason.empty() ? found.correction.reason : found.reason));
    }
    for (const int joint : travels) place += format("%.0f,", state.travel[static_cast<std::size_t>(joint)]);
    out += place + added + "\n";
  }
  return out;
}

}  // namespace mm
