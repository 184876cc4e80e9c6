#include "import/column_faults.h"

#include <algorithm>

#include "base/text.h"

namespace mm {

std::string ColumnFaults::place() const { return file_.place(std::max<std::size_t>(1, layout_.headerLine)); }

bool ColumnFaults::twice(std::size_t i) const {
  return std::count(layout_.names.begin(), layout_.names.end(), layout_.names[i]) > 1;
}

std::string ColumnFaults::called(std::size_t i) const {
  return layout_.headerLine > 0 && !layout_.names[i].empty() ? "'" + layout_.names[i] + "'"
                                                             : std::to_string(i + 1);
}

std::string ColumnFaults::key(std::size_t i) const {
  const std::string& name = layout_.names[i];
  if (layout_.headerLine == 0 || name.empty() || twice(i)) return std::to_string(i + 1);
  const bool plain = name.find_first_of(":#{}[],&*?|<>=!%@`'\"") == std::string::npos && name.front() != '-';
  return plain ? name : "'" + name + "'";
}

std::string ColumnFaults::remedy(std::size_t i, const std::string& as) const {
  return "write into the mapping (--columns): columns: {" + key(i) + ": " + as + "}";
}

bool ColumnFaults::mapped(std::size_t i, const std::string& name) const {
  if (twice(i)) return name == std::to_string(i + 1);
  return name == std::to_string(i + 1) || lower(layout_.names[i]) == lower(name);
}

void ColumnFaults::add(std::size_t i, const std::string& what) {
  add(place() + "column " + called(i) + " " + what);
}

}  // namespace mm
