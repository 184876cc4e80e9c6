#include "import/meaning.h"

#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/text.h"

namespace mm {
namespace {

std::optional<UnitKind> kindFor(CsvRole role, int index, const Machine& machine) {
  switch (factsOf(role).quantity) {
    case RoleQuantity::kTime:
      return UnitKind::kTime;
    case RoleQuantity::kLength:
      return UnitKind::kLength;
    case RoleQuantity::kTemperature:
      return UnitKind::kTemperature;
    case RoleQuantity::kReadingOfJoint:
    case RoleQuantity::kErrorOfJoint:
      return unitKindOf(machine, index);
    case RoleQuantity::kSpeedOfJoint:
      return unitKindOf(machine, index) == UnitKind::kLength ? UnitKind::kSpeed : UnitKind::kTurning;
    case RoleQuantity::kNone:
      break;
  }
  return std::nullopt;
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
  return roleText(m.role, m.index, m.role == CsvRole::kIgnored ? m.why : m.name, machine) +
         (m.role == CsvRole::kDeviation && m.reversed ? ", sign changed" : "");
}

std::string exampleOf(const Meaning& m, const Machine& machine) {
  const std::string name = columnName(m.role, m.index, m.name, machine);
  return m.role == CsvRole::kDeviation && m.reversed ? "error" + name.substr(name.find('_')) : name;
}

int jointOf(const Machine& machine, const std::string& name) {
  for (int j = 0; j < machine.jointCount(); ++j)
    if (lower(machine.joints()[j].name) == lower(name)) return j;
  return -1;
}

std::string jointNames(const Machine& machine) { return listOf(allNames(machine.joints())); }

}  // namespace mm
