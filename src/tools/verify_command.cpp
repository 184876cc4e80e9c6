#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <optional>

#include "calibration_file/calibration_yaml.h"
#include "report/verify_json.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "verification/verify.h"

namespace mm {
namespace {

struct VerifyCommand : SessionAndCalibration {
  bool loaded = false;
};

int runVerify(const VerifyCommand& c) {
  VerifyOptions options;
  options.loaded = c.loaded;
  options.calibrate = c.fit.checked();
  const Calibration calibration = loadCalibration(c.calibration);
  const Session session = loadSession(c.bag, calibration, c.fit.space);
  std::optional<Verification> found;
  {
    ProgressBar bar("verifying");
    options.calibrate.progress = [&](const std::string& stage, double share) { bar.show(share, stage); };
    found = verify(session, calibration, options);
  }
  std::cout << (c.json ? verifyJson(*found) + "\n" : verifyText(*found));
  return found->verdict == VerifyVerdict::kHelped ? kDone : kAnswerIsNo;
}

}  // namespace

void addVerifyCommand(CLI::App& app, int& exitStatus) {
  auto c = std::make_shared<VerifyCommand>();
  CLI::App* command =
      app.add_subcommand("verify", "Did the correction help? Says so from a few fresh points");
  c->declare(*command, "the fresh session: ten places that were not used for the calibration are enough");
  command->add_flag("--loaded", c->loaded, "the controller corrected while the session was measured");
  c->fit.declare(*command, false);
  command->footer(
      "Nothing of the calibration is refitted. With --loaded the readings should be free of error; without,\n"
      "they are raw, and the correction should take their error away. The answer names a table that is not\n"
      "loaded, has the wrong sign or stands at another axis, and what changed since the calibration.\n"
      "Examples:\n  mm plan verify plan.yaml --calibration c.yaml -o verify.yaml\n"
      "  mm verify fresh.bag --calibration c.yaml --loaded");
  command->callback([c, &exitStatus] { exitStatus = runVerify(*c); });
}

}  // namespace mm
