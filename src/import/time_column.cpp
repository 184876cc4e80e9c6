#include "import/time_column.h"

#include "import/column_unit.h"
#include "import/unit.h"

namespace mm {
namespace {

/// 11/21/2026: which comes first is seen where a day is above 12, else it is asked for.
void slashed(std::size_t i, const ColumnSample& s, const ColumnMapping& mapping, ColumnFaults& faults,
             TimeColumn& time) {
  const std::string order = mapping.setting("date");
  if (!order.empty() && order != "month_first" && order != "day_first")
    faults.add(mapping.source + ":" + std::to_string(mapping.lines.at("date")) + ": date: is '" + order +
               "', but must be month_first or day_first");
  else if (order.empty() && s.monthFirst == s.dayFirst)
    faults.add(i, "has dates as " + s.first +
                      ", and whether the month or the day comes first cannot be seen; write into the mapping "
                      "(--columns): date: month_first (or day_first)");
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
  const auto unit = timeUnit(s, text);
  if (unit) {
    if (text.empty()) time.from = "its range: since 1970";
    time.factor = unit->unit.factor;
    time.unit = unit->unit.symbol;
    time.since1970 = unit->since1970;
  } else if (!text.empty()) {
    faults.add(i, "is in '" + text + "', but time is " + unitsOf(UnitKind::kTime) + "; " +
                      faults.remedy(i, "time_s"));
  } else {
    time.unit = "s";
    time.from = "assumed";
    time.notes.push_back("column " + faults.called(i) +
                         ": times without a unit are taken as seconds; if they are not, " +
                         faults.remedy(i, "time_ms"));
  }
}

}  // namespace

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
