#include <CLI/CLI.hpp>

#include "tools/change_command.h"
#include "tools/commands.h"

namespace mm {

void addRemoveCommand(CLI::App& app, int& exitStatus) {
  declareChange(
      *app.add_subcommand(
          "remove", "Remove an effect from the model, refit everything and record the result in the ledger"),
      removeEffect, false,
      "mm remove plate.bag --calibration plate2.yaml '{type: backlash, axis: x}' -o plate3.yaml", exitStatus);
}

}  // namespace mm
