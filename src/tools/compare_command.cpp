#include <iostream>

#include "calibration_file/calibration_yaml.h"
#include "design/session_doubts.h"
#include "report/json.h"
#include "report/text.h"
#include "tools/commands.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "workflow/learning.h"

namespace mm {
namespace {

void runCompare(const SessionAndCalibration& c) {
  CalibrateOptions options = c.fit.checked();
  const Calibration calibration = loadCalibration(c.calibration);
  const Session session = loadSession(c.bags.joined(), calibration, c.fit.space);
  const Comparison compared =
      withBar("comparing", options, [&] { return compareWith(session, calibration, options); });
  warn(repeatabilityDoubts(compared.fit));
  std::cout << (c.json ? compareJson(compared.fit, compared.where) + "\n"
                       : compareText(compared.fit, compared.where));
}

}  // namespace

void addCompareCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<SessionAndCalibration>(
      app, exitStatus, runCompare, "compare", "Compare a calibration with a session and show where it fails");
  c.declare(command, "the session, or several to evaluate together");
  c.fit.declare(command, false);
  command.footer(
      "The parameters of the calibration are held; only those of the session (pose of the artifact, free "
      "centres,\n"
      "zeros of setups) are fitted.\n"
      "Example:\n"
      "  mm compare plate.bag --calibration plate.yaml");
}

}  // namespace mm
