#include "verification/loaded_export.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace mm {
namespace {

LoadedCompensation read(const std::filesystem::path& folder, const Calibration& calibration) {
  const ExportDescription described = describeExport(folder);
  if (described.target.empty())
    throw InputError("--export " + folder.string() +
                     ": holds no representability.json; name the folder that mm export wrote");
  if (!described.calibration.empty() && !calibration.id.empty() && described.calibration != calibration.id)
    throw InputError("--export " + folder.string() + ": was made of calibration '" + described.calibration +
                     "', not of '" + calibration.id +
                     "'; name the calibration whose tables were loaded, or export this one and load that");
  return {described.target, folder};
}

}  // namespace

LoadedExport::LoadedExport(const std::filesystem::path& folder, const Calibration& calibration)
    : loaded_(read(folder, calibration)),
      needed_(calibration, loaded_.description().letters),
      statement_(statedCompensation("--export", target() + ":" + folder.string())) {
  std::error_code error;
  hasOffsets_ = std::filesystem::is_regular_file(folder / ExternalOffsets::kFile, error);
}

/// Motors stand at the command and all that is loaded; the reading at which they stood there before is the
/// command and this.
Eigen::VectorXd LoadedExport::more(const State& command, Adds adds) const {
  const CommandedState commanded = needed_.commandOf(command);
  Eigen::VectorXd more = Eigen::VectorXd::Zero(command.position.size());
  const auto sum = [&](const LoadedCompensation& of, const CommandedState& at, double sign) {
    const std::map<std::string, double> found = (of.*adds)(at);
    for (const ExportAxis& axis : needed_.axes())
      if (const auto value = found.find(axis.letter); value != found.end())
        more[axis.joint] += sign * value->second;
  };
  sum(loaded_, commanded, 1.0);
  if (needed_.active() != nullptr) sum(*needed_.active(), commanded, -1.0);
  return more;
}

Eigen::VectorXd LoadedExport::offsetsAdd(const State& command) const {
  if (!hasOffsets_) return Eigen::VectorXd::Zero(command.position.size());
  return more(command, &LoadedCompensation::offsetsAdd);
}

Eigen::VectorXd LoadedExport::adds(const State& command) const {
  const bool complete = std::all_of(command.temperature.begin(), command.temperature.end(),
                                    [](double t) { return std::isfinite(t); });
  try {
    return more(command, &LoadedCompensation::tablesAdd);
  } catch (const InputError&) {
    if (complete) throw;
    return Eigen::VectorXd::Constant(command.position.size(), std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace mm
