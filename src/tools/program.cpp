#include "tools/program.h"

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
#include "base/text.h"
#include "ros_bridge/effect_plugins.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/one_line.h"
#include "tools/output_files.h"

namespace mm {
namespace {

int fail(const CLI::App& app, int status, const std::string& message) {
  std::cerr << app.get_name() << ": error: " << oneLine(message) << std::endl;
  return status;
}

/// One line that says what is left of the work.
int stopped(const CLI::App& app) {
  const std::string files = joined(OutputFiles::written(), ", ");
  std::cerr << app.get_name() << ": stopped by Ctrl-C; "
            << (files.empty() ? "nothing was written" : "written: " + files) << std::endl;
  return kStopped;
}

/// What is wrong with a word that is none of those that are known; empty: it is one of them.
/// @param what "a command". @param of whose they are, as it is typed.
std::string unknown(const std::string& word, const std::string& what, const std::string& of,
                    const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), word) != known.end()) return {};
  return "'" + word + "' is not " + what + " of " + of + didYouMean(word, known) + " (" + of +
         " --help lists them)";
}

/// `mm plan old`: a word in the place of a command that is none; else empty.
std::string unknownCommand(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = &app;
  std::string name = app.get_name();
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    std::vector<std::string> own;
    for (const CLI::App* sub : command->get_subcommands(nullptr)) own.push_back(sub->get_name());
    if (own.empty()) return {};
    if (const std::string wrong = unknown(argv[i], "a command", name, own); !wrong.empty()) return wrong;
    command = command->get_subcommand(argv[i]);
    name += std::string(" ") + argv[i];
  }
  return {};
}

/// An option that the command does not have, before anything that is missing because of it; empty: none.
std::string unknownOption(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = &app;
  std::string name = app.get_name();
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
    if (const std::string wrong = unknown(option, "an option", name, known); !wrong.empty()) return wrong;
  }
  return {};
}

/// What CLI11 found wrong with the command line; a word that is no subcommand is named.
std::string usageError(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  if (const std::string wrong = unknownCommand(app, argc, argv); !wrong.empty()) return wrong;
  if (const std::string wrong = unknownOption(app, argc, argv); !wrong.empty()) return wrong;
  const bool command = !app.get_subcommands(nullptr).empty() && argc > 1 && argv[1][0] != '-';
  return std::string(error.what()) + "; see " + app.get_name() +
         (command ? " " + std::string(argv[1]) : std::string()) + " --help";
}

void addExitStatus(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands(nullptr)) {
    const std::string footer = command->get_footer();
    if (command->get_subcommands(nullptr).empty())
      command->footer(footer + (footer.empty() ? "" : "\n") + kExitStatusHelp);
    addExitStatus(*command);
  }
}

}  // namespace

int runProgram(CLI::App& app, const int& exitStatus, int argc, char** argv) {
  std::signal(SIGXFSZ,
              SIG_IGN);  // a file-size limit then fails the write, which is reported, instead of killing
  // What the solver has to say of a step that it could not take is in the result.
  FLAGS_minloglevel = google::GLOG_FATAL;
  // What the URDF's parser has to say is in the exception; standard error keeps its one line.
  if (ros::console::set_logger_level(ROSCONSOLE_ROOT_LOGGER_NAME, ros::console::levels::Fatal))
    ros::console::notifyLoggerLevelsChanged();
  const Interrupt interrupt;
  addExitStatus(app);
  // Before the command's own work, and not for --help.
  app.parse_complete_callback([&app] {
    static bool loaded = false;  // a step of a batch inherits what the batch has loaded
    if (std::exchange(loaded, true)) return;
    loadEffectPlugins([&app](const std::string& line) {
      std::cerr << app.get_name() << ": warning: " << oneLine(line) << std::endl;
    });
  });
  try {
    app.parse(argc, argv);
    std::cout.flush();
    if (!std::cout) return fail(app, kBadInput, "standard output cannot be written; is the disk full?");
    return Interrupt::asked() && exitStatus != kStopped ? stopped(app) : exitStatus;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return fail(app, kBadInput, usageError(app, e, argc, argv));
  } catch (const Cancelled&) {
    return stopped(app);
  } catch (const InputError& e) {
    if (Interrupt::asked()) return stopped(app);  // a read that was woken by Ctrl-C
    return fail(app, kBadInput, e.what());
  } catch (const Error& e) {  // NumericalError
    return fail(app, kAnswerIsNo, e.what());
  } catch (const std::exception& e) {
    return fail(app, kBadInput, std::string("unexpected: ") + e.what());
  }
}

}  // namespace mm
