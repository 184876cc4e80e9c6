#include "session/csv_columns.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "session/csv_cells.h"

namespace mm {
namespace {

using Known = std::map<std::string, CsvColumn>;
using Q = RoleQuantity;

constexpr RoleFacts kRoles[] = {
    {CsvRole::kTime, Q::kTime, "time_s", "time"},
    {CsvRole::kPosition, Q::kReadingOfJoint, "%_mm", "reading of joint %"},
    {CsvRole::kVelocity, Q::kSpeedOfJoint, "%_velocity_mm_s", "velocity of joint %"},
    {CsvRole::kReading, Q::kLength, "reading_mm", "laser's reading"},
    {CsvRole::kFeature, Q::kNone, "feature", "ball or point touched"},
    {CsvRole::kReference, Q::kLength, "reference_%_mm", "true position %"},
    {CsvRole::kLength, Q::kLength, "length_mm", "length from a feature to the tip"},
    {CsvRole::kDeviation, Q::kErrorOfJoint, "deviation_%_um", "deviation of %"},
    {CsvRole::kDeviationStd, Q::kErrorOfJoint, "deviation_%_std_um", "std of the deviation of %"},
    {CsvRole::kSetup, Q::kNone, "setup", "setup"},
    {CsvRole::kPlacement, Q::kNone, "placement", "placement"},
    {CsvRole::kStylus, Q::kNone, "stylus", "stylus"},
    {CsvRole::kDirection, Q::kNone, "direction_%", "direction of travel of %"},
    {CsvRole::kTemperature, Q::kTemperature, "%_degC", "temperature %"},
    {CsvRole::kCovariate, Q::kNone, "%", "covariate %"},
    {CsvRole::kDate, Q::kNone, "date", "day of the time"},
    {CsvRole::kMeasured, Q::kReadingOfJoint, "measured_%_mm", "position of % by an instrument"},
    {CsvRole::kIgnored, Q::kNone, "ignore", "left out: %"},
};

bool ofJoint(CsvRole role) {
  const Q q = factsOf(role).quantity;
  return q == Q::kReadingOfJoint || q == Q::kErrorOfJoint || q == Q::kSpeedOfJoint ||
         role == CsvRole::kDirection;
}

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  const std::size_t at = text.find(what);
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

/// A text of a role with the name of its joint, of its component, or the one given.
std::string named(const char* text, CsvRole role, int index, const std::string& name,
                  const Machine& machine) {
  const bool joint = ofJoint(role);
  return replaced(text, "%",
                  joint                         ? machine.joints()[index].name
                  : role == CsvRole::kReference ? std::string(1, "xyz"[index])
                                                : name);
}

double factorOf(CsvRole role, int index, const Machine& machine) {
  const Q quantity = factsOf(role).quantity;
  if (quantity == Q::kErrorOfJoint) return errorUnit(machine.joints()[index]).factor;
  if (ofJoint(role)) return readingUnit(machine.joints()[index]).factor;
  return quantity == Q::kLength ? kMillimetre : 1.0;
}

/// Every column whose name is fixed by the machine.
Known knownColumns(const Machine& machine) {
  Known known;
  for (const RoleFacts& facts : kRoles) {
    if (facts.role == CsvRole::kTemperature) break;  // from there on names are free, or not of the format
    const int count = ofJoint(facts.role) ? machine.jointCount() : facts.role == CsvRole::kReference ? 3 : 1;
    for (int k = 0; k < count; ++k) {
      CsvColumn column;
      column.role = facts.role;
      column.index = k;
      column.factor = factorOf(facts.role, k, machine);
      column.header = columnName(facts.role, k, "", machine);
      known[column.header] = column;
    }
  }
  return known;
}

std::vector<std::string> namesOf(const Known& known) {
  std::vector<std::string> names;
  for (const auto& entry : known) names.push_back(entry.first);
  return names;
}

/// The known column that differs from `header` in its unit only, or null.
const CsvColumn* otherUnit(const Known& known, const std::string& header) {
  const CsvColumn* found = nullptr;
  for (const auto& [name, column] : known) {
    const bool twoParts = column.role == CsvRole::kVelocity;  // its unit is two parts: mm_s
    std::string stem = name.substr(0, name.rfind('_'));
    if (twoParts) stem = stem.substr(0, stem.rfind('_'));
    if (name.find('_') == std::string::npos) continue;
    const bool same =
        header == stem || (startsWith(header, stem + "_") &&
                           (twoParts || header.find('_', stem.size() + 1) == std::string::npos));
    if (same && (found == nullptr || name.size() > found->header.size())) found = &column;
  }
  return found;
}

/// A misspelt fixed column must not pass for a covariate: these look like one of the fixed ones.
bool resemblesKnown(const Known& known, const std::string& header) {
  if (startsWith(header, "deviation_") || startsWith(header, "reference_")) return true;
  for (const char* unit : {"_mm", "_deg", "_mm_s", "_deg_s"})
    if (endsWith(header, unit)) return true;  // readings of joints, of the probe, of a reference
  const auto close = [&](const auto& entry) {
    const std::string& name = entry.first;
    if (name.size() < 6 || name.size() > header.size() + 1 || header.size() > name.size() + 1) return false;
    return editDistance(name, header) <= 1;
  };
  return std::any_of(known.begin(), known.end(), close);
}

bool isTemperatureUnit(const std::string& unit) {
  return isOneOf(lower(unit), "c|degc|celsius|k|degk|kelvin|f|degf|fahrenheit");
}

/// Names of sensors and covariates become topics.
void checkName(const std::string& name, const std::string& header, const std::string& place) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  if (name.empty() || !std::all_of(name.begin(), name.end(), allowed))
    throw InputError(place + ": column '" + shownText(header) + "': '" + shownText(name) +
                     "' cannot name a sensor or covariate; use letters, digits and _");
}

/// A sensor, a covariate, or nothing that the format knows.
CsvColumn openColumn(const std::string& header, const Known& known, const std::string& place) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(place + ": column '" + shownText(header) + "' " + why);
  };
  const std::vector<std::string> names = namesOf(known);
  const std::size_t cut = header.rfind('_');
  CsvColumn column;
  column.header = header;
  column.name = header.substr(0, cut);
  column.unit = cut == std::string::npos ? "" : header.substr(cut + 1);
  column.role = column.unit == "degC" ? CsvRole::kTemperature : CsvRole::kCovariate;
  if (column.role == CsvRole::kCovariate) {
    if (const CsvColumn* fixed = otherUnit(known, header))
      refuse("is in the wrong unit or has none; the import format wants '" + fixed->header + "'");
    if (column.unit.empty())
      refuse("is unknown (sensors are <name>_degC, covariates <name>_<unit>)" + didYouMean(header, names));
    if (isTemperatureUnit(column.unit))
      refuse("is in the wrong unit: temperatures are in degrees Celsius, '" + column.name + "_degC'");
    if (resemblesKnown(known, header)) refuse("is unknown on this machine" + didYouMean(header, names));
  }
  checkName(column.name, header, place);
  return column;
}

}  // namespace

