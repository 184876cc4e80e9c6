#include "import/column_faults.h"

#include <algorithm>

#include "base/text.h"

namespace mm {
namespace {

const std::string kIntoMapping = "add to the mapping (--columns): columns: {";

}  // namespace

std::string ColumnFaults::place() const { return file_.place(std::max<std::size_t>(1, layout_.headerLine)); }

bool ColumnFaults::twice(std::size_t i) const {
  return std::count(layout_.names.begin(), layout_.names.end(), layout_.names[i]) > 1;
}

std::string ColumnFaults::called(std::size_t i) const {
  return layout_.headerLine > 0 && !layout_.names[i].empty() ? "'" + layout_.names[i] + "'"
                                                             : std::to_string(i + 1);
}

std::string ColumnFaults::keyName(std::size_t i) const {
  const std::string& name = layout_.names[i];
  return layout_.headerLine == 0 || name.empty() || twice(i) ? std::to_string(i + 1) : name;
}

std::string ColumnFaults::key(std::size_t i) const {
  const std::string name = keyName(i);
  const bool plain = name.find_first_of(":#{}[],&*?|<>=!%@`'\"") == std::string::npos && name.front() != '-';
  return plain ? name : "'" + name + "'";
}

std::string ColumnFaults::remedy(std::size_t i, const std::string& as) const {
  return kIntoMapping + key(i) + ": " + as + "}";
}

void ColumnFaults::tell() {
  std::vector<std::string> pairs;
  const auto pairAt = [](const std::string& text, std::size_t at) {
    const std::size_t from = at + kIntoMapping.size();
    return text.substr(from, text.find('}', from) - from);
  };
  for (const std::string& text : told_)
    for (std::size_t at = text.find(kIntoMapping); at != std::string::npos;
         at = text.find(kIntoMapping, at + 1))
      if (std::find(pairs.begin(), pairs.end(), pairAt(text, at)) == pairs.end())
        pairs.push_back(pairAt(text, at));
  for (std::size_t k = 0; k < told_.size(); ++k) {
    std::string text = told_[k];
    if (pairs.size() > 1) {
      for (std::size_t at = text.find(kIntoMapping); at != std::string::npos; at = text.find(kIntoMapping)) {
        const std::string pair = pairAt(text, at);
        text.replace(at, kIntoMapping.size() + pair.size() + 1,
                     "write " + pair + " into the columns of the mapping");
      }
      if (k + 1 == told_.size())
        text +=
            "; all of these in one line of the mapping (--columns): columns: {" + joined(pairs, ", ") + "}";
    }
    faults_.add(text);
  }
  told_.clear();
}

bool ColumnFaults::mapped(std::size_t i, const std::string& name) const {
  if (twice(i)) return name == std::to_string(i + 1);
  if (name == std::to_string(i + 1) || layout_.names[i] == name) return true;
  const bool another = std::find(layout_.names.begin(), layout_.names.end(), name) != layout_.names.end();
  return !another && lower(layout_.names[i]) == lower(name);  // capitals tell two columns apart
}

void ColumnFaults::add(std::size_t i, const std::string& what) {
  add(place() + "column " + called(i) + " " + what);
}

}  // namespace mm
