#include "import/import_format.h"
#include "import/table_format.h"

namespace mm {

const std::vector<ImportFormat>& importFormats() {
  static const std::vector<ImportFormat> kFormats = {
      {"table", "one row a measurement, columns by name", [](const TextFile&) { return true; }, readAnyTable},
  };
  return kFormats;
}

}  // namespace mm
