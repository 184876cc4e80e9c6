#include <iostream>

#include "calibration_file/calibration_yaml.h"
#include "design/moves.h"
#include "design/session_doubts.h"
#include "report/json.h"
#include "report/text.h"
#include "tools/commands.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "workflow/learning.h"

namespace mm {
namespace {

struct DiagnoseCommand : SessionAndCalibration {
  std::string moves;
  OutputFiles files;
};

void runDiagnose(DiagnoseCommand& c) {
  c.files.input(c.bags.paths);
  c.files.input(c.calibration);
  c.files.output("--moves", c.moves, FileKind::kMoves);
  c.files.check();
  DiagnoseOptions options = diagnosing(c.fit.checked());
  const Calibration calibration = loadCalibration(c.calibration);
  const Session session = loadSession(c.bags.joined(), calibration, c.fit.space);
  askFirst(session);
  const Diagnosis diagnosis =
      withBar("diagnosing", options, [&] { return diagnoseCalibration(session, calibration, options); });
  warn(repeatabilityDoubts(diagnosis.base));
  if (!c.moves.empty()) {
    const std::string plan = movesYaml(diagnosis.nextMeasurement, session);
    if (!plan.empty()) c.files.write(c.moves, plan);
    std::cerr << (plan.empty() ? "no moves are proposed: " + c.moves + " is not written\n"
                               : "moves written to " + c.moves + "\n");
  }
  std::cout << (c.json ? diagnoseJson(diagnosis) + "\n"
                       : diagnoseText(diagnosis, c.bags.joined(), c.calibration));
}

}  // namespace

void addDiagnoseCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<DiagnoseCommand>(app, exitStatus, runDiagnose, "diagnose",
                                                  "Find the physical effect that the model lacks");
  c.declare(command, "the session, or several to evaluate together");
  command.add_option("--moves", c.moves,
                     "write the proposed moves as a plan for mm simulate and the node measure");
  c.files.declare(command);
  c.fit.declare(command, true);
  command.footer("Example:\n  mm diagnose plate.bag --calibration plate.yaml");
}

}  // namespace mm
