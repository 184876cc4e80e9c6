#include <CLI/CLI.hpp>
#include <string>

#include "base/version.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/program.h"

namespace mm {
namespace {

void addCommands(CLI::App& app, int& exitStatus) {
  for (const auto add :
       {addImportCommand,    addSensorsCommand,     addSimulateCommand,    addCheckCommand,
        addCalibrateCommand, addCompareCommand,     addDiagnoseCommand,    addAddCommand,
        addRemoveCommand,    addUpdateCommand,      addVerifyCommand,      addReportCommand,
        addApplyCommand,     addUncertaintyCommand, addCertificateCommand, addArtifactCommand,
        addExportCommand,    addHistoryCommand,     addPromoteCommand,     addRollbackCommand,
        addEffectsCommand,   addMachineCommand,     addPlanCommand,        addWorkbenchCommand,
        addBatchCommand,     addFleetCommand,       addCompletionCommand,  addManualCommand})
    add(app, exitStatus);
}

}  // namespace
}  // namespace mm

int main(int argc, char** argv) {
  CLI::App app{"Calibrate a measuring machine and find the physical effect that its model lacks.", "mm"};
  app.set_version_flag("--version", std::string("mm ") + mm::kVersion);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  int exitStatus = mm::kDone;
  mm::addCommands(app, exitStatus);  // before the footer, which they would have, too
  app.footer(
      "Make a session:  mm import contacts.csv --artifact artifact.yaml --machine three_axis -o session.bag\n"
      "Help on a command: mm import --help\n" +
      std::string(mm::kExitStatusHelp));
  return mm::runProgram(app, exitStatus, argc, argv);
}
