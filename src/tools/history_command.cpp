#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "base/error.h"
#include "base/format.h"
#include "base/json_text.h"
#include "calibration_file/calibration_yaml.h"
#include "report/json_parts.h"
#include "report/trend_page.h"
#include "tools/commands.h"
#include "tools/file_kind.h"
#include "tools/output_files.h"
#include "tools/session_input.h"
#include "tools/store_options.h"
#include "verification/calibration_changes.h"
#include "verification/trend.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

struct HistoryOptions : StoreOptions {
  std::vector<std::string> compared;  // two ids, files or bags
  bool trend = false;
  std::string calibration, output, plotly;
  OutputFiles files;
};

std::string micrometres(double metres) { return std::isfinite(metres) ? format("%.3f", metres * 1e6) : "-"; }

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

void printHistory(const HistoryOptions& options) {
  const CalibrationStore store = options.store();
  const auto entries = store.history();
  if (!options.json) return printTable(store, entries);
  std::cout << jsonText({{"store", store.folder().string()}, {"calibrations", jsonList(entries, storedJson)}})
            << '\n';
}

/// An id of the store, "active" or "candidate", or a file.
Calibration calibrationOf(const CalibrationStore& store, const std::string& name) {
  if (fs::is_regular_file(name)) return loadCalibration(name);
  std::string id = name;
  if (name == "active" || name == "candidate") id = store.linked(name.c_str());
  if (id.empty()) throw InputError("--compare: nothing is " + name + " in " + store.folder().string());
  return store.load(id);
}

void compare(const HistoryOptions& options) {
  const std::string &a = options.compared[0], &b = options.compared[1];
  const bool bags = kindOf(a) == FileKind::kBag, other = kindOf(b) == FileKind::kBag;
  if (bags != other)
    throw InputError("--compare: " + (bags ? a : b) + " is a session and " + (bags ? b : a) +
                     " is not; give two sessions with --calibration, or two calibrations");
  if (bags && options.calibration.empty())
    throw InputError(
        "--compare: two sessions are compared under one calibration; name it with --calibration");
  if (!bags && !options.calibration.empty())
    throw InputError("--calibration is for two sessions; " + a + " is none");
  CalibrationChanges changes;
  if (bags) {
    const Calibration calibration = loadCalibration(options.calibration);
    const Session before = loadSession(a, calibration, {}), after = loadSession(b, calibration, {});
    changes = changesBetween(before, after, calibration, {});
  } else {
    const CalibrationStore store = options.store();
    changes = changesBetween(calibrationOf(store, a), calibrationOf(store, b));
  }
  std::cout << changesText(changes);
}

void trend(const HistoryOptions& options) {
  if (!options.output.empty()) options.files.check();
  const CalibrationStore store = options.store();
  std::vector<Calibration> calibrations;
  std::vector<std::string> left;
  for (const CalibrationStore::Entry& entry : store.history()) {
    if (!entry.damaged.empty()) {
      left.push_back(entry.id + ": " + entry.damaged);
      continue;
    }
    calibrations.push_back(store.load(entry.id));
  }
  if (!options.output.empty() && calibrations.empty() && !left.empty())
    throw InputError("of " + std::to_string(left.size()) + " calibrations in " + store.folder().string() +
                     " no calibration can be read: " + left.front());
  for (const std::string& other : ofOtherMachines(calibrations))
    left.push_back(other + ": of another machine");
  for (const std::string& again : refitted(calibrations))
    left.push_back(again + ": of a session that was calibrated again later");
  for (const std::string& one : left) warn("left out: " + one);
  const std::vector<ParameterTrend> trends = trendsOf(calibrations);
  std::cout << (options.json ? trendJson(trends, store.folder().string(), left) + "\n" : trendText(trends));
  if (options.output.empty()) return;
  if (trends.empty())
    throw InputError("no calibration in " + store.folder().string() + ", so there is no trend to plot");
  options.files.write(options.output, trendPage(trends, store.folder().string(), left,
                                                calibrations.back().machineName, options.plotly));
  if (!options.json) std::cout << "written to " << options.output << '\n';
}

void runHistory(HistoryOptions& options) {
  if (options.trend && !options.compared.empty())
    throw InputError("--compare and --trend exclude each other: give one of them");
  if (!options.trend && !options.output.empty()) throw InputError("-o is the page of --trend; add --trend");
  if (options.json && !options.compared.empty())
    throw InputError("--json is for the list and for --trend; leave it out with --compare");
  if (!options.compared.empty()) return compare(options);
  if (!options.trend) return printHistory(options);
  options.files.output("-o", options.output, FileKind::kPage);
  trend(options);
}

}  // namespace

void addHistoryCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] = addCommand<HistoryOptions>(
      app, exitStatus, runHistory, "history", "List stored calibrations, compare two, or show trends");
  options.declare(command);
  command
      .add_option("--compare", options.compared,
                  "show what changed significantly between two calibrations (ids, active, candidate or "
                  "files), or between two sessions with --calibration")
      ->expected(2);
  command.add_option("--calibration", options.calibration,
                     "calibration under whose model two sessions are compared");
  command.add_flag("--trend", options.trend,
                   "show the trend of every parameter over the stored calibrations");
  command.add_option("-o,--output", options.output, "also write an HTML page with plots (with --trend)");
  command.add_option("--plotly", options.plotly,
                     "path of plotly.min.js, if it was not fetched during the build");
  command.add_flag("--json", options.json, "list or trend as JSON");
  options.files.declare(command);
  command.footer(
      "Examples:\n  mm history --compare march.yaml active\n"
      "  mm history --compare march.bag today.bag --calibration march.yaml\n"
      "  mm history --trend -o trend.html");
}

}  // namespace mm
