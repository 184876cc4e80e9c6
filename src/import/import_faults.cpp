#include "import/import_faults.h"

namespace mm {

std::string addToMapping(const std::string& key, const std::string& value) {
  return "add to the mapping (--columns): " + key + ": " + value;
}

std::string ImportFaults::ask(const std::string& key, const std::string& value) {
  keep({key, value, ""});
  return addToMapping(key, value);
}

void ImportFaults::askColumn(const std::string& column, const std::string& value) {
  keep({"columns", value, column});
}

void ImportFaults::keep(MappingLine line) {
  if (kept_.emplace(line.key, line.column).second) lines_.push_back(std::move(line));
}

}  // namespace mm
