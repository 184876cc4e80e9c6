#include <glog/logging.h>
#include <ros/console.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/nearest_name.h"
#include "ros_bridge/effect_plugins.h"
#include "tools/commands.h"
#include "tools/one_line.h"

namespace {

constexpr int kDone = 0;        // also: help and version
constexpr int kAnswerIsNo = 1;  // not converged, a parameter lost, cancelled: the output is still written
constexpr int kBadInput = 2;    // bad input or usage

int fail(int status, const std::string& message) {
  std::cerr << "mm: error: " << mm::oneLine(message) << std::endl;
  return status;
}

/// What CLI11 found wrong with the command line; a word that is no subcommand is named.
std::string usageError(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands(nullptr)) commands.push_back(command->get_name());
  const std::string word = argc > 1 ? argv[1] : "-";
  if (word.rfind('-', 0) != 0 && std::find(commands.begin(), commands.end(), word) == commands.end())
    return "'" + word + "' is not a command of mm" + mm::didYouMean(word, commands) +
           " (mm --help lists them)";
  const bool known = word.rfind('-', 0) != 0;
  return std::string(error.what()) + "; see mm " + (known ? word + " " : "") + "--help";
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ,
              SIG_IGN);  // a file-size limit then fails the write, which is reported, instead of killing
  // What the solver has to say of a step that it could not take is in the result.
  FLAGS_minloglevel = google::GLOG_FATAL;
  // What the URDF's parser has to say is in the exception; standard error keeps its one line.
  if (ros::console::set_logger_level(ROSCONSOLE_ROOT_LOGGER_NAME, ros::console::levels::Fatal))
    ros::console::notifyLoggerLevelsChanged();
  CLI::App app{"Calibrates a measuring machine and finds the physical effect that its model misses.", "mm"};
  app.set_version_flag("--version", "mm " MM_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "A session:  mm import contacts.csv --artifact artifact.yaml --machine three_axis -o session.bag\n"
      "Each subcommand explains itself: mm import --help");
  int exitStatus = kDone;
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
  mm::addReportCommand(app, exitStatus);
  mm::addApplyCommand(app, exitStatus);
  mm::addHistoryCommand(app, exitStatus);
  mm::addPromoteCommand(app, exitStatus);
  mm::addRollbackCommand(app, exitStatus);
  mm::addBenchmarkCommand(app, exitStatus);
  // Before the command's own work, and not for --help.
  app.parse_complete_callback([] {
    mm::loadEffectPlugins(
        [](const std::string& line) { std::cerr << "mm: warning: " << mm::oneLine(line) << std::endl; });
  });
  try {
    app.parse(argc, argv);
    std::cout.flush();
    if (!std::cout) return fail(kBadInput, "standard output cannot be written; is the disk full?");
    return exitStatus;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return fail(kBadInput, usageError(app, e, argc, argv));
  } catch (const mm::InputError& e) {
    return fail(kBadInput, e.what());
  } catch (const mm::Error& e) {  // NumericalError, Cancelled
    return fail(kAnswerIsNo, e.what());
  } catch (const std::exception& e) {
    return fail(kBadInput, std::string("unexpected: ") + e.what());
  }
}
