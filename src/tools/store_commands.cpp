#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "calibration_file/calibration_fit.h"
#include "calibration_file/calibration_store.h"
#include "calibration_file/calibration_yaml.h"
#include "tools/commands.h"
#include "tools/json_output.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

struct StoreOptions {
  std::string folder, id;
  bool json = false;
};

CalibrationStore storeOf(const StoreOptions& options) {
  return CalibrationStore(options.folder.empty() ? CalibrationStore::defaultFolder()
                                                 : fs::path(options.folder));
}

void addStoreOption(CLI::App* command, StoreOptions& options) {
  command->add_option("--store", options.folder,
                      "folder of calibrations (default: $MM_CALIBRATIONS, else "
                      "~/.measuring_machine/calibrations; a machine with "
                      "a serial or a namespace has a folder of that name in it)");
}

std::string micrometres(double metres) {
  if (!std::isfinite(metres)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", metres * 1e6);
  return text;
}

void printTable(const CalibrationStore& store, const std::vector<CalibrationStore::Entry>& entries) {
  if (entries.empty()) {
    std::cout << "no calibration in " << store.folder().string() << '\n';
    return;
  }
  std::size_t width = 2;
  for (const auto& e : entries) width = std::max(width, e.id.size());
  const int w = static_cast<int>(width);
  std::printf("%-9s  %-*s  %-20s  %-12s  %7s  %8s  %11s  %s\n", "", w, "id", "created (UTC)", "machine",
              "effects", "rms / um", "held out/um", "session");
  for (const auto& e : entries) {
    const char* state = e.active ? "active" : e.candidate ? "candidate" : "";
    if (e.damaged.empty())
      std::printf("%-9s  %-*s  %-20s  %-12s  %7zu  %8s  %11s  %s\n", state, w, e.id.c_str(),
                  e.created.c_str(), e.machine.c_str(), e.effects, micrometres(e.rms).c_str(),
                  micrometres(e.heldOutRms).c_str(), e.session.c_str());
    else
      std::printf("%-9s  %-*s  DAMAGED: %s\n", state, w, e.id.c_str(), e.damaged.c_str());
  }
  std::fflush(stdout);
}

void printHistory(const StoreOptions& options) {
  const CalibrationStore store = storeOf(options);
  const auto entries = store.history();
  if (!options.json) return printTable(store, entries);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& e : entries)
    list.push_back({{"id", e.id},
                    {"created", e.created},
                    {"active", e.active},
                    {"candidate", e.candidate},
                    {"promotions", e.promotions},
                    {"machine", e.machine},
                    {"effects", e.effects},
                    {"rms_um", e.rms * 1e6},
                    {"held_out_rms_um", e.heldOutRms * 1e6},
                    {"session", e.session},
                    {"damaged", e.damaged}});
  printJson(std::cout, {{"store", store.folder().string()}, {"calibrations", list}});
}

/// Where the nodes of the calibration's machine look: its own folder in the default one, where it has one.
CalibrationStore storeFor(const Calibration& calibration, const StoreOptions& options) {
  const std::string part =
      folderOf(Machine(calibration.urdf, calibration.machineName), calibration.sessionSpace);
  if (!options.folder.empty() || part.empty()) return storeOf(options);
  return CalibrationStore(CalibrationStore::defaultFolder() / part);
}

void promote(const StoreOptions& options) {
  CalibrationStore store = storeOf(options);
  std::string id = options.id;
  const bool file = id.find('/') != std::string::npos || fs::path(id).extension() == ".yaml";
  if (file) {  // one that `mm calibrate -o` wrote: it is kept first
    Calibration calibration = loadCalibration(id);
    store = storeFor(calibration, options);
    id = store.add(calibration);
  }
  id = store.promote(id);
  std::cout << "active: " << id << " in " << store.folder().string() << '\n';
}

void rollback(const StoreOptions& options) {
  CalibrationStore store = storeOf(options);
  const std::string id = store.rollback(options.id);
  std::cout << "active: " << id << " in " << store.folder().string() << '\n';
}

}  // namespace

void addHistoryCommand(CLI::App& app, int& /*exitStatus*/) {
  auto options = std::make_shared<StoreOptions>();
  CLI::App* command = app.add_subcommand("history", "The calibrations that are kept, oldest first");
  addStoreOption(command, *options);
  command->add_flag("--json", options->json, "as JSON");
  command->callback([options] { printHistory(*options); });
}

void addPromoteCommand(CLI::App& app, int& /*exitStatus*/) {
  auto options = std::make_shared<StoreOptions>();
  CLI::App* command = app.add_subcommand("promote", "Makes a calibration the active one");
  command->add_option("id", options->id,
                      "id from mm history, or a calibration's file (default: the candidate)");
  addStoreOption(command, *options);
  command->callback([options] { promote(*options); });
}

void addRollbackCommand(CLI::App& app, int& /*exitStatus*/) {
  auto options = std::make_shared<StoreOptions>();
  CLI::App* command = app.add_subcommand("rollback", "Makes active again what was active before");
  command->add_option("id", options->id, "id from mm history (default: the one before)");
  addStoreOption(command, *options);
  command->callback([options] { rollback(*options); });
}

}  // namespace mm
