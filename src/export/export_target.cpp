#include "export/export_target.h"

#include <cctype>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "export/to_beckhoff.h"
#include "export/to_csv.h"
#include "export/to_fanuc.h"
#include "export/to_grblhal.h"
#include "export/to_heidenhain.h"
#include "export/to_klipper.h"
#include "export/to_linuxcnc.h"
#include "export/to_marlin.h"
#include "export/to_reprapfirmware.h"
#include "export/to_siemens.h"

namespace mm {

const std::vector<ExportTarget>& exportTargets() {
  static const std::vector<ExportTarget> targets = {
      {"linuxcnc", "LinuxCNC", toLinuxcnc},
      {"klipper", "Klipper", toKlipper},
      {"marlin", "Marlin", toMarlin},
      {"reprapfirmware", "RepRapFirmware", toReprapfirmware},
      {"grblhal", "grblHAL", toGrblhal},
      {"siemens", "Siemens SINUMERIK 840D sl, 828D, ONE", toSiemens},
      {"heidenhain", "Heidenhain TNC", toHeidenhain},
      {"fanuc", "Fanuc Series 0i, 16i, 30i", toFanuc},
      {"beckhoff", "Beckhoff TwinCAT CNC, ISG kernel", toBeckhoff},
      {"csv", "component errors of ISO 230-1 as CSV", toCsv},
  };
  return targets;
}

std::vector<std::string> exportTargetNames() {
  std::vector<std::string> names;
  for (const ExportTarget& target : exportTargets()) names.push_back(target.name);
  return names;
}

const ExportTarget& exportTarget(const std::string& name) {
  for (const ExportTarget& target : exportTargets())
    if (target.name == name) return target;
  throw InputError("--to " + name + ": is no target" + didYouMean(name, exportTargetNames()) +
                   "; take one of " + listOf(exportTargetNames()));
}

void addNotFollowed(const std::vector<std::string>& told, Exported& out) {
  out.notFollowed.insert(out.notFollowed.end(), told.begin(), told.end());
}

CommandedState commandTo(const NeededCorrection& needed, const State& state, const Exported& exported) {
  CommandedState command = needed.commandOf(state);
  for (const auto& [there, here] : exported.sensors) {
    const auto found = command.temperature.find(here);
    if (found != command.temperature.end()) command.temperature[there] = found->second;
  }
  return command;
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
