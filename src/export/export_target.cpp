#include "export/export_target.h"

#include <cctype>

#include "base/error.h"
#include "base/format.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "export/targets.h"

namespace mm {

const std::vector<ExportTarget>& exportTargets() {
  static const std::vector<ExportTarget> targets = {
      {"linuxcnc", "LinuxCNC", "# ", "BACKLASH, COMP_FILE", toLinuxcnc},
      {"klipper", "Klipper", "# ", "skew profiles, meshes", toKlipper},
      {"marlin", "Marlin", "; ", "M425, M852", toMarlin},
      {"reprapfirmware", "RepRapFirmware", "; ", "M425, M556", toReprapfirmware},
      {"grblhal", "grblHAL", "; ", "$160 and following", toGrblhal},
      {"siemens", "Siemens SINUMERIK 840D sl, 828D, ONE", "; ",
       "$MA_BACKLASH, $MA_ENC_COMP_ENABLE, other tables $AN_CEC", toSiemens},
      {"heidenhain", "Heidenhain TNC", "", "MP710 or backLash, other tables", toHeidenhain},
      {"fanuc", "Fanuc Series 0i, 16i, 30i", "", "1851, 1852, 3620 to 3627, 5700 and following", toFanuc},
      {"beckhoff", "Beckhoff TwinCAT CNC, ISG kernel", "# ", "lr_param.anwahl_losekomp, other lists",
       toBeckhoff},
      {"isg", "ISG volumetric compensation (Beckhoff TF5280)", "// ",
       "backlash, compensation value lists kw.*, another vol_comp", toIsg},
      {"csv", "component errors of ISO 230-1 as CSV", "", "any", toCsv},
  };
  return targets;
}

std::vector<std::string> exportTargetNames() { return allNames(exportTargets()); }

const ExportTarget& exportTarget(const std::string& name) {
  for (const ExportTarget& target : exportTargets())
    if (target.name == name) return target;
  throw InputError("--to " + name + ": is not a target" + didYouMean(name, exportTargetNames()) +
                   "; use one of " + listOf(exportTargetNames()));
}

std::string activeWords(const ExportTarget& target, const NeededCorrection& needed,
                        const Exported& exported) {
  using Stated = ControllerCompensation::Stated;
  std::vector<std::string> written, left;
  for (const ExportAxis& axis : needed.axes()) {
    const bool tables = exported.axes.count(axis.letter) > 0;
    if (tables || !exported.offsets || !needed.changes(axis.joint))  // else offsets alone are for it
      (tables ? written : left).push_back(capital(axis.letter));
  }
  const std::string rest = left.empty() ? ""
                                        : " No table is written for " + listOf(left) +
                                              "; existing compensation of these axes in the controller stays "
                                              "unchanged.";
  switch (needed.compensation().stated) {
    case Stated::kNot:
      return "ASSUMED, because it was not stated: no compensation was active while measuring (" +
             target.beside +
             "). If one was, these tables undo it: state it (mm import --compensation FOLDER) and export "
             "again." +
             rest;
    case Stated::kNone:
      return "As stated, no compensation was active while measuring: none may be active in addition to these "
             "tables (" +
             target.beside + ")." + rest;
    case Stated::kFiles:
      break;
  }
  return "While measuring, " + needed.compensation().inWords() + " were active. " +
         (written.empty()
              ? std::string("They stay as they are.")
              : "The tables here, for " + listOf(written) +
                    ", contain those plus the correction of the calibration: they replace them, and no other "
                    "compensation of these axes may be active (" +
                    target.beside + ").") +
         rest;
}

namespace {

/// What was active goes on where the new files say nothing.
void keepOthers(const NeededCorrection& needed, Exported& out) {
  const LoadedCompensation* active = needed.active();
  if (active == nullptr) return;
  bool goesOn = active->hasOffsets() && !out.offsets;
  for (const auto& [letter, points] : active->tablePoints()) goesOn = goesOn || out.axes.count(letter) == 0;
  if (!goesOn) return;
  for (const ControllerCompensation::File& file : needed.compensation().files)
    out.files.push_back({std::string(ExportDescription::kKept) + "/" + file.path,
                         "was active while measuring, and stays for the other axes", file.text});
}

}  // namespace

Exported exportedFor(const ExportTarget& target, const NeededCorrection& needed,
                     const ExportOptions& options) {
  const ControllerCompensation& active = needed.compensation();
  if (active.stated == ControllerCompensation::Stated::kFiles && active.target != target.name)
    throw InputError("--to " + target.name + ": " + active.inWords() +
                     " were active while measuring, and are not read as tables of " + target.name +
                     "; export for " + active.target + ", or state what " + target.name + " had loaded");
  Exported out = target.write(needed, options);
  if (!target.remark.empty() && !out.files.empty())
    out.files.front().text = target.remark + activeWords(target, needed, out) + "\n" + out.files.front().text;
  keepOthers(needed, out);
  return out;
}

std::string fixed(double value, int digits) {
  std::string text = format("%.*f", digits, value);
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

std::string capital(const std::string& letter) {
  std::string text = letter;
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace mm
