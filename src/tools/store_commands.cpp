#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "calibration_file/calibration_store.h"
#include "calibration_file/calibration_yaml.h"
#include "tools/commands.h"
#include "tools/store_options.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

void promote(const StoreOptions& options) {
  CalibrationStore store = options.store();
  std::string id = options.id;
  const bool file = id.find('/') != std::string::npos || fs::path(id).extension() == ".yaml";
  if (file) {  // one that `mm calibrate -o` wrote: it is kept first
    Calibration calibration = loadCalibration(id);
    store = options.storeFor(calibration);
    id = store.add(calibration);
  }
  id = store.promote(id);
  std::cout << "active: " << id << " in " << store.folder().string() << '\n';
}

void rollback(const StoreOptions& options) {
  CalibrationStore store = options.store();
  const std::string id = store.rollback(options.id);
  std::cout << "active: " << id << " in " << store.folder().string() << '\n';
}

}  // namespace

void addPromoteCommand(CLI::App& app, int& /*exitStatus*/) {
  auto options = std::make_shared<StoreOptions>();
  CLI::App* command = app.add_subcommand("promote", "Makes a calibration the active one");
  command->add_option("id", options->id,
                      "id from mm history, or a calibration's file (default: the candidate)");
  options->declare(*command);
  command->callback([options] { promote(*options); });
}

void addRollbackCommand(CLI::App& app, int& /*exitStatus*/) {
  auto options = std::make_shared<StoreOptions>();
  CLI::App* command = app.add_subcommand("rollback", "Makes active again what was active before");
  command->add_option("id", options->id, "id from mm history (default: the one before)");
  options->declare(*command);
  command->callback([options] { rollback(*options); });
}

}  // namespace mm
