#include "import/table_remarks.h"

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "base/text.h"
#include "import/column_words.h"
#include "import/meaning.h"
#include "import/unit.h"

namespace mm {
namespace {

bool beginsWithAny(const std::string& word, std::initializer_list<const char*> starts) {
  return std::any_of(starts.begin(), starts.end(), [&](const char* s) { return startsWith(word, s); });
}

void readUnits(const std::string& text, std::size_t line, TableRemarks& remarks) {
  const std::vector<std::string> words = wordsOf(text);
  constexpr std::size_t kNear = 4;  // words
  for (std::size_t w = 0; w < words.size(); ++w) {
    const bool length = beginsWithAny(words[w], {"length", "position", "unit", "dimension"});
    const bool angle = beginsWithAny(words[w], {"angle", "rotar"});
    if (!length && !angle) continue;
    for (std::size_t k = w + 1; k < std::min(words.size(), w + kNear); ++k) {
      const auto unit = words[k] == "in" ? std::nullopt : parseUnit(words[k]);
      const bool inInch = k + 1 == words.size() && words[k] == "in" && words[k - 1] == "in";
      if (length && (inInch || (unit && unit->kind == UnitKind::kLength)))
        remarks.length = {inInch ? "inch" : words[k], line};
      else if (unit && unit->kind == UnitKind::kAngle)
        remarks.angle = {words[k], line};
      else
        continue;
      break;
    }
  }
}

/// Adds the joints that a line names beside the word axis: "Interferometer, axis X", "X-Achse".
void readAxes(const std::string& text, std::size_t line, const Machine& machine,
              std::map<int, std::size_t>& named) {
  const std::vector<std::string> words = wordsOf(text);
  for (std::size_t w = 0; w < words.size(); ++w) {
    if (words[w] != "axis" && words[w] != "achse" && words[w] != "axe") continue;
    for (const std::size_t beside : {w + 1, w - 1})
      if (const int j = beside < words.size() ? jointOf(machine, words[beside]) : -1; j >= 0) {
        named.emplace(j, line);
        break;
      }
  }
}

}  // namespace

TableRemarks tableRemarks(const TableLayout& layout, const Machine& machine) {
  TableRemarks remarks;
  std::map<int, std::size_t> named;
  for (const auto& [line, text] : layout.remarks) {
    readUnits(text, line, remarks);
    readAxes(text, line, machine, named);
    std::string name, value;
    if (!keyValue(text, name, value) || (name != "axis" && name != "achse" && name != "axe")) continue;
    if (const int j = jointOf(machine, value); j >= 0) remarks.axis = j;
  }
  if (remarks.axis < 0 && named.size() == 1) {
    remarks.axis = named.begin()->first;
    remarks.axisLine = named.begin()->second;
  }
  return remarks;
}

}  // namespace mm
