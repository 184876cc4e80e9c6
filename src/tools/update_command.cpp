#include <cmath>
#include <iostream>

#include "calibration_file/calibration_yaml.h"
#include "report/json.h"
#include "report/text.h"
#include "tools/commands.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

struct UpdateOptions : SessionAndCalibration {
  std::string output;
  OutputFiles files;
};

void runUpdate(UpdateOptions& c) {
  c.files.input(c.bags.paths);
  c.files.calibration(c.calibration);
  c.files.output("-o", c.output, FileKind::kCalibration);
  c.files.check();
  CalibrateOptions options = c.fit.checked();
  const Calibration before = loadCalibration(c.calibration);
  c.files.checkSession({before.sessionHash}, before.ledger.size() + 1);
  const Session session = loadSession(c.bags.joined(), before, c.fit.space);
  Recalibration done = withBar("updating", options, [&] { return updateNetworks(session, before, options); });
  if (!c.output.empty()) c.files.write(c.output, done.calibration);
  const LedgerEntry& step = done.calibration.ledger.back();
  if (step.heldOutAfter > step.heldOutBefore)
    warn(
        "in block cross-validation the updated networks are worse than the old ones; this kind of network "
        "does not fit the new session: keep " +
        c.calibration + ", or train on both sessions with the network that predicts best (network: auto)");
  if (c.json) {
    std::cout << changeJson(done.result, done.calibration.ledger) << '\n';
    return;
  }
  std::cout << ledgerText(done.calibration, !std::isfinite(done.result.figures.rms));
  for (const LearnedNetwork& n : done.calibration.networks) std::cout << "  " << n.summary << '\n';
  if (!c.output.empty()) std::cout << "\nwritten to " << c.output << '\n';
}

}  // namespace

void addUpdateCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<UpdateOptions>(
      app, exitStatus, runUpdate, "update",
      "Train the thermal networks of a calibration with a new session; change nothing else");
  c.declare(command, "the new session");
  command.add_option("-o,--output", c.output, "the new calibration file");
  c.files.declare(command);
  c.fit.declare(command, false);
  command.footer(
      "The training data in the file are kept, and the networks are trained on old and new data together.\n"
      "mm add and mm remove refit everything, networks included, to their session alone.\n"
      "Example:\n"
      "  mm update tuesday.bag --calibration monday.yaml -o both.yaml");
}

}  // namespace mm
