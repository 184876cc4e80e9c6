#include "import/name_reader.h"

#include <algorithm>
#include <cctype>

#include "base/error.h"
#include "base/text.h"

namespace mm {

std::pair<std::set<WordClass>, int> NameReader::classesOf(const std::vector<std::string>& words,
                                                          std::vector<std::string>* rest) const {
  std::set<WordClass> classes;
  int joint = -1;
  // a joint's own name may have several words
  const std::string all = "_" + joined(words, "_") + "_";
  std::string taken;
  for (int j = 0; j < machine_.jointCount(); ++j) {
    const std::string name = joined(wordsOf(machine_.joints()[j].name), "_");
    if (all.find("_" + name + "_") != std::string::npos && name.size() > taken.size())
      joint = j, taken = name;
  }
  const std::vector<std::string> own = wordsOf(taken);
  for (const std::string& word : words) {
    if (std::find(own.begin(), own.end(), word) != own.end()) continue;
    if (const auto known = classOf(word)) {
      classes.insert(*known);
    } else if (!splitWord(word, classes, joint) && rest != nullptr) {
      rest->push_back(word);
    }
  }
  return {classes, joint};
}

/// `xref`, `posx`, `vx`, `dx`: a joint and a word in one.
bool NameReader::splitWord(const std::string& word, std::set<WordClass>& classes, int& joint) const {
  for (int j = 0; j < machine_.jointCount(); ++j) {
    const std::string name = lower(machine_.joints()[j].name);
    for (const bool before : {true, false}) {
      if (word.size() <= name.size()) continue;
      const std::string other = before ? word.substr(name.size()) : word.substr(0, word.size() - name.size());
      if ((before ? word.substr(0, name.size()) : word.substr(other.size())) != name) continue;
      const auto known = classOf(other);
      const bool v = !before && other == "v", d = !before && (other == "d" || other == "δ");
      if (!v && !d && (!known || other.size() < 3)) continue;
      if (joint >= 0 && joint != j) continue;
      joint = j;
      classes.insert(v ? WordClass::kVelocity : d ? WordClass::kError : *known);
      return true;
    }
  }
  return false;
}

std::optional<Meaning> NameReader::ownFormat(const std::string& name) const {
  try {
    const CsvColumn c = parseCsvHeader({name}, machine_, "").front();
    if (c.role == CsvRole::kCovariate) return std::nullopt;
    return meaningOf(c, machine_);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// A quantity of one joint; without one, of the axis that the file or the mapping tells.
Meaning NameReader::ofJoint(CsvRole role, int joint, const NameContext& context) const {
  const bool own = joint >= 0;
  if (!own) joint = context.axis;
  Meaning m = meaningOf(role, std::max(0, joint), machine_);
  m.axisOfTable = !own && joint >= 0;
  m.needsAxis = joint < 0;
  return m;
}

std::optional<Meaning> NameReader::byWords(const std::string& stem, const std::optional<Unit>& unit,
                                           const ColumnSample& sample, bool said,
                                           const NameContext& table) const {
  using W = WordClass;
  std::vector<std::string> rest;
  const std::vector<std::string> words = wordsOf(stem);
  const auto [classes, joint] = classesOf(words, &rest);
  // a letter that is no joint of the machine names another one's: not the joint of the table
  const bool another = std::any_of(rest.begin(), rest.end(), [](const std::string& word) {
    return word.size() == 1 && std::isalpha(static_cast<unsigned char>(word[0])) != 0;
  });
  NameContext context = table;
  if (another) context.axis = -1;
  const auto has = [&c = classes](WordClass w) { return c.count(w) > 0; };
  if ((unit && unit->kind == UnitKind::kTemperature) || has(W::kTemperature)) return temperature(words);
  if (has(W::kNote)) return leftOut("a note");
  if (has(W::kFeature)) return meaningOf(CsvRole::kFeature, 0, machine_);
  if (has(W::kSetup)) return meaningOf(CsvRole::kSetup, 0, machine_);
  if (has(W::kPlacement)) return meaningOf(CsvRole::kPlacement, 0, machine_);
  if (has(W::kStylus)) return meaningOf(CsvRole::kStylus, 0, machine_);
  if (has(W::kDirection)) return ofJoint(CsvRole::kDirection, joint, context);
  if (has(W::kRun) && joint < 0) return leftOut("number of the run; the order of the rows keeps it");
  // what a display shows in um is a gauge's, in mm it is where the axis stands
  const bool gauge = has(W::kDisplay) && unit && unit->ofAGauge();
  if (has(W::kDeviation) || has(W::kError) || gauge) {
    const bool error = has(W::kError) || gauge;
    Meaning m = ofJoint(has(W::kStd) ? CsvRole::kDeviationStd : CsvRole::kDeviation, joint, context);
    m.reversed = said && error && !has(W::kStd);
    m.unclearSign = !said && error && !has(W::kDeviation) && !has(W::kStd);
    return m;
  }
  if (has(W::kReference) && joint >= 0) {
    const std::string name = lower(machine_.joints()[joint].name);
    if (name == "x" || name == "y" || name == "z")
      return meaningOf(CsvRole::kReference, name[0] - 'x', machine_);
  }
  if (has(W::kVelocity)) return ofJoint(CsvRole::kVelocity, joint, context);
  if (has(W::kMeasured) && (context.hasTarget || said)) return ofJoint(CsvRole::kMeasured, joint, context);
  if (has(W::kTarget)) return ofJoint(CsvRole::kPosition, joint, context);
  if (has(W::kReading) && joint < 0) return meaningOf(CsvRole::kReading, 0, machine_);
  if ((has(W::kTime) || has(W::kDate)) && joint < 0 && (rest.empty() || said)) {
    const bool dayOnly =
        sample.calendars + sample.slashed > 0 && sample.midnight && context.timeColumns > 0 && !has(W::kTime);
    return meaningOf(dayOnly ? CsvRole::kDate : CsvRole::kTime, 0, machine_);
  }
  if (joint >= 0 && rest.empty()) return meaningOf(CsvRole::kPosition, joint, machine_);
  if ((has(W::kFiller) || has(W::kDisplay)) && joint < 0 && rest.empty() && (sample.numbers > 0 || said))
    return ofJoint(CsvRole::kPosition, -1, context);
  if (joint < 0 && rest.empty() && (has(W::kIndex) || words.empty())) return leftOut("number of the row");
  return std::nullopt;
}

Meaning NameReader::temperature(const std::vector<std::string>& words) const {
  std::string name;
  for (const std::string& w : words) {
    if (classOf(w) == WordClass::kTemperature) continue;
    std::string plain;
    for (const char c : w)
      if (std::isalnum(static_cast<unsigned char>(c)) != 0) plain += c;
    if (!plain.empty()) name += (name.empty() ? "" : "_") + plain;
  }
  return meaningOf(CsvRole::kTemperature, 0, machine_, name.empty() ? "temperature" : name);
}

std::optional<Meaning> NameReader::covariate(const std::string& name, NameAndUnit& split,
                                             const std::optional<Unit>& unit,
                                             const ColumnSample& sample) const {
  if (unit || sample.texts > 0) return std::nullopt;
  if (split.unitText.empty()) {  // any last word may be a unit, as in the package's own format
    const std::size_t cut = name.rfind('_');
    if (cut == std::string::npos || cut == 0 || classOf(lower(name.substr(cut + 1)))) return std::nullopt;
    split = {name.substr(0, cut), name.substr(cut + 1)};
  }
  try {
    std::string symbol = split.unitText == "%" ? "percent" : split.unitText;
    for (char& c : symbol)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    const std::string plain = joined(wordsOf(split.stem), "_");
    const CsvColumn c = parseCsvHeader({plain + "_" + symbol}, machine_, "").front();
    if (c.role != CsvRole::kCovariate) return std::nullopt;
    return meaningOf(CsvRole::kCovariate, 0, machine_, c.name);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace mm
