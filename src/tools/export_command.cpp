#include <iostream>

#include "base/error.h"
#include "base/json_text.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"
#include "calibration_file/calibration_yaml.h"
#include "export/export_folder.h"
#include "export/export_page.h"
#include "export/representability.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/one_line.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

struct ExportCommand {
  std::string calibration, target, folder;
  std::vector<std::string> axes;
  double detectionUnit = 1.0;  // um
  double rapidRate = 0.0;      // mm/min; 0: not told
  bool tablesAlone = false, json = false;
  OutputFiles files;
};

/// "table=x": the joint and its letter. @throw InputError.
std::map<std::string, std::string> lettersOf(const std::vector<std::string>& axes) {
  std::map<std::string, std::string> letters;
  for (const std::string& text : axes) {
    const auto [joint, letter] = assignmentOf(text, "--axis", "JOINT=LETTER, e.g. table=x");
    if (!letters.emplace(joint, lower(letter)).second)
      throw InputError("--axis '" + text + "': joint '" + joint + "' is given twice");
  }
  return letters;
}

int runExport(ExportCommand& c) {
  const ExportTarget& target = exportTarget(c.target);
  c.files.input(c.calibration);
  c.files.folder("-o", c.folder, target.name);
  c.files.check();
  const Calibration calibration = loadCalibration(c.calibration);
  ExportOptions options;
  options.letters = lettersOf(c.axes);
  options.detectionUnit = c.detectionUnit * kMicrometre;
  options.tablesAlone = c.tablesAlone;
  if (c.tablesAlone && target.name != "linuxcnc")
    throw InputError("--tables-alone omits the external offsets of linuxcnc; " + target.name +
                     " has none: omit it");
  options.rapidRate = c.rapidRate * kMillimetre / 60.0;
  const NeededCorrection needed(calibration, options.letters);
  const Exported exported = exportedFor(target, needed, options);
  Representability judged;
  {
    ProgressBar bar("exporting");
    judged = representability(calibration, target, options, needed, exported,
                              [&](const std::string& what, double share) {
                                Interrupt::check();
                                bar.show(share, what);
                              });
  }
  c.files.write(c.folder, exportFolderOf(calibration, target, needed, exported, judged));
  if (c.json) {
    std::cout << jsonText(representabilityJson(judged)) << '\n';
  } else {
    std::cout << representabilityText(judged) << "\nwritten to " << c.folder << ": ";
    std::vector<std::string> names;
    for (const ExportedFile& file : judged.files) names.push_back(file.path);
    std::cout << joined(names, ", ") << '\n';
  }
  const bool stated = needed.compensation().stated != ControllerCompensation::Stated::kNot;
  say((stated ? "" : "warning: ") + judged.activeWords);
  if (!judged.carriesNothing()) return kDone;
  say(target.title + " can carry nothing of this calibration: it holds " + exported.holds);
  return kAnswerIsNo;
}

}  // namespace

void addExportCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<ExportCommand>(
      app, exitStatus, runExport, "export", "Export a calibration as compensation tables of a controller");
  command.add_option("calibration", c.calibration, "the calibration file")->required();
  command.add_option("--to", c.target, "the controller: " + joined(exportTargetNames(), ", "))->required();
  command.add_option("-o,--output", c.folder, "the folder to write")->required();
  repeatedOption(command, "--axis", c.axes,
                 "JOINT=LETTER: controller axis of a joint [by its name, else by its direction]; repeatable");
  standardOption(command, "--detection-unit-um", c.detectionUnit, numberWithin(0.01, 10.0, "um"),
                 "fanuc: detection unit of pitch error data, um");
  checkedOption(
      command, "--rapid-mm-min", c.rapidRate, numberWithin(1.0, 1e6, "mm/min"),
      "fanuc: rapid traverse rate, which sets the least interval of pitch error data [the velocity limit "
      "of each joint]");
  command.add_flag("--tables-alone", c.tablesAlone,
                   "linuxcnc: write no external offsets (without the HAL component)");
  command.add_flag("--json", c.json, "print representability.json");
  c.files.declare(command);
  command.footer(
      "Writes the tables, README.md (what to install where, the sign by one move, what was checked, what is "
      "open)\n"
      "and representability.json (how far each effect is carried by the controller). The folder is "
      "written\n"
      "completely or not at all; an earlier export for the same controller is replaced. The new tables "
      "include the\n"
      "compensation that was active while measuring (mm import --compensation); if none is stated, none is "
      "assumed.\n"
      "Exit status 1: the controller cannot carry any part of this calibration.\n"
      "Example: mm export c.yaml --to linuxcnc -o for_linuxcnc");
}

}  // namespace mm
