#include <iostream>

#include "fleet/fleet.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/output_files.h"

namespace mm {
namespace {

struct FleetCommand {
  std::string folder, page;
  FleetOptions options;
  OutputFiles files;
  bool json = false, csv = false;
};

void runFleet(FleetCommand& c) {
  c.files.output("-o", c.page, FileKind::kPage);
  c.files.check();
  const bool one = !c.options.machine.empty() || !c.options.parameter.empty();
  const Fleet fleet = loadFleet(c.folder, c.options);
  if (!c.page.empty()) c.files.write(c.page, fleetPage(fleet));
  if (c.csv)
    std::cout << fleetCsv(fleet);
  else if (c.json)
    std::cout << fleetJson(fleet, one) << '\n';
  else
    std::cout << fleetText(fleet) << (c.page.empty() ? "" : "written to " + c.page + "\n");
}

}  // namespace

void addFleetCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<FleetCommand>(
      app, exitStatus, runFleet, "fleet",
      "Analyse many machines over time: find changes, drifts, outliers and recurring effects");
  command
      .add_option("folder", c.folder, "results of mm batch, or calibrations: a store, or a folder of stores")
      ->required();
  command.add_option("--machine", c.options.machine, "show findings and values of this machine only");
  command.add_option("--parameter", c.options.parameter,
                     "show quantities whose name contains this: 'backlash, axis: x'");
  command.add_option("--model", c.options.model,
                     "use jobs whose model path contains this (default: the most used model)");
  standardOption(command, "--alarm", c.options.alarm, numberWithin(1e-12, 0.5),
                 "false alarm probability of the whole fleet");
  command.add_option("-o,--output", c.page, "HTML page with every machine over time");
  CLI::Option* json =
      command.add_flag("--json", c.json, "print as JSON; with --machine or --parameter every value");
  command.add_flag("--csv", c.csv, "print every parameter of every session as CSV")->excludes(json);
  c.files.declare(command);
  command.footer(
      "Tests each series for steps and drifts and compares each machine with the others of its type; the "
      "false\n"
      "alarm probability is shared among all tests.\n"
      "Examples:\n"
      "  mm fleet results -o fleet.html\n"
      "  mm fleet ~/.measuring_machine/calibrations --parameter backlash --json");
}

}  // namespace mm
