#include "import/meaning.h"

#include <algorithm>

#include "base/nearest_name.h"
#include "base/text.h"

namespace mm {
namespace {

std::optional<UnitKind> kindFor(CsvRole role, int index, const Machine& machine) {
  switch (role) {
    case CsvRole::kTime:
      return UnitKind::kTime;
    case CsvRole::kPosition:
    case CsvRole::kDeviation:
    case CsvRole::kDeviationStd:
    case CsvRole::kMeasured:
      return unitKindOf(machine, index);
    case CsvRole::kVelocity:
      return unitKindOf(machine, index) == UnitKind::kLength ? UnitKind::kSpeed : UnitKind::kTurning;
    case CsvRole::kReading:
    case CsvRole::kReference:
    case CsvRole::kLength:
      return UnitKind::kLength;
    case CsvRole::kTemperature:
      return UnitKind::kTemperature;
    default:
      return std::nullopt;
  }
}

}  // namespace

UnitKind unitKindOf(const Machine& machine, int joint) {
  return machine.joints()[joint].kind == JointKind::kLinear ? UnitKind::kLength : UnitKind::kAngle;
}

Meaning meaningOf(CsvRole role, int index, const Machine& machine, const std::string& name) {
  Meaning m;
  m.role = role;
  m.index = index;
  m.name = name;
  m.kind = kindFor(role, index, machine);
  return m;
}

Meaning leftOut(const std::string& why) {
  Meaning m;
  m.why = why;
  return m;
}

Meaning meaningOf(const CsvColumn& column, const Machine& machine) {
  return meaningOf(column.role, column.index, machine, column.name);
}

std::string meaningText(const Meaning& m, const Machine& machine) {
  const std::string joint = m.index < machine.jointCount() ? machine.joints()[m.index].name : std::string();
  switch (m.role) {
    case CsvRole::kTime:
      return "time";
    case CsvRole::kDate:
      return "day of the time";
    case CsvRole::kPosition:
      return "reading of joint " + joint;
    case CsvRole::kVelocity:
      return "velocity of joint " + joint;
    case CsvRole::kReading:
      return "laser's reading";
    case CsvRole::kFeature:
      return "ball or point touched";
    case CsvRole::kReference:
      return std::string("true position ") + "xyz"[m.index];
    case CsvRole::kLength:
      return "length from a feature to the tip";
    case CsvRole::kDeviation:
      return std::string("deviation of ") + joint + (m.reversed ? ", sign changed" : "");
    case CsvRole::kDeviationStd:
      return "std of the deviation of " + joint;
    case CsvRole::kMeasured:
      return "position of " + joint + " by an instrument";
    case CsvRole::kDirection:
      return "direction of travel of " + joint;
    case CsvRole::kSetup:
      return "setup";
    case CsvRole::kPlacement:
      return "placement";
    case CsvRole::kStylus:
      return "stylus";
    case CsvRole::kTemperature:
      return "temperature " + m.name;
    case CsvRole::kCovariate:
      return "covariate " + m.name;
    case CsvRole::kIgnored:
      break;
  }
  return "left out: " + m.why;
}

std::string exampleOf(const Meaning& m, const Machine& machine) {
  const int index = std::min(m.index, machine.jointCount() - 1);
  const bool linear = unitKindOf(machine, index) == UnitKind::kLength;
  const std::string joint = machine.joints()[index].name;
  switch (m.role) {
    case CsvRole::kTime:
      return "time_s";
    case CsvRole::kReading:
      return "reading_mm";
    case CsvRole::kReference:
      return std::string("reference_") + "xyz"[m.index] + "_mm";
    case CsvRole::kLength:
      return "length_mm";
    case CsvRole::kTemperature:
      return m.name + "_degC";
    case CsvRole::kDeviation:
      return (m.reversed ? "error_" : "deviation_") + joint + (linear ? "_um" : "_arcsec");
    case CsvRole::kDeviationStd:
      return "deviation_" + joint + "_std" + (linear ? "_um" : "_arcsec");
    case CsvRole::kVelocity:
      return joint + (linear ? "_velocity_mm_s" : "_velocity_deg_s");
    case CsvRole::kMeasured:
      return "measured_" + joint + (linear ? "_mm" : "_deg");
    case CsvRole::kDirection:
      return "direction_" + joint;
    case CsvRole::kFeature:
      return "feature";
    case CsvRole::kSetup:
      return "setup";
    case CsvRole::kPlacement:
      return "placement";
    case CsvRole::kStylus:
      return "stylus";
    default:
      return joint + (linear ? "_mm" : "_deg");
  }
}

int jointOf(const Machine& machine, const std::string& name) {
  for (int j = 0; j < machine.jointCount(); ++j)
    if (lower(machine.joints()[j].name) == lower(name)) return j;
  return -1;
}

std::string jointNames(const Machine& machine) {
  std::vector<std::string> names;
  for (const Joint& j : machine.joints()) names.push_back(j.name);
  return listOf(names);
}

}  // namespace mm
