#include <glog/logging.h>
#include <ros/console.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/version.h"
#include "ros_bridge/effect_plugins.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/one_line.h"
#include "tools/output_files.h"

namespace {

using mm::kAnswerIsNo, mm::kBadInput, mm::kDone, mm::kStopped;

int fail(int status, const std::string& message) {
  std::cerr << "mm: error: " << mm::oneLine(message) << std::endl;
  return status;
}

/// One line that says what is left of the work.
int stopped() {
  std::string files;
  for (const std::string& file : mm::OutputFiles::written()) files += (files.empty() ? "" : ", ") + file;
  std::cerr << "mm: stopped by Ctrl-C; " << (files.empty() ? "nothing was written" : "written: " + files)
            << std::endl;
  return kStopped;
}

/// `mm plan old`: a command that only has commands of its own, and a word that is none of them; else empty.
std::string unknownSecondWord(const CLI::App& app, int argc, char** argv) {
  if (argc < 3 || argv[2][0] == '-') return {};
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() != argv[1]) continue;
    std::vector<std::string> own;
    for (const CLI::App* sub : command->get_subcommands(nullptr)) own.push_back(sub->get_name());
    if (own.empty() || std::find(own.begin(), own.end(), argv[2]) != own.end()) return {};
    return "'" + std::string(argv[2]) + "' is not a command of mm " + argv[1] + mm::didYouMean(argv[2], own) +
           " (mm " + argv[1] + " --help lists them)";
  }
  return {};
}

/// An option that the command does not have, before anything that is missing because of it; empty: none.
std::string unknownOption(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = &app;
  std::string name = "mm";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") return {};
    if (word.rfind("--", 0) != 0) {
      const auto subs = command->get_subcommands(nullptr);
      const auto sub =
          std::find_if(subs.begin(), subs.end(), [&](const CLI::App* s) { return s->get_name() == word; });
      if (sub != subs.end()) command = *sub, name += " " + word;
      continue;
    }
    const std::string option = word.substr(0, word.find('='));
    std::vector<std::string> known;
    for (const CLI::Option* o : command->get_options())
      for (const std::string& l : o->get_lnames()) known.push_back("--" + l);
    if (std::find(known.begin(), known.end(), option) == known.end())
      return "'" + option + "' is no option of " + name + mm::didYouMean(option, known) + " (" + name +
             " --help lists them)";
  }
  return {};
}

/// What CLI11 found wrong with the command line; a word that is no subcommand is named.
std::string usageError(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands(nullptr)) commands.push_back(command->get_name());
  const std::string word = argc > 1 ? argv[1] : "-";
  if (word.rfind('-', 0) != 0 && std::find(commands.begin(), commands.end(), word) == commands.end())
    return "'" + word + "' is not a command of mm" + mm::didYouMean(word, commands) +
           " (mm --help lists them)";
  if (const std::string wrong = unknownSecondWord(app, argc, argv); !wrong.empty()) return wrong;
  if (const std::string wrong = unknownOption(app, argc, argv); !wrong.empty()) return wrong;
  const bool known = word.rfind('-', 0) != 0;
  return std::string(error.what()) + "; see mm " + (known ? word + " " : "") + "--help";
}

void addExitStatus(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands(nullptr)) {
    const std::string footer = command->get_footer();
    if (command->get_subcommands(nullptr).empty())
      command->footer(footer + (footer.empty() ? "" : "\n") + mm::kExitStatusHelp);
    addExitStatus(*command);
  }
}

/// mm as it is typed; the steps of a batch are typed by the program itself.
int run(int argc, char** argv) {
  std::signal(SIGXFSZ,
              SIG_IGN);  // a file-size limit then fails the write, which is reported, instead of killing
  // What the solver has to say of a step that it could not take is in the result.
  FLAGS_minloglevel = google::GLOG_FATAL;
  // What the URDF's parser has to say is in the exception; standard error keeps its one line.
  if (ros::console::set_logger_level(ROSCONSOLE_ROOT_LOGGER_NAME, ros::console::levels::Fatal))
    ros::console::notifyLoggerLevelsChanged();
  CLI::App app{"Calibrates a measuring machine and finds the physical effect that its model misses.", "mm"};
  app.set_version_flag("--version", std::string("mm ") + mm::kVersion);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "A session:  mm import contacts.csv --artifact artifact.yaml --machine three_axis -o session.bag\n"
      "Each subcommand explains itself: mm import --help\n" +
      std::string(mm::kExitStatusHelp));
  int exitStatus = kDone;
  const mm::Interrupt interrupt;
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
  mm::addBenchmarkCommand(app, exitStatus);
  mm::addBatchCommand(app, exitStatus, run);
  mm::addFleetCommand(app, exitStatus);
  mm::addCompletionCommand(app, exitStatus);
  mm::addManualCommand(app, exitStatus);
  addExitStatus(app);
  // Before the command's own work, and not for --help.
  app.parse_complete_callback([] {
    static bool loaded = false;  // a step of a batch inherits what the batch has loaded
    if (std::exchange(loaded, true)) return;
    mm::loadEffectPlugins(
        [](const std::string& line) { std::cerr << "mm: warning: " << mm::oneLine(line) << std::endl; });
  });
  try {
    app.parse(argc, argv);
    std::cout.flush();
    if (!std::cout) return fail(kBadInput, "standard output cannot be written; is the disk full?");
    return mm::Interrupt::asked() && exitStatus != kStopped ? stopped() : exitStatus;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return fail(kBadInput, usageError(app, e, argc, argv));
  } catch (const mm::Cancelled&) {
    return stopped();
  } catch (const mm::InputError& e) {
    if (mm::Interrupt::asked()) return stopped();  // a read that was woken by Ctrl-C
    return fail(kBadInput, e.what());
  } catch (const mm::Error& e) {  // NumericalError
    return fail(kAnswerIsNo, e.what());
  } catch (const std::exception& e) {
    return fail(kBadInput, std::string("unexpected: ") + e.what());
  }
}

}  // namespace

int main(int argc, char** argv) { return run(argc, argv); }
