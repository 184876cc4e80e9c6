#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace mm {

/// The command line as its definition holds it, for completion scripts and manual pages.
struct CommandOption {
  std::vector<std::string> names;  // "-o", "--output"; empty: a positional, told by its place
  std::string placeholder;         // "TEXT", or the name of a positional
  std::string description, standard, group;
  std::string bounds;              // "0 to 10"; empty: none are stated
  std::vector<std::string> words;  // that it takes, and no others; empty: anything, a file most likely
  std::vector<std::string> known;  // words that it takes beside others: machines, methods, effects
  std::string ending;              // of the files that it takes, "bag"; empty: any
  bool takesValue = false, required = false;
};

struct Command {
  std::string name;  // "calibrate", "machine new"
  std::string description, footer;
  std::vector<CommandOption> options, positionals;
};

/// Every command that can be typed, in the order of --help; one that only has commands of its own is told by
/// these.
std::vector<Command> commandsOf(const CLI::App& app);
/// What stands before every command: --help, --version.
std::vector<CommandOption> commonOptions(const CLI::App& app);

/// Completion of commands, options and of the values that an option takes: its words, else files.
std::string bashCompletion(const CLI::App& app);
std::string zshCompletion(const CLI::App& app);

/// A page of section 1 (troff, man macros). @param version of the package.
std::string manualPage(const CLI::App& app, const std::string& version);
std::string manualPage(const Command& command, const std::string& version);

}  // namespace mm
