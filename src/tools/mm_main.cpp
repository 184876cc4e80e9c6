#include <CLI/CLI.hpp>
#include <string>

#include "base/version.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/program.h"

int main(int argc, char** argv) {
  CLI::App app{"Calibrate a measuring machine and find the physical effect that its model lacks.", "mm"};
  app.set_version_flag("--version", std::string("mm ") + mm::kVersion);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "Make a session:  mm import contacts.csv --artifact artifact.yaml --machine three_axis -o session.bag\n"
      "Help on a command: mm import --help\n" +
      std::string(mm::kExitStatusHelp));
  int exitStatus = mm::kDone;
  mm::addImportCommand(app, exitStatus);
  mm::addSensorsCommand(app, exitStatus);
  mm::addSimulateCommand(app, exitStatus);
  mm::addCheckCommand(app, exitStatus);
  mm::addCalibrateCommand(app, exitStatus);
  mm::addCompareCommand(app, exitStatus);
  mm::addDiagnoseCommand(app, exitStatus);
  mm::addAddCommand(app, exitStatus);
  mm::addRemoveCommand(app, exitStatus);
  mm::addUpdateCommand(app, exitStatus);
  mm::addVerifyCommand(app, exitStatus);
  mm::addReportCommand(app, exitStatus);
  mm::addApplyCommand(app, exitStatus);
  mm::addUncertaintyCommand(app, exitStatus);
  mm::addCertificateCommand(app, exitStatus);
  mm::addArtifactCommand(app, exitStatus);
  mm::addExportCommand(app, exitStatus);
  mm::addHistoryCommand(app, exitStatus);
  mm::addPromoteCommand(app, exitStatus);
  mm::addRollbackCommand(app, exitStatus);
  mm::addEffectsCommand(app, exitStatus);
  mm::addMachineCommand(app, exitStatus);
  mm::addPlanCommand(app, exitStatus);
  mm::addWorkbenchCommand(app, exitStatus);
  mm::addBatchCommand(app, exitStatus);
  mm::addFleetCommand(app, exitStatus);
  mm::addCompletionCommand(app, exitStatus);
  mm::addManualCommand(app, exitStatus);
  return mm::runProgram(app, exitStatus, argc, argv);
}
