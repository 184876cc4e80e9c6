#include "import/whole_table.h"

#include <algorithm>

#include "import/column_words.h"
#include "import/meaning.h"
#include "import/redundant_deviation.h"
#include "import/unit.h"

namespace mm {
namespace {

bool hasAny(const UnderstoodTable& table, std::initializer_list<CsvRole> roles) {
  return std::any_of(table.form.columns.begin(), table.form.columns.end(), [&](const CsvColumn& c) {
    return std::find(roles.begin(), roles.end(), c.role) != roles.end();
  });
}

/// What may hold the measurement of a table in which nothing says so: the column left out that is in the
/// smallest unit of length, else one of a few words, else the last that is no note. @return for the mapping.
std::string guessed(const TableLayout& layout, const std::vector<ColumnSample>& samples,
                    const Machine& machine, const UnderstoodTable& table, const ColumnFaults& faults) {
  std::size_t best = layout.names.size(), words = best, last = 0;
  Unit least;
  int joint = 0;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    const CsvColumn& c = table.form.columns[i];
    if (c.role == CsvRole::kPosition) joint = c.index;
    if (c.role != CsvRole::kIgnored) continue;
    const NameAndUnit split = splitUnit(layout.names[i]);
    const auto unit = parseUnit(split.unitText.empty() ? layout.units[i] : split.unitText, UnitKind::kLength);
    if (samples[i].numbers > 0 && unit && (best == layout.names.size() || unit->factor < least.factor))
      best = i, least = *unit;
    const bool note = table.columns[i].meaning == "left out: a note";
    if (note) continue;
    last = i;
    if (samples[i].numbers == 0 && samples[i].texts > 0) words = i;
  }
  if (best < layout.names.size()) {
    const std::string of = machine.joints()[joint].name + "_" + least.symbol;
    return faults.remedy(best, "deviation_" + of) + " (true minus indicated; error_" + of +
           " for the other sign)";
  }
  return faults.remedy(words < layout.names.size() ? words : last, "feature");
}

/// Without a column that says what was touched it may be the only ball that there is.
void onlyFeature(const TableLayout& layout, const std::vector<ColumnSample>& samples, const Machine& machine,
                 const Artifact* artifact, UnderstoodTable& table, ColumnFaults& faults) {
  if (artifact != nullptr && artifact->features.size() == 1) {
    table.form.onlyFeature = 0;
    table.notes.push_back("no column says what was touched: '" + artifact->features.front().name +
                          "', the only one of the artifact");
    return;
  }
  faults.add(faults.place() +
             "no column says what was measured: a ball (feature), a true position (reference_x_mm) or a "
             "deviation (deviation_x_um); " +
             guessed(layout, samples, machine, table, faults) +
             (artifact == nullptr ? ", or give an --artifact of one ball" : ""));
}

}  // namespace

std::vector<std::pair<int, double>> fixedReadings(const ColumnMapping& mapping, const Machine& machine,
                                                  ColumnFaults& faults) {
  std::vector<std::pair<int, double>> fixed;
  for (const auto& [name, value] : mapping.fixed) {
    const NameAndUnit split = splitUnit(name);
    const int j = jointOf(machine, split.stem);
    const auto kind = j >= 0 ? unitKindOf(machine, j) : UnitKind::kLength;
    const auto unit = parseUnit(split.unitText, kind);
    if (j >= 0 && unit)
      fixed.emplace_back(j, value * unit->factor);
    else
      faults.add(mapping.source + ": fixed: '" + name + "' is not <joint>_<unit> of this machine (" +
                 jointNames(machine) + "); e.g. fixed: {" + machine.joints().front().name + "_mm: 12.5}");
  }
  return fixed;
}

void completeTable(const TextFile& file, const TableLayout& layout, const std::vector<ColumnSample>& samples,
                   const Machine& machine, const Artifact* artifact, UnderstoodTable& table,
                   ColumnFaults& faults) {
  if (!faults.empty()) return;
  settleRedundant(file, layout, table, machine, faults);
  if (hasAny(table, {CsvRole::kFeature}) && artifact == nullptr)
    faults.add(faults.place() +
               "the file names what was touched; give an artifact that says what these are, with --artifact");
  if (!hasAny(table, {CsvRole::kFeature, CsvRole::kReference, CsvRole::kDeviation, CsvRole::kMeasured}))
    onlyFeature(layout, samples, machine, artifact, table, faults);
  if (!hasAny(table, {CsvRole::kPosition}) && faults.empty() && table.form.fixed.empty())
    faults.add(faults.place() + "no column is a reading of a joint of this machine (" + jointNames(machine) +
               "); name one in the mapping (--columns): columns: {" + faults.key(0) + ": " +
               machine.joints().front().name + "_mm}");
  if (!hasAny(table, {CsvRole::kTime, CsvRole::kDate}))
    table.notes.push_back("no column of times: rows are taken in their order, a second apart");
}

}  // namespace mm
