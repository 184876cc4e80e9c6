#pragma once
#include <filesystem>
#include <string>

#include "calibration_file/calibration_store.h"

namespace CLI {
class App;
}

namespace mm {

/// What the commands of the store share: its folder, and an id.
struct StoreOptions {
  std::string folder, id;
  bool json = false;

  /// Adds the option --store.
  void declare(CLI::App& command);
  /// The folder asked for, else the default one. @throw InputError: neither is known.
  CalibrationStore store() const;
  /// Where the nodes of the calibration's machine look: the folder asked for, else the machine's own one in
  /// the default, where it has one. @throw InputError.
  CalibrationStore storeFor(const Calibration& calibration) const;
};

}  // namespace mm
