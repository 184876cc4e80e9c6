#include <filesystem>
#include <iostream>
#include <optional>

#include "base/cancel_scope.h"
#include "base/json_text.h"
#include "import/import_format.h"
#include "import/import_preview.h"
#include "interpreters/loaded_compensation.h"
#include "session/artifact_file.h"
#include "tools/commands.h"
#include "tools/interrupt.h"
#include "tools/one_line.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

struct ImportOptions {
  ImportRequest request;
  std::string artifact, machine, output, compensation;
  bool json = false, preview = false;
  OutputFiles files;
};

ImportPreview readFile(const ImportOptions& options) {
  const ControllerCompensation compensation = statedCompensation("--compensation", options.compensation);
  const Machine machine = Machine::load(options.machine);
  std::optional<Artifact> artifact;
  if (!options.artifact.empty()) artifact = loadArtifact(options.artifact);
  ProgressBar bar("reading");
  const CancelScope cancel(Interrupt::asked);
  return previewImport(options.request, machine, artifact ? &*artifact : nullptr, compensation,
                       bar.callback());
}

/// Each fault of a file that is refused on a line. @throw InputError: the last.
[[noreturn]] void refuse(const std::vector<std::string>& faults) {
  std::cout << std::flush;
  for (std::size_t i = 0; i + 1 < faults.size(); ++i) say("error: " + faults[i]);
  throw InputError(faults.back());
}

void runImport(ImportOptions& options) {
  if (options.output.empty() && !options.preview)
    throw InputError("-o is missing; name the session's bag, or look at the file first with --preview");
  if (!options.output.empty() && options.preview)
    throw InputError("--preview writes nothing; omit -o, or omit --preview");
  options.files.input({options.request.file, options.request.mapping, options.artifact, options.machine});
  if (!options.preview)
    options.files.bag("-o", options.output,
                      "imported from " + std::filesystem::path(options.request.file).filename().string());
  options.files.check();
  const ImportPreview read = readFile(options);
  const bool writes = read.faults.empty() && !options.preview;
  if (writes) {
    ProgressBar bar("writing");
    options.files.write(options.output, *read.imported.session, bar.callback(), read.imported.motion);
  }
  if (options.json)
    std::cout << jsonText(previewJson(options.request, read, writes ? options.output : "")) << '\n';
  else
    std::cout << previewText(read) << (options.preview ? firstRowsText(read.imported) : "");
  if (!read.faults.empty()) refuse(read.faults);
  if (writes && !options.json) std::cout << "written to " << options.output << '\n';
}

std::string formatLines() {
  std::string text;
  for (const ImportFormat& f : importFormats()) {
    const std::string name = f.name;
    text += "  " + name + std::string(name.size() < 14 ? 14 - name.size() : 1, ' ') + f.what + "\n";
  }
  return text;
}

}  // namespace

void addImportCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] =
      addCommand<ImportOptions>(app, exitStatus, runImport, "import",
                                "Convert a table of contacts or an instrument's log to a session bag");
  command.add_option("file", options.request.file, "the measurements: a table, or one of the formats below")
      ->required();
  command.add_option("--artifact", options.artifact,
                     "artifact file, YAML: balls, points and probe (needed for contacts)");
  command.add_option("--machine", options.machine, "three_axis, five_axis or the path of a URDF")->required();
  command.add_option("--columns", options.request.mapping,
                     "mapping, YAML: meaning, units and signs that the file does not state (docs/import.md)");
  command.add_option("--format", options.request.format,
                     "file format, if it is not recognised automatically");
  command.add_option("-o,--output", options.output, "the session's bag");
  command.add_flag("--preview", options.preview,
                   "print how the file is interpreted, with its first rows, and write nothing");
  command.add_option("--compensation", options.compensation, kCompensationHelp);
  command.add_flag("--json", options.json, "print how the file was interpreted as JSON on standard output");
  options.files.declare(command);
  command.footer(
      "The package's own columns (any order, empty cells are not measured):\n"
      "  time_s                        time (default: the order of the rows)\n"
      "  <joint>_mm, <joint>_deg       readings; a joint without a column stays at 0\n"
      "  <joint>_velocity_mm_s, _deg_s velocity at the contact (if missing, the direction of travel is "
      "assumed:\n"
      "                                from the approach at a touch, from the order of positions at other "
      "readings)\n"
      "  reading_mm                    reading of the laser probe\n"
      "  feature                       ball or point of the artifact; or, instead of it:\n"
      "  reference_x_mm, _y_mm, _z_mm  true position by an independent instrument\n"
      "  deviation_<joint>_um, _arcsec true minus indicated; weights deviation_<joint>_std_um, _std_arcsec\n"
      "  setup                         rows of one setup share one unknown zero\n"
      "  <sensor>_degC, <name>_<unit>  temperatures and any other covariate\n"
      "In other tables, separators, decimal commas, units (inch, um, rad, K …), time stamps and common "
      "column "
      "names are\n"
      "recognised; for what the file does not state, the error message gives the line to add to the mapping. "
      "Formats:\n" +
      formatLines() +
      "Answer what is asked (question: …) before a calibration: no cause is named until then.\n"
      "Examples:\n"
      "  mm import log.txt --machine three_axis --preview\n"
      "  mm import contacts.csv --artifact plate.yaml --machine three_axis -o plate.bag\n"
      "  mm import interferometer_x.csv --machine three_axis -o x.bag\n"
      "  mm import log.txt --columns mapping.yaml --machine three_axis -o log.bag");
}

}  // namespace mm
