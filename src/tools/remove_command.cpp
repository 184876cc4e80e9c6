#include <CLI/CLI.hpp>

#include "tools/change_command.h"
#include "tools/commands.h"

namespace mm {

void addRemoveCommand(CLI::App& app, int& exitStatus) {
  declareChange(
      *app.add_subcommand("remove", "One effect less: everything is refitted, the ledger tells what it did"),
      removeEffect, false,
      "mm remove plate.bag --calibration plate2.yaml '{type: backlash, axis: x}' -o plate3.yaml", exitStatus);
}

}  // namespace mm
