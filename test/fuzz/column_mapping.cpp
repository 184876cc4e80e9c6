// What the user says of a table, and the table read as he says.
#include "import/column_mapping.h"

#include "fuzz_support.h"
#include "import/import_file.h"

namespace {

const char* const kTable =
    "Messung 7\nx;y;z;T1;Nr\n1,5;2,5;-3,25;20,1;1\n1,75;2,5;-3,25;20,2;2\n2,5;2,5;-3,0;20,3;3\n";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mm::Machine machine = mm::Machine::load("three_axis");
  static mm::fuzz::MemoryFile mapping, table;
  mm::ImportRequest request;
  request.file = table.write(kTable);
  request.mapping = mapping.write(data, size);
  if (!mm::fuzz::takes([&] { mm::loadColumnMapping(request.mapping); })) return 0;
  mm::Imported imported;
  mm::fuzz::takes([&] { mm::importFile(request, machine, nullptr, imported); });
  mm::understoodText(imported);
  return 0;
}
