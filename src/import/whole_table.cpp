#include "import/whole_table.h"

#include <algorithm>

#include "import/meaning.h"
#include "import/redundant_deviation.h"

namespace mm {
namespace {

bool hasAny(const UnderstoodTable& table, std::initializer_list<CsvRole> roles) {
  return std::any_of(table.form.columns.begin(), table.form.columns.end(), [&](const CsvColumn& c) {
    return std::find(roles.begin(), roles.end(), c.role) != roles.end();
  });
}

/// Without a column that says what was touched it may be the only ball that there is.
void onlyFeature(const TableLayout& layout, const Artifact* artifact, UnderstoodTable& table,
                 ColumnFaults& faults) {
  if (artifact != nullptr && artifact->features.size() == 1) {
    table.form.onlyFeature = 0;
    table.notes.push_back("no column says what was touched: '" + artifact->features.front().name +
                          "', the only one of the artifact");
    return;
  }
  faults.add(faults.place() +
             "no column says what was measured: a ball (feature), a true position (reference_x_mm) or "
             "a deviation (deviation_x_um); name it in the mapping (--columns), e.g. columns: {" +
             faults.key(layout.names.size() - 1) + ": feature}" +
             (artifact == nullptr ? ", or give an --artifact of one ball" : ""));
}

}  // namespace

void completeTable(const TextFile& file, const TableLayout& layout, const Machine& machine,
                   const Artifact* artifact, UnderstoodTable& table, ColumnFaults& faults) {
  if (!faults.empty()) return;
  settleRedundant(file, layout, table, machine, faults);
  if (hasAny(table, {CsvRole::kFeature}) && artifact == nullptr)
    faults.add(faults.place() +
               "the file names what was touched; give an artifact that says what these are, with --artifact");
  if (!hasAny(table, {CsvRole::kFeature, CsvRole::kReference, CsvRole::kDeviation, CsvRole::kMeasured}))
    onlyFeature(layout, artifact, table, faults);
  if (!hasAny(table, {CsvRole::kPosition}) && faults.empty() && table.form.fixed.empty())
    faults.add(faults.place() + "no column is a reading of a joint of this machine (" + jointNames(machine) +
               "); name one in the mapping (--columns): columns: {" + faults.key(0) + ": " +
               machine.joints().front().name + "_mm}");
  if (!hasAny(table, {CsvRole::kTime, CsvRole::kDate}))
    table.notes.push_back("no column of times: rows are taken in their order, a second apart");
}

}  // namespace mm
