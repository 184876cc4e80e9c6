#include "import/column_faults.h"

#include <algorithm>
#include <set>

#include "base/text.h"

namespace mm {

ColumnFaults::ColumnFaults(const TextFile& file, const TableLayout& layout, ImportFaults& faults)
    : file_(file), layout_(layout), faults_(faults) {
  for (const std::string& name : layout.names) ++counts_[name];
}

std::string ColumnFaults::place() const { return file_.place(std::max<std::size_t>(1, layout_.headerLine)); }

bool ColumnFaults::twice(std::size_t i) const { return counts_.at(layout_.names[i]) > 1; }

std::string ColumnFaults::called(std::size_t i) const {
  return layout_.headerLine > 0 && !layout_.names[i].empty() ? "'" + shownText(layout_.names[i]) + "'"
                                                             : std::to_string(i + 1);
}

std::string ColumnFaults::keyName(std::size_t i) const {
  const std::string& name = layout_.names[i];
  const bool own = layout_.headerLine > 0 && !name.empty() && !twice(i) && shownText(name) == name;
  return own ? name : std::to_string(i + 1);
}

std::string ColumnFaults::key(std::size_t i) const {
  const std::string name = keyName(i);
  if (name.find_first_of(":#{}[],&*?|<>=!%@`'\"") == std::string::npos && name.front() != '-') return name;
  std::string quoted = "'";
  for (const char c : name) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

std::string ColumnFaults::line(std::size_t i, const std::string& as) const {
  return addToMapping("columns", "{" + key(i) + ": " + as + "}");
}

void ColumnFaults::tell() {
  std::vector<std::string> pairs;
  std::set<std::string> known;
  const auto pairOf = [&](const ColumnRemedy& r) { return key(r.column) + ": " + r.as; };
  for (const Told& told : told_)
    if (told.remedy && known.insert(pairOf(*told.remedy)).second) pairs.push_back(pairOf(*told.remedy));
  for (const Told& told : told_) {
    std::string text = told.fault;
    if (told.remedy) {
      const ColumnRemedy& r = *told.remedy;
      text += (pairs.size() > 1 ? "write " + pairOf(r) + " into the columns of the mapping"
                                : line(r.column, r.as)) +
              r.after;
      faults_.askColumn(keyName(r.column), r.as);
    }
    if (pairs.size() > 1 && &told == &told_.back())
      text += "; all of these in one line of the mapping (--columns): columns: {" + joined(pairs, ", ") + "}";
    faults_.add(text);
  }
  told_.clear();
}

bool ColumnFaults::mapped(std::size_t i, const std::string& name) const {
  if (twice(i)) return name == std::to_string(i + 1);
  if (name == std::to_string(i + 1) || layout_.names[i] == name) return true;
  return counts_.count(name) == 0 && lower(layout_.names[i]) == lower(name);  // capitals tell two apart
}

void ColumnFaults::add(std::size_t i, const std::string& what) {
  told_.push_back({place() + "column " + called(i) + " " + what, {}});
}

void ColumnFaults::add(const std::string& what, const ColumnRemedy& remedy) {
  told_.push_back({what + "; ", remedy});
}

void ColumnFaults::add(std::size_t i, const std::string& what, const std::string& as,
                       const std::string& after) {
  add(place() + "column " + called(i) + " " + what, {i, as, after});
}

}  // namespace mm
