#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "fleet/fleet.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/output_files.h"

namespace mm {
namespace {

struct FleetCommand {
  std::string folder, page;
  FleetOptions options;
  OutputFiles files;
  bool json = false, csv = false;
};

void run(const FleetCommand& c) {
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
  auto c = std::make_shared<FleetCommand>();
  CLI::App* command =
      app.add_subcommand("fleet", "Many machines over time: what changed, drifts, differs, came back");
  command
      ->add_option("folder", c->folder,
                   "results of mm batch, or calibrations: a store, or a folder of stores")
      ->required();
  command->add_option("--machine", c->options.machine, "findings and values of this machine only");
  command->add_option("--parameter", c->options.parameter,
                      "quantities with this in their name: 'backlash, axis: x'");
  command->add_option("--model", c->options.model,
                      "jobs with this in the path of their model (default: the most used)");
  command
      ->add_option("--alarm", c->options.alarm,
                   "chance that a fleet in which nothing happens gives any finding")
      ->capture_default_str()
      ->check(numberWithin(1e-12, 0.5));
  command->add_option("-o,--output", c->page, "a page with every machine over time, for a browser");
  CLI::Option* json =
      command->add_flag("--json", c->json, "as JSON; with --machine or --parameter every value");
  command->add_flag("--csv", c->csv, "every parameter of every session as CSV")->excludes(json);
  c->files.declare(*command);
  command->footer(
      "Each series is asked for steps and drifts, each machine is compared with its sisters; the chance of a "
      "false\n"
      "alarm is shared among all questions.\n"
      "Examples:\n  mm fleet results -o fleet.html\n  mm fleet ~/.measuring_machine/calibrations --parameter "
      "backlash --json");
  command->callback([c, &exitStatus] {
    c->files.output("-o", c->page, FileKind::kPage);
    c->files.check();
    run(*c);
    exitStatus = kDone;
  });
}

}  // namespace mm
