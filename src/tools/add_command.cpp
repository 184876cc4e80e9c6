#include <CLI/CLI.hpp>

#include "tools/change_command.h"
#include "tools/commands.h"

namespace mm {

void addAddCommand(CLI::App& app, int& exitStatus) {
  declareChange(
      *app.add_subcommand("add",
                          "Add an effect to the model, refit everything and record the result in the ledger"),
      addEffect, true,
      "mm add plate.bag --calibration plate.yaml '{type: backlash, axis: x}' -o plate2.yaml\n"
      "  mm add plate.bag --calibration plate.yaml --all -o plate9.yaml",
      exitStatus);
}

}  // namespace mm
