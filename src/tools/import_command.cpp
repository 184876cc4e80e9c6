#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "base/units.h"
#include "session/artifact_file.h"
#include "session/contacts_csv.h"
#include "session/session_summary.h"
#include "tools/commands.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

struct ImportOptions {
  std::string csv, artifact, machine, output;
  OutputFiles files;
};

void runImport(ImportOptions& options) {
  options.files.input(options.csv);
  options.files.input(options.artifact);
  options.files.input(options.machine);
  options.files.bag("-o", options.output,
                    "imported from " + std::filesystem::path(options.csv).filename().string());
  options.files.check();
  const Machine machine = Machine::load(options.machine);
  std::optional<Artifact> artifact;
  if (!options.artifact.empty()) artifact = loadArtifact(options.artifact);
  std::optional<Session> session;
  {
    ProgressBar bar("reading");
    session = readContactsCsv(options.csv, machine, artifact ? &*artifact : nullptr, bar.callback());
  }
  {
    ProgressBar bar("writing");
    options.files.write(options.output, *session, bar.callback());
  }
  std::cout << summarize(*session) << "written to " << options.output << '\n';
}

}  // namespace

void addImportCommand(CLI::App& app, int& /*exitStatus*/) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* command =
      app.add_subcommand("import", "A CSV of contacts or of an instrument's readings to a session bag");
  command->add_option("csv", options->csv, "the measurements: one row each, columns by name with their unit")
      ->required();
  command->add_option("--artifact", options->artifact,
                      "YAML: balls and points, the probe (needed for contacts)");
  command->add_option("--machine", options->machine, "three_axis, five_axis or the path of a URDF")
      ->required();
  command->add_option("-o,--output", options->output, "the session's bag")->required();
  options->files.declare(*command);
  command->footer(
      "Columns (any order, empty cells are not measured):\n"
      "  time_s                        required\n"
      "  <joint>_mm, <joint>_deg       readings; a joint without a column stays at 0\n"
      "  <joint>_velocity_mm_s, _deg_s direction of travel at the contact (without any, it is assumed: from "
      "the\n"
      "                                approach at a touch, from the order of positions at other readings)\n"
      "  reading_mm                    laser\n"
      "  feature                       ball or point of the artifact; or, instead of it:\n"
      "  reference_x_mm, _y_mm, _z_mm  true position by an independent instrument\n"
      "  deviation_<joint>_um, _arcsec true minus indicated; weights deviation_<joint>_std_um, _std_arcsec\n"
      "  setup                         rows of one setup share an unknown zero\n"
      "  <sensor>_degC, <name>_<unit>  temperatures and any other covariate\n"
      "Examples:\n"
      "  mm import contacts.csv --artifact plate.yaml --machine three_axis -o plate.bag\n"
      "  mm import interferometer_x.csv --machine three_axis -o x.bag");
  command->callback([options] { runImport(*options); });
}

}  // namespace mm
