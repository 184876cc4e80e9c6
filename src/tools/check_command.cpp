#include <iostream>
#include <optional>

#include "design/point_set.h"
#include "tools/commands.h"
#include "tools/session_input.h"

namespace mm {
namespace {

struct CheckCommand {
  Bags bags;
  std::string model, space;
  bool json = false;
};

int runCheck(const CheckCommand& c) {
  std::optional<ModelSpec> model;
  if (!c.model.empty()) model = loadModelSpec(c.model);
  const Session session = model ? loadSession(c.bags.joined(), *model, c.model, c.space)
                                : loadSession(c.bags.joined(), nullptr, c.space);
  const PointSet set = checkPointSet(session, model ? &*model : nullptr);
  std::cout << (c.json ? pointSetJson(set) + "\n" : pointSetText(set));
  return set.hasModel && set.identifiability.incomplete() ? 1 : 0;
}

}  // namespace

void addCheckCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<CheckCommand>(app, exitStatus, runCheck, "check",
                                               "Check coverage and identifiability before fitting");
  c.bags.declare(command);
  command.add_option("--model", c.model, "model file: also report which of its parameters can be determined");
  declareNamespace(command, c.space);
  command.add_flag("--json", c.json, "print the result as JSON on standard output");
  command.footer(
      "Exit status 1: the session does not determine a parameter of the model that no convention fixes.\n"
      "Example:\n"
      "  mm check plate.bag --model model.yaml");
}

}  // namespace mm