const RoleFacts& factsOf(CsvRole role) {
  return *std::find_if(std::begin(kRoles), std::end(kRoles),
                       [&](const RoleFacts& f) { return f.role == role; });
}

std::string columnName(CsvRole role, int index, const std::string& name, const Machine& machine) {
  std::string column = factsOf(role).column;
  if (ofJoint(role) && machine.joints()[index].kind == JointKind::kRotary)
    column = replaced(replaced(column, "_mm", "_deg"), "_um", "_arcsec");
  return named(column.c_str(), role, index, name, machine);
}

std::string roleText(CsvRole role, int index, const std::string& name, const Machine& machine) {
  return named(factsOf(role).meaning, role, index, name, machine);
}

std::vector<std::string> fixedColumns(const Machine& machine) { return namesOf(knownColumns(machine)); }

std::vector<CsvColumn> parseCsvHeader(const std::vector<std::string>& names, const Machine& machine,
                                      const std::string& place) {
  const Known known = knownColumns(machine);
  std::vector<CsvColumn> columns;
  std::map<std::string, int> sensors, covariates;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& header = names[i];
    if (header.empty()) throw InputError(place + ": column " + std::to_string(i + 1) + " has no name");
    if (header.find(';') != std::string::npos || header.find('\t') != std::string::npos)
      throw InputError(place +
                       ": columns must be separated by commas, numbers written with a decimal point; "
                       "measurements in a table of any other form become a session by mm import");
    if (!seen.insert(header).second)
      throw InputError(place + ": column '" + shownText(header) + "' is given twice");
    const auto fixed = known.find(header);
    CsvColumn column = fixed != known.end() ? fixed->second : openColumn(header, known, place);
    if (column.role == CsvRole::kTemperature || column.role == CsvRole::kCovariate) {
      auto& list = column.role == CsvRole::kTemperature ? sensors : covariates;
      column.index = static_cast<int>(list.size());
      if (!list.emplace(column.name, column.index).second)
        throw InputError(place + ": '" + column.name + "' is given in two units; leave one column out");
    }
    columns.push_back(std::move(column));
  }
  return columns;
}

}  // namespace mm
