#include "import/column_unit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/format.h"

namespace mm {
namespace {

std::optional<Unit> temperatureByRange(const ColumnSample& s) {
  constexpr double kCold = 5.0, kWarm = 45.0;    // degC in a workshop
  constexpr double kLow = 250.0, kHigh = 400.0;  // K
  if (s.lower >= kCold && s.upper <= kWarm) return parseUnit("degC", UnitKind::kTemperature);
  if (s.lower >= kLow && s.upper <= kHigh) return parseUnit("K", UnitKind::kTemperature);
  return std::nullopt;
}

}  // namespace

bool fitsTravel(const ColumnSample& s, double factor, const Joint& joint) {
  constexpr double kBeyond = 0.05, kLeast = 0.02;  // of the travel
  const double travel = joint.upper - joint.lower;
  if (!std::isfinite(travel) || travel <= 0.0) return false;
  const double low = s.lower * factor, high = s.upper * factor;
  if (low < joint.lower - kBeyond * travel || high > joint.upper + kBeyond * travel) return false;
  return std::max(high - low, std::max(std::abs(low), std::abs(high))) >= kLeast * travel;
}

std::optional<Unit> unitByRange(const ColumnSample& sample, const Meaning& m, const Machine& machine) {
  if (sample.numbers == 0) return std::nullopt;
  if (m.role == CsvRole::kTemperature) return temperatureByRange(sample);
  if (m.role != CsvRole::kPosition && m.role != CsvRole::kMeasured) return std::nullopt;
  const Joint& joint = machine.joints()[m.index];
  const bool linear = joint.kind == JointKind::kLinear;
  std::optional<Unit> only;
  for (const char* name :
       linear ? std::vector<const char*>{"mm", "um", "m", "inch"} : std::vector<const char*>{"deg", "rad"}) {
    const auto unit = parseUnit(name, *m.kind);
    if (!fitsTravel(sample, unit->factor, joint)) continue;
    if (only) return std::nullopt;
    only = unit;
  }
  return only;
}

std::optional<Unit> unitOfColumn(const ColumnPlace& place, const Meaning& m, const NamedUnit& named,
                                 ColumnFaults& faults, std::string& from) {
  const auto& [column, sample, layout, remarks, machine] = place;
  std::string text, where;
  if (!named.text.empty()) {
    text = named.text;
    from = named.from;
  } else if (!layout.units[column].empty()) {
    text = layout.units[column];
    from = "line " + std::to_string(layout.unitsLine);
    where = " (" + from + ")";
  } else if (!sample.suffix.empty()) {
    text = sample.suffix;
    from = "cells";
  }
  if (!text.empty()) {
    const auto unit = parseUnit(text, m.kind);
    if (!unit)
      faults.add(column, "is in '" + text + "'" + where + ", but " + meaningText(m, machine) + " is " +
                             unitsOf(*m.kind) + "; " + faults.remedy(column, exampleOf(m, machine)));
    return unit;
  }
  const RemarkedUnit& remark = *m.kind == UnitKind::kAngle ? remarks.angle : remarks.length;
  if ((*m.kind == UnitKind::kLength || *m.kind == UnitKind::kAngle) && remark.line > 0) {
    from = "line " + std::to_string(remark.line);
    return parseUnit(remark.text, m.kind);
  }
  if (auto unit = unitByRange(sample, m, machine)) {
    from = "its range";
    return unit;
  }
  faults.add(column, "(" + meaningText(m, machine) + format(", %.6g … %.6g", sample.lower, sample.upper) +
                         ") has no unit, and its values do not tell; " +
                         faults.remedy(column, exampleOf(m, machine)) +
                         " (or another unit: " + unitsOf(*m.kind) + ")");
  return std::nullopt;
}

std::optional<TimeUnit> timeUnit(const ColumnSample& sample, const std::string& said) {
  constexpr double kEarliest = 1e9, kLatest = 4e9;  // s since 1970: from 2001 to 2096
  const auto unit = parseUnit(said, UnitKind::kTime);
  if (!said.empty() && !unit) return std::nullopt;
  std::optional<TimeUnit> found;
  if (unit) found = TimeUnit{*unit, false};
  for (const char* part : {"s", "ms", "us", "ns"}) {
    const auto counted = parseUnit(part, UnitKind::kTime);
    const double first = sample.lower * counted->factor, last = sample.upper * counted->factor;
    if (first < kEarliest || last > kLatest || (unit && unit->symbol != part)) continue;
    found = TimeUnit{*counted, true};
  }
  return found;
}

}  // namespace mm
