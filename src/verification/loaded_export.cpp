#include "verification/loaded_export.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "calibration_file/atomic_file.h"

namespace mm {

struct LoadedExport::Description {
  std::string target, calibration;
  std::map<std::string, std::string> letters, sensors;
};

LoadedExport::Description LoadedExport::describe(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "representability.json";
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError("--export " + folder.string() +
                     ": holds no representability.json; name the folder that mm export wrote");
  Description found;
  try {
    const auto json = nlohmann::json::parse(readFile(file));
    found.target = json.at("target").get<std::string>();
    found.calibration = json.value("calibration", "");
    found.letters = json.value("axes", found.letters);
    found.sensors = json.value("sensors", found.sensors);
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file.string() + ": is not what mm export writes (" + e.what() +
                     "); export the calibration again");
  }
  return found;
}

LoadedExport::LoadedExport(const std::filesystem::path& folder, const Calibration& calibration)
    : LoadedExport(folder, calibration, describe(folder)) {}

LoadedExport::LoadedExport(const std::filesystem::path& folder, const Calibration& calibration,
                           const Description& described)
    : target_(described.target),
      sensors_(described.sensors),
      needed_(calibration, described.letters),
      interpreter_(interpret(described.target, folder)) {
  if (!described.calibration.empty() && !calibration.id.empty() && described.calibration != calibration.id)
    throw InputError("--export " + folder.string() + ": was made of calibration '" + described.calibration +
                     "', not of '" + calibration.id +
                     "'; name the calibration whose tables were loaded, or export this one and load that");
  const std::filesystem::path offsets = folder / ExternalOffsets::kFile;
  std::error_code error;
  if (std::filesystem::is_regular_file(offsets, error)) offsets_.emplace(offsets);
}

CommandedState LoadedExport::commandOf(const State& command) const {
  CommandedState commanded = needed_.commandOf(command);
  for (const auto& [there, here] : sensors_) {
    const auto found = commanded.temperature.find(here);
    if (found != commanded.temperature.end()) commanded.temperature[there] = found->second;
  }
  return commanded;
}

Eigen::VectorXd LoadedExport::offsetsAdd(const State& command) const {
  Eigen::VectorXd added = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(command.position.size()));
  if (!offsets_) return added;
  const std::map<std::string, double> offsets = offsets_->at(commandOf(command));
  for (const ExportAxis& axis : needed_.axes())
    if (const auto found = offsets.find(axis.letter); found != offsets.end())
      added[axis.joint] = found->second;
  return added;
}

Eigen::VectorXd LoadedExport::adds(const State& command) const {
  const CommandedState commanded = commandOf(command);
  const auto count = static_cast<Eigen::Index>(command.position.size());
  const bool complete = std::all_of(command.temperature.begin(), command.temperature.end(),
                                    [](double t) { return std::isfinite(t); });
  try {
    const std::map<std::string, double> motors = interpreter_->motors(commanded);
    Eigen::VectorXd added(count);
    for (const ExportAxis& axis : needed_.axes())
      added[axis.joint] = motors.at(axis.letter) - commanded.position.at(axis.letter);
    return added;
  } catch (const InputError&) {
    if (complete) throw;
    return Eigen::VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace mm
