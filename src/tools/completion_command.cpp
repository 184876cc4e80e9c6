#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/error.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/version.h"
#include "tools/command_line.h"
#include "tools/commands.h"

namespace mm {

void addCompletionCommand(CLI::App& app, int& /*exitStatus*/) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("completion", "Print the shell completion script of mm");
  command->add_option("shell", *shell, "the shell")->required()->check(CLI::IsMember({"bash", "zsh"}));
  command->footer(
      "Installed with the package. Without installing it:\n"
      "  source <(mm completion bash)\n"
      "  source <(mm completion zsh)       # after compinit");
  command->callback(
      [&app, shell] { std::cout << (*shell == "bash" ? bashCompletion(app) : zshCompletion(app)); });
}

void addManualCommand(CLI::App& app, int& /*exitStatus*/) {
  auto name = std::make_shared<std::vector<std::string>>();
  auto list = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("manual", "Print a manual page for man");
  command->add_option("command", *name, "the command; without one, the page of mm itself")->expected(0, 2);
  command->add_flag("--list", *list, "list the commands that have a page");
  command->footer("Installed with the package. Without installing it:\n  mm manual calibrate | man -l -");
  command->callback([&app, name, list] {
    const std::vector<Command> commands = commandsOf(app);
    const std::string wanted = joined(*name, " ");
    for (const Command& c : commands) {
      if (*list) std::cout << c.name << '\n';
      if (!*list && c.name == wanted) std::cout << manualPage(c, kVersion);
      if (c.name == wanted) return;
    }
    if (*list) return;
    if (!wanted.empty())
      throw InputError("'" + wanted + "' is not a command of mm" + didYouMean(wanted, allNames(commands)) +
                       " (mm manual --list lists them)");
    std::cout << manualPage(app, kVersion);
  });
}

}  // namespace mm
