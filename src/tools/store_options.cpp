#include "tools/store_options.h"

#include <CLI/CLI.hpp>

#include "calibration_file/calibration_fit.h"

namespace mm {

void StoreOptions::declare(CLI::App& command) {
  command.add_option("--store", folder,
                     "folder of calibrations (default: $MM_CALIBRATIONS, else "
                     "~/.measuring_machine/calibrations, with a subfolder for each machine that has a serial "
                     "number or a namespace)");
}

CalibrationStore StoreOptions::store() const {
  return CalibrationStore(folder.empty() ? CalibrationStore::defaultFolder() : std::filesystem::path(folder));
}

CalibrationStore StoreOptions::storeFor(const Calibration& calibration) const {
  const std::string part =
      folderOf(Machine(calibration.urdf, calibration.machineName), calibration.sessionSpace);
  if (!folder.empty() || part.empty()) return store();
  return CalibrationStore(CalibrationStore::defaultFolder() / part);
}

}  // namespace mm
