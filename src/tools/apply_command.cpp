#include <cstdio>
#include <iostream>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/format.h"
#include "calibration_file/calibration_store.h"
#include "calibration_file/calibration_yaml.h"
#include "compensation/apply_states.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/interrupt.h"
#include "tools/one_line.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/store_options.h"

namespace mm {
namespace {

struct ApplyOptions {
  std::string csv, calibration, output;
  StoreOptions store;
  Compensator::Options limits;
  OutputFiles files;
};

Calibration chosenCalibration(const ApplyOptions& options) {
  if (!options.calibration.empty()) return loadCalibration(options.calibration);
  const CalibrationStore store = options.store.store();
  CalibrationStore::Active active = store.active();
  warn(active.warning);
  if (!active.calibration)
    throw InputError("nothing is active in " + store.folder().string() + "; name a file with --calibration");
  return *active.calibration;
}

void runApply(ApplyOptions& options) {
  const bool toStandardOutput = options.output == "-";
  options.files.input({options.csv, options.calibration});
  if (!toStandardOutput) options.files.output("-o", options.output, FileKind::kStates);
  options.files.check();
  const Calibration calibration = chosenCalibration(options);
  const Compensator compensator(calibration, options.limits);
  std::string text;
  AppliedStates applied;
  {
    ProgressBar bar("correcting");
    const CancelScope cancel(Interrupt::asked);
    applied = applyStates(options.csv, calibration, compensator, text, bar.callback());
  }
  if (toStandardOutput) {
    std::cout << text;
  } else {
    options.files.write(options.output, text);
    std::printf(
        "%zu rows, %zu valid; largest correction %.3f um, largest standard deviation %.3g um; written to "
        "%s\n",
        applied.rows, applied.valid, applied.largestMove * 1e6, applied.largestSigma * 1e6,
        options.output.c_str());
    std::fflush(stdout);
  }
  if (!applied.firstReason.empty())
    warn(format("%zu of %zu rows are not valid: ", applied.rows - applied.valid, applied.rows) + options.csv +
         ", " + applied.firstReason);
  if (!applied.firstNote.empty()) say("note: " + options.csv + ", " + applied.firstNote);
}

}  // namespace

void addApplyCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] = addCommand<ApplyOptions>(app, exitStatus, runApply, "apply",
                                                     "Correct the positions in a CSV with a calibration");
  command.add_option("csv", options.csv, "states of the machine, in the import format")->required();
  command.add_option("--calibration", options.calibration,
                     "the calibration file (default: the active calibration)");
  command.add_option("--store", options.store.folder, "folder of calibrations (default: $MM_CALIBRATIONS)");
  command.add_option("-o,--output", options.output, "the CSV to write; - for standard output")->required();
  standardOption(command, "--margin", options.limits.margin, numberWithin(0.0, 10.0),
                 "margin beyond the calibrated range within which a row is still valid, as a fraction of "
                 "the range");
  options.files.declare(command);
  command.footer(
      "Adds corrected_x_mm, corrected_y_mm, corrected_z_mm (probe tip, or surface point of a laser, in "
      "workpiece),\n"
      "sigma_um (standard deviation of a coordinate, from the calibration) and valid (1 or 0) to each row.\n"
      "time_s counts as in the calibrated session; effects of time are not applied after its end.\n"
      "Example: mm apply states.csv --calibration c.yaml -o corrected.csv");
}

}  // namespace mm
