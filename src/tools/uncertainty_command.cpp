#include <iostream>

#include "calibration_file/calibration_yaml.h"
#include "report/uncertainty_output.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "tools/uncertainty_options.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

struct UncertaintyCommand {
  std::string calibration, session;
  UncertaintyOptions options;
  FitOptions fit;
  bool json = false;
};

int runUncertainty(UncertaintyCommand& c) {
  const Calibration calibration = loadCalibration(c.calibration);
  const ToleranceAsked asked = c.options.asked();
  if (!c.session.empty()) {
    const Session session = loadSession(c.session, calibration, c.fit.space);
    CalibrateOptions options = c.fit.checked();
    c.options.foundIn(
        withBar("comparing", options, [&] { return compareCalibration(session, calibration, options); }),
        calibration);
  }
  TaskUncertainty result;
  {
    ProgressBar bar("measuring");
    c.options.trials.progress = [&](double share) { bar.show(share, "trials"); };
    result = taskUncertaintyOf(calibration, c.options);
  }
  const std::vector<TaskVerdict> verdicts = verdictsOf(result, asked);
  std::cout << (c.json ? uncertaintyJson(result, verdicts, calibration) + "\n"
                       : uncertaintyText(result, verdicts))
            << std::flush;
  for (const std::string& note : result.notes) say("note: " + note);
  for (const std::string& why : result.outside)
    warn("the calibration does not hold " + why + "; the uncertainty there is unknown");
  const bool conforms = std::all_of(verdicts.begin(), verdicts.end(), [](const TaskVerdict& v) {
    return v.conformity == Conformity::kConforms;
  });
  return conforms && result.outside.empty() ? kDone : kAnswerIsNo;
}

}  // namespace

void addUncertaintyCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<UncertaintyCommand>(
      app, exitStatus, runUncertainty, "uncertainty",
      "Evaluate the uncertainty of a measurement task on the calibrated machine, with its "
      "budget");
  command.add_option("calibration", c.calibration, "the calibration file")->required();
  command.add_option("--task", c.options.task, "measurement task, see below")->required();
  command.add_option("--session", c.session,
                     "session bag of this machine, preferably the calibrated one: its residuals give the "
                     "direction of the unexplained error and its smooth part");
  declareNamespace(command, c.fit.space);
  c.options.declare(command);
  command.add_flag("--json", c.json, "print one JSON object instead of text");
  command.footer(
      "Tasks (mm, workpiece):\n" + taskHelp() +
      "The task is simulated on machines drawn from the calibration's distribution (GUM Supplement 1,\n"
      "ISO/TS 15530-4). Conformity is decided by ISO 14253-1. Exit status 1: a verdict is not \"conforms\", "
      "or the\n"
      "calibration is not valid for the task.\n"
      "Example: mm uncertainty c.yaml --task distance:0,0,0:15,10,0 --temperature bed=21.5");
}

}  // namespace mm
