#include "import/import_questions.h"

#include <algorithm>
#include <map>

#include "base/names_of.h"
#include "import/column_words.h"
#include "import/meaning.h"

namespace mm {
namespace {

void once(std::vector<std::string>& list, const std::string& text) {
  if (std::find(list.begin(), list.end(), text) == list.end()) list.push_back(text);
}

/// The suggestion in every unit of its kind, an error with either sign, and to leave the column out.
std::vector<std::string> likelyColumns(const std::string& suggested) {
  std::vector<std::string> likely{suggested};
  const NameAndUnit split = splitUnit(suggested);
  for (const char* sign : {"error", "deviation"})
    if (const std::size_t at = suggested.find('_');
        split.stem.rfind("error", 0) == 0 || split.stem.rfind("deviation", 0) == 0)
      once(likely, sign + suggested.substr(at));
  const auto unit = parseUnit(split.unitText);
  for (const std::string& other : unit ? factsOf(unit->kind).choices : std::vector<std::string>())
    if (suggested.size() > split.unitText.size())
      once(likely, suggested.substr(0, suggested.size() - split.unitText.size()) + other);
  once(likely, "ignore");
  return likely;
}

std::vector<std::string> likelyValues(const std::string& key, const std::string& suggested,
                                      const Machine& machine) {
  static const std::map<std::string, std::vector<std::string>> kWords = {
      {"decimal", {"comma", "point"}},
      {"date", {"month_first", "day_first"}},
      {"unit", {"um", "mm", "nm", "inch", "arcsec", "deg", "urad", "mrad"}},
      {"surface", {"flat"}},
      {"mount", {"equatorial"}},
      {"plane", {"xy", "yz", "zx"}}};
  std::vector<std::string> likely;
  const auto found = kWords.find(key);
  if (found == kWords.end() && key != "axis") return likely;
  likely.push_back(suggested);
  for (const std::string& word : key == "axis" ? allNames(machine.joints()) : found->second)
    once(likely, word);
  return likely;
}

}  // namespace

std::vector<ImportQuestion> questionsOf(const std::vector<MappingLine>& lines, const Machine& machine) {
  std::vector<ImportQuestion> asked;
  for (const MappingLine& line : lines)
    asked.push_back(
        {line.key, line.column, line.value,
         line.column.empty() ? likelyValues(line.key, line.value, machine) : likelyColumns(line.value)});
  return asked;
}

std::vector<ColumnChoice> columnChoices(const Machine& machine) {
  std::vector<ColumnChoice> choices;
  const auto addInWords = [&](const Meaning& meaning, const std::string& words, const std::string& group) {
    const std::string name = exampleOf(meaning, machine);
    const std::string own = meaning.kind ? splitUnit(name).unitText : "";
    if (own.empty()) return choices.push_back({name, words, group});
    for (const std::string& unit : factsOf(*meaning.kind).choices) {
      const auto read = parseUnit(unit, meaning.kind);
      choices.push_back({name.substr(0, name.size() - own.size()) + unit,
                         words + ", " + (read ? read->symbol : unit), group});
    }
  };
  const auto add = [&](const Meaning& meaning, const std::string& group) {
    addInWords(meaning, meaningText(meaning, machine), group);
  };
  for (int j = 0; j < machine.jointCount(); ++j) {
    const std::string group = "joint " + machine.joints()[j].name;
    add(meaningOf(CsvRole::kPosition, j, machine), group);
    add(meaningOf(CsvRole::kMeasured, j, machine), group);
    Meaning deviation = meaningOf(CsvRole::kDeviation, j, machine);
    const std::string of = " of " + machine.joints()[j].name;
    addInWords(deviation, "deviation" + of + ", true minus indicated (actual minus target)", group);
    deviation.reversed = true;
    addInWords(deviation, "error" + of + ", indicated minus true", group);
    add(meaningOf(CsvRole::kDirection, j, machine), group);
    add(meaningOf(CsvRole::kVelocity, j, machine), group);
  }
  for (int k = 0; k < 3; ++k) add(meaningOf(CsvRole::kReference, k, machine), "independent instrument");
  for (const CsvRole role : {CsvRole::kFeature, CsvRole::kTime, CsvRole::kReading, CsvRole::kSetup})
    add(meaningOf(role, 0, machine), "other");
  choices.push_back({"ignore", "leave it out", "other"});
  return choices;
}

}  // namespace mm
