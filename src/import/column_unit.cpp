#include "import/column_unit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/format.h"
#include "base/text.h"

namespace mm {
bool fitsTravel(const ColumnSample& s, double factor, const Joint& joint) {
  constexpr double kBeyond = 0.05, kLeast = 0.02;  // of the travel
  const double travel = joint.upper - joint.lower;
  if (!std::isfinite(travel) || travel <= 0.0) return false;
  const double low = s.lower * factor, high = s.upper * factor;
  if (low < joint.lower - kBeyond * travel || high > joint.upper + kBeyond * travel) return false;
  return std::max(high - low, std::max(std::abs(low), std::abs(high))) >= kLeast * travel;
}

namespace {

std::optional<Unit> temperatureByRange(const ColumnSample& s) {
  constexpr double kCold = 5.0, kWarm = 45.0;    // degC in a workshop
  constexpr double kLow = 250.0, kHigh = 400.0;  // K
  if (s.lower >= kCold && s.upper <= kWarm) return parseUnit("degC", UnitKind::kTemperature);
  if (s.lower >= kLow && s.upper <= kHigh) return parseUnit("K", UnitKind::kTemperature);
  return std::nullopt;
}

/// Where only one unit is possible: a machine's joint can go so far and no farther, and is not measured
/// within a fiftieth of its travel; a workshop has 5 to 45 degC, or a kelvin scale begins above 200.
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

/// Of a column of numbers: by the unit that is said (empty: none), else by its range where the numbers count
/// from 1970. False where the text is no unit of time, or where there is none and the range does not tell.
bool timeUnit(const ColumnSample& sample, const std::string& said, TimeColumn& time) {
  constexpr double kEarliest = 1e9, kLatest = 4e9;  // s since 1970: from 2001 to 2096
  std::optional<Unit> found = parseUnit(said, UnitKind::kTime);
  if (!said.empty() && !found) return false;
  for (const char* part : {"s", "ms", "us", "ns"}) {
    const auto counted = parseUnit(part, UnitKind::kTime);
    const double first = sample.lower * counted->factor, last = sample.upper * counted->factor;
    if (first < kEarliest || last > kLatest || (!said.empty() && found->symbol != part)) continue;
    found = counted;
    time.since1970 = true;
  }
  if (found) time.factor = found->factor, time.unit = found->symbol;
  return found.has_value();
}

/// 11/21/2026: which comes first is seen where a day is above 12, else it is asked for.
void slashed(std::size_t i, const ColumnSample& s, const ColumnMapping& mapping, ColumnFaults& faults,
             TimeColumn& time) {
  const std::string order = mapping.setting("date");
  if (!order.empty() && order != "month_first" && order != "day_first")
    faults.add(mapping.place("date") + "date: is '" + shownText(order) +
               "', but must be month_first or day_first");
  else if (order.empty() && s.monthFirst == s.dayFirst)
    faults.add(i, "has dates as " + shownText(s.first) + ", and the order of month and day is ambiguous; " +
                      faults.lines().ask("date", "month_first") + " (or day_first)");
  const bool month = order.empty() ? s.monthFirst : order == "month_first";
  time.form = month ? TimeForm::kMonthFirst : TimeForm::kDayFirst;
  time.unit = month ? "calendar, month first" : "calendar, day first";
  time.since1970 = true;
}

void numbers(std::size_t i, const ColumnSample& s, const TableLayout& layout, const std::string& said,
             ColumnFaults& faults, TimeColumn& time) {
  const std::string text = !said.empty() ? said : !layout.units[i].empty() ? layout.units[i] : s.suffix;
  if (!said.empty()) time.from = "header";
  if (said.empty() && layout.unitsLine > 0) time.from = "line " + std::to_string(layout.unitsLine);
  if (timeUnit(s, text, time)) {
    if (text.empty()) time.from = "its range: since 1970";
  } else if (!text.empty()) {
    faults.add(i, "is in '" + shownText(text) + "', but time is " + factsOf(UnitKind::kTime).inWords,
               "time_s");
  } else {
    time.unit = "s";
    time.from = "assumed";
    time.notes.push_back("column " + faults.called(i) +
                         ": times without a unit are taken as seconds; if they are not, " +
                         faults.line(i, "time_ms"));
  }
}

}  // namespace

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
      faults.add(column,
                 "is in '" + shownText(text) + "'" + where + ", but " + shownText(meaningText(m, machine)) +
                     " is " + factsOf(*m.kind).inWords,
                 exampleOf(m, machine));
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
  faults.add(column,
             "(" + shownText(meaningText(m, machine)) + format(", %.6g … %.6g", sample.lower, sample.upper) +
                 ") has no unit, and its values do not reveal it",
             exampleOf(m, machine), " (or another unit: " + factsOf(*m.kind).inWords + ")");
  return std::nullopt;
}

TimeColumn timeColumn(std::size_t i, const ColumnSample& s, const TableLayout& layout,
                      const ColumnMapping& mapping, const std::string& said, ColumnFaults& faults) {
  TimeColumn time;
  if (s.calendars > 0) {
    time.form = TimeForm::kCalendar;
    time.unit = "calendar";
    time.since1970 = true;
  } else if (s.slashed > 0) {
    slashed(i, s, mapping, faults, time);
  } else if (s.clocks > 0) {
    time.form = TimeForm::kClock;
    time.unit = "time of day";
  } else {
    numbers(i, s, layout, said, faults, time);
  }
  return time;
}

}  // namespace mm
