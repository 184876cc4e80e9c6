#include <cmath>
#include <filesystem>
#include <iostream>

#include "base/error.h"
#include "base/text.h"
#include "calibration_file/calibration_yaml.h"
#include "report/json.h"
#include "report/text.h"
#include "session/session_hash.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "workflow/learning.h"

namespace mm {
namespace {

/// What `add` and `remove` share: one effect more or less, everything refitted, the ledger told.
using ModelChange = Recalibration (*)(const Session&, const Calibration&, const EffectSpec&,
                                      const CalibrateOptions&);

struct ChangeOptions {
  ModelChange change = nullptr;
  std::vector<std::string> given;  // bags, and behind them the effect
  Bags bags;
  std::string effect, calibration, output;
  bool json = false, all = false;
  std::size_t most = 10;
  FitOptions fit;
  OutputFiles files;
};

void print(const ChangeOptions& c, const Recalibration& done) {
  if (c.json) {
    std::cout << changeJson(done.result, done.calibration.ledger) << '\n';
    return;
  }
  std::cout << ledgerText(done.calibration, !std::isfinite(done.result.figures.rms)) << '\n'
            << calibrateText(done.result);
  if (!c.output.empty()) std::cout << "\nwritten to " << c.output << '\n';
}

/// Each step is written when it is done: whoever is killed loses at most one.
int runAll(ChangeOptions& c, const Session& session, const Calibration& before,
           const CalibrateOptions& options) {
  askFirst(session);
  std::optional<ProgressBar> bar("diagnosing");
  CalibrateOptions shown = options;
  shown.progress = [&](const std::string& stage, double share) { bar->show(share, stage); };
  const auto keep = [&](const Diagnosis& diagnosis, Recalibration& step) {
    if (!c.output.empty()) c.files.write(c.output, step.calibration);
    bar.emplace("diagnosing");
    say(diagnosis.sentence + " Added: " + step.calibration.effects.back().yaml());
  };
  const Learned learned = learnAll(session, before, diagnosing(shown), c.most, keep);
  bar.reset();
  say(learned.sentence);
  if (!learned.last) {  // the file is written all the same: it is what there is to use
    if (learned.stopped) throw Cancelled("stopped before anything was added");
    if (!c.output.empty()) {
      Calibration same = before;
      c.files.write(c.output, same);
    }
    const CalibrationResult held = compareCalibration(session, before, options);
    std::cout << (c.json ? changeJson(held, before.ledger)
                         : ledgerText(before, !std::isfinite(held.figures.rms)) + "\nnothing was added")
              << '\n';
    return learned.complete ? kDone : kAnswerIsNo;
  }
  const Recalibration& last = *learned.last;
  const int status = verdictOf(last.result);
  print(c, last);
  if (learned.stopped) {
    say("stopped by Ctrl-C after " + std::to_string(learned.steps) + " steps, which are in the written file");
    return kStopped;
  }
  if (learned.complete) return status;
  say("after " + std::to_string(learned.steps) + " steps an effect is still missing; run mm diagnose");
  return kAnswerIsNo;
}

/// What was given in one list: the first is a bag, and behind the bags stands the effect.
void takeGiven(ChangeOptions& c) {
  for (const std::string& one : c.given) {
    const bool isBag = c.bags.paths.empty() || endsWith(one, ".bag") || std::filesystem::exists(one);
    if (!c.effect.empty())
      throw InputError("'" + one + "' stands behind the effect " + c.effect +
                       "; name the bags first, and one effect");
    if (isBag)
      c.bags.paths.push_back(one);
    else
      c.effect = one;
  }
}

int runChange(ChangeOptions& c) {
  takeGiven(c);
  c.files.input(c.bags.paths);
  c.files.calibration(c.calibration);
  c.files.output("-o", c.output, FileKind::kCalibration);
  c.files.check();
  CalibrateOptions options = c.fit.checked();
  if (c.all != c.effect.empty())
    throw InputError(c.all ? "--all finds the effects itself; omit '" + c.effect + "'"
                           : "no effect is named; give one, e.g. '{type: backlash, axis: x}', or --all");
  const EffectSpec effect = c.all ? EffectSpec() : parseEffectSpec(c.effect, "effect");
  const Calibration before = loadCalibration(c.calibration);
  const Session session = loadSession(c.bags.joined(), before, c.fit.space);
  const std::size_t steps = before.ledger.size() + (c.all ? c.most : 1);
  c.files.checkSession({sessionHash(session)}, steps);
  if (c.all) return runAll(c, session, before, options);
  Recalibration done =
      withBar("refitting", options, [&] { return c.change(session, before, effect, options); });
  const int status = verdictOf(done.result);
  if (!c.output.empty()) c.files.write(c.output, done.calibration);
  print(c, done);
  return status;
}

/// @param all whether --all goes the whole way: diagnose
/// and add until nothing is missing.
void declareChange(CLI::App& app, int& exitStatus, ModelChange change, bool all, const std::string& name,
                   const std::string& description, const std::string& example) {
  auto [c, command] = addCommand<ChangeOptions>(app, exitStatus, runChange, name, description);
  c.change = change;
  command
      .add_option("bag", c.given,
                  std::string("the session, or several to evaluate together, then the effect as YAML: {type: "
                              "backlash, axis: x}") +
                      (all ? "; no effect with --all" : ""))
      ->required();
  command.add_option("--calibration", c.calibration, "the calibration file")->required();
  command.add_option("-o,--output", c.output, "the new calibration file");
  command.add_flag("--json", c.json, "print the result as JSON on standard output");
  if (all) {
    command.add_flag("--all", c.all, "diagnose and add missing effects one by one until none is missing");
    standardOption(command, "--most", c.most, wholeNumberWithin(1, 100), "largest number of steps of --all");
  }
  c.files.declare(command);
  c.fit.declare(command, all);
  command.footer("Example:\n  " + example);
}

}  // namespace

void addAddCommand(CLI::App& app, int& exitStatus) {
  declareChange(app, exitStatus, addEffect, true, "add",
                "Add an effect to the model, refit everything and record the result in the ledger",
                "mm add plate.bag --calibration plate.yaml '{type: backlash, axis: x}' -o plate2.yaml\n"
                "  mm add plate.bag --calibration plate.yaml --all -o plate9.yaml");
}

void addRemoveCommand(CLI::App& app, int& exitStatus) {
  declareChange(app, exitStatus, removeEffect, false, "remove",
                "Remove an effect from the model, refit everything and record the result in the ledger",
                "mm remove plate.bag --calibration plate2.yaml '{type: backlash, axis: x}' -o plate3.yaml");
}

}  // namespace mm
