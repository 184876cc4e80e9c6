#include "tools/store_options.h"

#include <CLI/CLI.hpp>

namespace mm {

void StoreOptions::declare(CLI::App& command) {
  command.add_option("--store", folder,
                     "folder of calibrations (default: $MM_CALIBRATIONS, else "
                     "~/.measuring_machine/calibrations; a machine with "
                     "a serial or a namespace has a folder of that name in it)");
}

CalibrationStore StoreOptions::store() const {
  return CalibrationStore(folder.empty() ? CalibrationStore::defaultFolder() : std::filesystem::path(folder));
}

}  // namespace mm
