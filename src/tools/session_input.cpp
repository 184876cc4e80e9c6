#include "tools/session_input.h"

#include <yaml-cpp/yaml.h>

#include <CLI/CLI.hpp>

#include "base/error.h"
#include "base/read_file.h"
#include "base/text.h"
#include "base/units.h"
#include "calibration_file/calibration_fit.h"
#include "effects/registry.h"
#include "model/observed_domain.h"
#include "ros_bridge/bag_session.h"
#include "session/session_summary.h"
#include "tools/bounds.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/progress_bar.h"
#include "workflow/learning.h"

namespace mm {

void Bags::declare(CLI::App& command, const std::string& session) {
  command.add_option("bag", paths, session)->required();
}

std::string Bags::joined() const { return mm::joined(paths, ":"); }

Session loadSession(const std::string& bag, const Machine* fallback, const std::string& space) {
  ProgressBar bar("reading");
  Session session = readSessionBags(bagPaths(bag), bar.callback(), fallback, {space, !space.empty()});
  Interrupt::check();
  if (!session.warning.empty()) warn(bag + ": " + session.warning);
  for (const std::string& line : setAsideLines(session)) warn(bag + ": " + line);
  return session;
}

Session loadSession(const std::string& bag, const Calibration& calibration, const std::string& space) {
  const Machine machine(calibration.urdf, calibration.machineName);
  Session session = loadSession(bag, &machine, space);
  checkMachine(calibration, session);
  const std::string difference =
      differenceOf(calibration, session.machine, bagSpace(bag, space), "in the session");
  if (!difference.empty())
    throw InputError(bag + ": was measured on another machine than calibration '" + calibration.id +
                     "': " + difference + "; use a session of the machine that was calibrated");
  warn(uncheckedFit(calibration, session.machine));
  return session;
}

namespace {

/// @throw InputError: an effect of the model cannot be made for the session; names file and line.
void checkEffects(const ModelSpec& model, const std::string& file, const Session& session) {
  const Domain domain = observedDomain(session);
  for (std::size_t i = 0; i < model.effects.size(); ++i) {
    try {
      createEffect(model.effects[i], domain);
    } catch (const InputError& e) {
      const YAML::Node effects =
          YAML::Load(readWholeFile(file, "check the path of the model file"))["effects"];
      throw InputError(file + ":" + std::to_string(effects[i].Mark().line + 1) + ": " + e.what());
    }
  }
}

}  // namespace

Session loadSession(const std::string& bag, const ModelSpec& model, const std::string& file,
                    const std::string& space) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::optional<Machine> machine;
  if (!model.machine.empty()) machine = Machine::load(model.machine, folder);
  Session session = loadSession(bag, machine ? &*machine : nullptr, space);
  checkMachine(model, folder, session);
  checkEffects(model, file, session);
  return session;
}

std::vector<Doubt> askFirst(const Session& session) {
  std::vector<Doubt> questions = sensibleDoubts(session);
  for (const Doubt& d : questions) say("question: " + d.question);
  return questions;
}

void declareNamespace(CLI::App& command, std::string& space) {
  command.add_option("--namespace", space,
                     "namespace of the topics, if the bag holds the sessions of several machines");
}

void FitOptions::declare(CLI::App& command, bool genetic) {
  checkedOption(command, "--repeatability-um", repeatability, numberWithin(1e-6, 1e6, "um"),
                "standard deviation of one measurement (default: from the model, the artifact or repeated "
                "measurements)");
  command.add_flag("--keep-outliers", keepOutliers, "use all observations, outliers included");
  command.add_flag("--white-noise", calibrate.whiteNoise,
                   "treat rows as independent, even if the residuals are correlated");
  declareNamespace(command, space);
  if (!genetic) return;
  seedOption(command, calibrate.seed);
  standardOption(command, "--threads", calibrate.threads, wholeNumberWithin(0, 1024),
                 "number of threads; 0: one per core; does not affect the result");
}

CalibrateOptions FitOptions::checked() const {
  CalibrateOptions options = calibrate;
  if (repeatability > 0.0) options.repeatability = repeatability * kMicrometre;
  options.rejectOutliers = !keepOutliers;
  options.cancelled = Interrupt::asked;
  return options;
}

void SessionAndCalibration::declare(CLI::App& command, const std::string& session) {
  bags.declare(command, session);
  command.add_option("--calibration", calibration, "the calibration file")->required();
  command.add_flag("--json", json, "print the result as JSON on standard output");
}

int verdictOf(const CalibrationResult& result) {
  if (result.cancelled) {
    say("stopped by Ctrl-C: this is the best result so far");
    return kStopped;
  }
  const std::vector<std::string> doubts = doubtsOf(result);
  for (const std::string& doubt : doubts) say(doubt);
  return doubts.empty() ? kDone : kAnswerIsNo;
}

}  // namespace mm
