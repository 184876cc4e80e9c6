#include <algorithm>
#include <cmath>
#include <optional>

#include "base/text.h"
#include "import/column_unit.h"
#include "import/date_in_head.h"
#include "import/import_format.h"

namespace mm {
namespace {

/// Whether readings of joints in which the decimal mark is not seen fit the travels with this mark.
bool fitsTravels(const ImportContext& context, TableLayout layout, bool comma) {
  layout.decimalComma = comma;
  ImportFaults faults;
  Imported ignored;
  const TableForm form = understandTable(
      {context.file, context.mapping, context.machine, context.artifact, faults, ignored, context.fixed},
      layout);
  const std::vector<ColumnSample> samples = columnSamples(context.file, layout);
  bool any = false;
  for (const UnclearNumber& u : layout.marks.unclear) {
    if (u.column >= form.columns.size()) continue;
    const CsvColumn& c = form.columns[u.column];
    if (c.role != CsvRole::kPosition && c.role != CsvRole::kMeasured) continue;
    if (!fitsTravel(samples[u.column], c.factor, context.machine.joints()[c.index])) return false;
    any = true;
  }
  return any;
}

/// A mark that no number shows may be shown by the travels: -16,000 mm is no reading of a machine of 40 mm
/// with thousands set apart.
void seeMarkByTravels(ImportContext& context, TableLayout& layout) {
  if (layout.marks.unclear.empty() || layout.marks.proven) return;
  const bool comma = fitsTravels(context, layout, true), point = fitsTravels(context, layout, false);
  if (comma == point) return;
  layout.decimalComma = comma;
  const UnclearNumber u = layout.marks.unclear.front();
  layout.marks.unclear.clear();
  context.note("line " + std::to_string(u.line) + ": '" + shownText(u.cell) + "' is taken with " +
               (comma ? "a decimal comma" : "thousands set apart by a comma") +
               ", because only then are the readings within the travels; if that is wrong, " +
               addToMapping("decimal", comma ? "point" : "comma"));
}

/// The first rows as written, for people.
void showRows(const ImportContext& context, const TableLayout& layout) {
  std::vector<std::vector<std::string>>& shown = context.imported.rows;
  eachRow(context.file, layout, [&](std::size_t, std::string_view, Cells& cells) {
    if (shown.size() == kRowsShown || cells.empty()) return;
    shown.push_back(shownCells(cells, layout.names.size()));
  });
}

/// It begins at the date in the head of the file, to which the rows may add a time of day.
void dateSession(const ImportContext& context, const TableForm& form, Session& session) {
  constexpr double kDay = 86400.0;  // s
  const std::optional<double> date = dateInHead(context);
  if (!date) return;
  const bool clock = std::any_of(form.columns.begin(), form.columns.end(),
                                 [](const CsvColumn& c) { return c.timeForm == TimeForm::kClock; });
  const double ofDay = session.epoch - static_cast<double>(kImportEpoch);
  session.epoch = clock ? kDay * std::floor(*date / kDay) + ofDay : *date;
}

}  // namespace

void readAnyTable(ImportContext& context) {
  TableLayout layout = tableLayout(context.file, context.mapping);
  seeMarkByTravels(context, layout);
  Imported& imported = context.imported;
  imported.how = context.file.encoding() + ", " + layout.inWords();
  const TableForm form = understandTable(context, layout);
  if (!imported.columns.empty()) showRows(context, layout);
  for (const UnclearNumber& u : layout.marks.unclear)
    if (u.column < form.columns.size() && form.columns[u.column].role != CsvRole::kIgnored)
      refuseUnclear(context.file, layout, u, context.faults);
  if (!context.faults.empty()) return;
  TableReading reading = readTable(context.file, form, context.machine, context.artifact);
  imported.notes.insert(imported.notes.end(), reading.notes.begin(), reading.notes.end());
  if (!form.absoluteTime) dateSession(context, form, reading.session);
  finishImport(context, std::move(reading.session));
}

}  // namespace mm
