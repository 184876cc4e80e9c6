#pragma once
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

namespace mm {

// One function a subcommand of `mm`, each in a file of its own: it declares the options and, when the
// subcommand is the one that was typed, does the work from the callback of CLI11. Bad input is thrown
// (InputError, NumericalError); a result whose answer is no sets `exitStatus` to 1.

/// Adds a subcommand, and what it is given. When it is typed, `run` does its work; what that returns, if
/// anything, is the exit status.
template <typename Given, typename Run>
std::pair<Given&, CLI::App&> addCommand(CLI::App& app, int& exitStatus, const Run& run,
                                        const std::string& name, const std::string& description) {
  const auto given = std::make_shared<Given>();
  CLI::App& command = *app.add_subcommand(name, description);
  command.callback([given, run, &exitStatus] {
    if constexpr (std::is_void_v<decltype(run(*given))>)
      run(*given);
    else
      exitStatus = run(*given);
  });
  return {*given, command};
}

/// Each adds its subcommand, which sets `exitStatus` and throws mm::Error for bad input.
void addImportCommand(CLI::App& app, int& exitStatus);
void addSensorsCommand(CLI::App& app, int& exitStatus);
void addSimulateCommand(CLI::App& app, int& exitStatus);
void addCheckCommand(CLI::App& app, int& exitStatus);
void addCalibrateCommand(CLI::App& app, int& exitStatus);
void addCompareCommand(CLI::App& app, int& exitStatus);
void addDiagnoseCommand(CLI::App& app, int& exitStatus);
void addAddCommand(CLI::App& app, int& exitStatus);
void addRemoveCommand(CLI::App& app, int& exitStatus);
void addUpdateCommand(CLI::App& app, int& exitStatus);
void addVerifyCommand(CLI::App& app, int& exitStatus);
void addReportCommand(CLI::App& app, int& exitStatus);
void addApplyCommand(CLI::App& app, int& exitStatus);
void addUncertaintyCommand(CLI::App& app, int& exitStatus);
void addCertificateCommand(CLI::App& app, int& exitStatus);
void addArtifactCommand(CLI::App& app, int& exitStatus);
void addExportCommand(CLI::App& app, int& exitStatus);
void addHistoryCommand(CLI::App& app, int& exitStatus);
void addPromoteCommand(CLI::App& app, int& exitStatus);
void addRollbackCommand(CLI::App& app, int& exitStatus);
void addMachineCommand(CLI::App& app, int& exitStatus);
void addPlanCommand(CLI::App& app, int& exitStatus);
void addPlanVerifyCommand(CLI::App& plan, int& exitStatus);  ///< of `plan`
void addCompletionCommand(CLI::App& app, int& exitStatus);
void addManualCommand(CLI::App& app, int& exitStatus);
void addEffectsCommand(CLI::App& app, int& exitStatus);
void addWorkbenchCommand(CLI::App& app, int& exitStatus);
void addBatchCommand(CLI::App& app, int& exitStatus);
void addFleetCommand(CLI::App& app, int& exitStatus);

}  // namespace mm
