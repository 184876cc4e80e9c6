#include <filesystem>
#include <iostream>
#include <optional>

#include "base/error.h"
#include "base/read_file.h"
#include "calibration_file/calibration_fit.h"
#include "calibration_file/calibration_store.h"
#include "calibration_file/calibration_yaml.h"
#include "tools/commands.h"
#include "tools/file_kind.h"
#include "tools/store_options.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

/// @throw InputError where the store's active calibration is of another machine: its nodes would find this
/// one in its place; UnreadableFile: the disk does not give it, so whose it is is not known.
void checkSameMachine(const CalibrationStore& store, const Calibration& next) {
  std::optional<Calibration> active;
  try {
    const std::string id = store.linked("active");
    if (!id.empty()) active = store.load(id);
  } catch (const UnreadableFile&) {
    throw;
  } catch (const InputError&) {
    return;  // damaged: what is promoted takes its place
  }
  if (!active) return;
  const Machine machine(next.urdf, next.machineName);
  const std::string difference = differenceOf(*active, machine, next.sessionSpace, "in the new one");
  if (difference.empty()) return;
  throw InputError(store.folder().string() + ": the active calibration '" + active->id +
                   "' is of another machine ('" + active->machineName + "') than '" + next.id + "' ('" +
                   next.machineName + "'): " + difference +
                   "; use a separate --store for each machine, or replace it with --force");
}

struct PromoteOptions : StoreOptions {
  bool force = false;
};

void promote(const PromoteOptions& options) {
  CalibrationStore store = options.store();
  std::string id = options.id;
  const bool file = id.find('/') != std::string::npos || fs::path(id).extension() == ".yaml";
  if (file) {  // one that `mm calibrate -o` wrote: it is kept first
    Calibration calibration = loadCalibration(id);
    store = options.storeFor(calibration);
    if (!options.force) checkSameMachine(store, calibration);  // before anything is kept
    id = store.add(calibration);
  } else if (!id.empty() && fs::is_regular_file(id)) {
    throw InputError(id + ": is " + nameOf(kindOf(id)) +
                     ", not a calibration; make one with mm calibrate -o and promote that file");
  }
  id = store.promote(id, [&](const Calibration& next) {
    if (!options.force) checkSameMachine(store, next);
  });
  std::cout << "active: " << id << " in " << store.folder().string() << '\n';
}

void rollback(const StoreOptions& options) {
  CalibrationStore store = options.store();
  const std::string id = store.rollback(options.id);
  std::cout << "active: " << id << " in " << store.folder().string() << '\n';
}

}  // namespace

void addPromoteCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] =
      addCommand<PromoteOptions>(app, exitStatus, promote, "promote", "Make a calibration active");
  command.add_option("id", options.id, "id from mm history, or a calibration file (default: the candidate)");
  options.declare(command);
  command.add_flag("--force", options.force, "promote even if the active calibration is of another machine");
}

void addRollbackCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] = addCommand<StoreOptions>(app, exitStatus, rollback, "rollback",
                                                     "Make the previously active calibration active again");
  command.add_option("id", options.id, "id from mm history (default: the previously active one)");
  options.declare(command);
}

}  // namespace mm
