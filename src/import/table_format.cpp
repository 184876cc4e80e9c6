#include "import/table_format.h"

namespace mm {

void readAnyTable(ImportContext& context) {
  const TableLayout layout = tableLayout(context.file, context.mapping);
  Imported& imported = context.imported;
  imported.how = context.file.encoding() + ", " + layout.inWords();
  UnderstoodTable table = understandTable(context.file, layout, context.mapping, context.machine,
                                          context.artifact, context.faults);
  imported.columns = std::move(table.columns);
  imported.notes = std::move(table.notes);
  if (!context.faults.empty()) return;
  TextLines lines(context.file);
  TableReading reading = readTable(lines, table.form, context.file.path(), context.machine, context.artifact);
  imported.notes.insert(imported.notes.end(), reading.notes.begin(), reading.notes.end());
  finishImport(context, std::move(reading.session));
}

}  // namespace mm
