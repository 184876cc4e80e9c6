#include "calibration_file/calibration_fit.h"

#include <cctype>

#include "machine/machine_fit.h"

namespace mm {

std::string misfitOf(const Calibration& calibration, const Machine& machine, const std::string& space) {
  const Machine calibrated(calibration.urdf, calibration.machineName);
  const std::string who = "calibration '" + calibration.id + "' is of another machine: ";
  const std::string remedy = "; calibrate this machine, or promote a calibration of it";
  const std::string difference = differenceOf(calibrated, machine, "here");
  if (!difference.empty()) return who + difference + remedy;
  if (!serialOf(calibrated).empty() && serialOf(machine).empty())
    return who + "its serial is '" + serialOf(calibrated) +
           "', and this machine states none; state it (<serial> in the URDF, or the parameter 'serial')";
  if (!serialOf(calibrated).empty()) return {};
  if (!calibration.sessionSpace.empty() && !space.empty() && calibration.sessionSpace != space)
    return who + "it was measured in the namespace " + calibration.sessionSpace + ", this machine is in " +
           space + remedy + "; a machine that changes its namespace needs a serial";
  return {};
}

std::string differenceOf(const Calibration& calibration, const Machine& other, const std::string& space,
                         const std::string& there) {
  const Machine calibrated(calibration.urdf, calibration.machineName);
  const std::string difference = differenceOf(calibrated, other, there);
  const bool serials = !serialOf(calibrated).empty() && !serialOf(other).empty();
  if (!difference.empty() || serials || calibration.sessionSpace.empty() || space.empty() ||
      calibration.sessionSpace == space)
    return difference;
  return "it was measured in the namespace " + calibration.sessionSpace + ", " + there + " that is " + space;
}

std::string uncheckedFit(const Calibration& calibration, const Machine& machine) {
  const std::string who = "calibration '" + calibration.id + "' ";
  if (!calibration.toldSpace)
    return who + "does not name its machine (software " + calibration.software +
           "): only its URDF could be compared; calibrate again";
  const Machine calibrated(calibration.urdf, calibration.machineName);
  if (!serialOf(machine).empty() && serialOf(calibrated).empty())
    return who + "states no serial, this machine is '" + serialOf(machine) +
           "': only its URDF and namespace could be compared; calibrate again";
  return {};
}

std::string folderOf(const Machine& machine, const std::string& space) {
  std::string name = serialOf(machine).empty() ? space : serialOf(machine);
  while (!name.empty() && name.front() == '/') name.erase(name.begin());
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
  if (!name.empty() && name.front() == '.') name.front() = '_';
  return name;
}

}  // namespace mm
