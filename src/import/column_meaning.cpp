#include "import/column_meaning.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/units.h"

namespace mm {
namespace {

std::string joined(const std::vector<std::string>& words, const char* with) {
  std::string text;
  for (const std::string& w : words) text += (text.empty() ? "" : with) + w;
  return text;
}

/// What a column is, before its unit is looked at.
struct Meaning {
  CsvRole role = CsvRole::kIgnored;
  int index = 0;
  std::string name;              // of a sensor or covariate
  std::string why;               // of a column that is left out
  bool reversed = false;         // an error (indicated minus true) is a deviation with its sign changed
  std::optional<UnitKind> kind;  // what its unit must be
  bool needsAxis = false;        // which joint is not said
  bool unclearSign = false;      // "error"
};

class TableUnderstander {
 public:
  TableUnderstander(const TextFile& file, const TableLayout& layout, const ColumnMapping& mapping,
                    const Machine& machine, const Artifact* artifact, FaultList& faults)
      : file_(file),
        layout_(layout),
        mapping_(mapping),
        machine_(machine),
        artifact_(artifact),
        faults_(faults),
        samples_(columnSamples(file, layout)) {}

  UnderstoodTable understand() {
    table_.form.separator = layout_.separator;
    table_.form.decimalComma = layout_.decimalComma;
    table_.form.headerLine = static_cast<std::int64_t>(layout_.lastHead());
    table_.form.features = mapping_.features;
    readRemarks();
    checkMapping();
    fixedJoints();
    lookAhead();
    if (layout_.headerLine == 0 && mapping_.columns.empty())
      nameless();
    else
      for (std::size_t i = 0; i < layout_.names.size(); ++i) column(i);
    if (!table_.columns.empty()) whole();
    return std::move(table_);
  }

 private:
  std::string place() const { return file_.place(std::max<std::size_t>(1, layout_.headerLine)); }

  std::string called(std::size_t i) const {
    return layout_.headerLine > 0 && !layout_.names[i].empty() ? "'" + layout_.names[i] + "'"
                                                               : std::to_string(i + 1);
  }
  /// The key of a column in the mapping.
  std::string key(std::size_t i) const {
    const std::string& name = layout_.names[i];
    const bool twice = std::count(layout_.names.begin(), layout_.names.end(), name) > 1;
    if (layout_.headerLine == 0 || name.empty() || twice) return std::to_string(i + 1);
    const bool plain =
        name.find_first_of(":#{}[],&*?|<>=!%@`'\"") == std::string::npos && name.front() != '-';
    return plain ? name : "'" + name + "'";
  }
  std::string line(std::size_t i, const std::string& as) const {
    return "write into the mapping (--columns): columns: {" + key(i) + ": " + as + "}";
  }
  void fault(std::size_t i, const std::string& what) {
    faults_.add(place() + "column " + called(i) + " " + what);
  }

  /// Units and the axis, said in words above the table.
  void readRemarks() {
    for (const auto& [number, text] : layout_.remarks) {
      const std::vector<std::string> words = wordsOf(text);
      for (std::size_t w = 0; w < words.size(); ++w) {
        const bool length = words[w].rfind("length", 0) == 0 || words[w].rfind("position", 0) == 0 ||
                            words[w].rfind("unit", 0) == 0 || words[w].rfind("dimension", 0) == 0;
        const bool angle = words[w].rfind("angle", 0) == 0 || words[w].rfind("rotar", 0) == 0;
        if (!length && !angle) continue;
        for (std::size_t k = w + 1; k < std::min(words.size(), w + 4); ++k) {
          const auto unit = words[k] == "in" ? std::nullopt : parseUnit(words[k]);
          const bool last = k + 1 == words.size() && words[k] == "in" && words[k - 1] == "in";
          if (length && (last || (unit && unit->kind == UnitKind::kLength)))
            lengthUnit_ = {last ? "inch" : words[k], number};
          else if (unit && unit->kind == UnitKind::kAngle)
            angleUnit_ = {words[k], number};
          else
            continue;
          break;
        }
      }
      std::string name, value;
      if (keyValue(text, name, value) && (name == "axis" || name == "achse" || name == "axe")) {
        const int j = jointNamed(lower(value));
        if (j >= 0) axis_ = j;
      }
    }
    if (const std::string said = mapping_.setting("axis"); !said.empty()) {
      axis_ = machine_.findJoint(said);
      if (axis_ < 0)
        faults_.add(mapping_.source + ":" + std::to_string(mapping_.lines.at("axis")) + ": axis: '" + said +
                    "' is no joint of machine '" + machine_.name() + "' (" + joints() + ")");
    }
    if (axis_ < 0 && machine_.jointCount() == 1) axis_ = 0;
  }

  std::string joints() const {
    std::vector<std::string> names;
    for (const Joint& j : machine_.joints()) names.push_back(j.name);
    return listOf(names);
  }

  /// Names of the mapping that are not in the file are misspelt.
  void checkMapping() {
    for (const auto& [name, as] : mapping_.columns) {
      bool found = false;
      for (std::size_t i = 0; i < layout_.names.size(); ++i) found |= mapped(i, name);
      if (!found)
        faults_.add(mapping_.source + ": columns: '" + name + "' is not in " + file_.path().string() + " (" +
                    listOf(layout_.names) + ")" + didYouMean(name, layout_.names));
    }
  }

  bool mapped(std::size_t i, const std::string& name) const {
    const bool twice = std::count(layout_.names.begin(), layout_.names.end(), layout_.names[i]) > 1;
    if (twice) return name == std::to_string(i + 1);
    return layout_.names[i] == name || name == std::to_string(i + 1) ||
           lower(layout_.names[i]) == lower(name);
  }

  void fixedJoints() {
    for (const auto& [name, value] : mapping_.fixed) {
      const NameAndUnit split = splitUnit(name);
      const int j = jointNamed(lower(split.stem));
      const auto kind = j >= 0 ? kindOf(j) : UnitKind::kLength;
      const auto unit = parseUnit(split.unitText, kind);
      if (j < 0 || !unit) {
        faults_.add(mapping_.source + ": fixed: '" + name + "' is not <joint>_<unit> of this machine (" +
                    joints() + "); e.g. fixed: {" + machine_.joints().front().name + "_mm: 12.5}");
        continue;
      }
      table_.form.fixed.emplace_back(j, value * unit->factor);
    }
  }

  UnitKind kindOf(int joint) const {
    return machine_.joints()[joint].kind == JointKind::kLinear ? UnitKind::kLength : UnitKind::kAngle;
  }

  int jointNamed(const std::string& word) const {
    for (int j = 0; j < machine_.jointCount(); ++j)
      if (lower(machine_.joints()[j].name) == word) return j;
    return -1;
  }

  /// Which other columns there are decides what "measured" and "date" mean.
  void lookAhead() {
    for (std::size_t i = 0; i < layout_.names.size(); ++i) {
      const auto classes = classesOf(wordsOf(splitUnit(layout_.names[i]).stem)).first;
      hasTarget_ |= classes.count(WordClass::kTarget) > 0;
      hasFeature_ |= classes.count(WordClass::kFeature) > 0;
      hasTime_ |= classes.count(WordClass::kTime) + classes.count(WordClass::kDate) > 0;
      timeColumns_ += classes.count(WordClass::kTime) > 0 && samples_[i].clocks + samples_[i].numbers > 0;
    }
    for (const auto& [name, as] : mapping_.columns) {
      hasTarget_ |= as.rfind("target", 0) == 0;
      hasFeature_ |= as == "feature";
      hasTime_ |= as.rfind("time", 0) == 0;
    }
  }

  /// The classes of a name's words, its joint (-1: none), and words that say nothing.
  std::pair<std::set<WordClass>, int> classesOf(const std::vector<std::string>& words,
                                                std::vector<std::string>* rest = nullptr) const {
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
      const auto known = wordClasses().find(word);
      if (known != wordClasses().end()) {
        classes.insert(known->second);
      } else if (!splitWord(word, classes, joint) && rest != nullptr) {
        rest->push_back(word);
      }
    }
    return {classes, joint};
  }

  /// `xref`, `dx`, `posx`: a joint and a word in one.
  bool splitWord(const std::string& word, std::set<WordClass>& classes, int& joint) const {
    for (int j = 0; j < machine_.jointCount(); ++j) {
      const std::string name = lower(machine_.joints()[j].name);
      for (const bool before : {true, false}) {
        if (word.size() <= name.size()) continue;
        const std::string other =
            before ? word.substr(name.size()) : word.substr(0, word.size() - name.size());
        if ((before ? word.substr(0, name.size()) : word.substr(other.size())) != name) continue;
        const auto known = wordClasses().find(other);
        const bool v = !before && other == "v";
        if (!v && (known == wordClasses().end() || other.size() < 3)) continue;
        if (joint >= 0 && joint != j) continue;
        joint = j;
        classes.insert(v ? WordClass::kVelocity : known->second);
        return true;
      }
    }
    return false;
  }

  /// The columns of the package's own format are understood as they always were.
  std::optional<Meaning> ownFormat(const std::string& name) const {
    try {
      const CsvColumn c = parseCsvHeader({name}, machine_, "").front();
      if (c.role == CsvRole::kCovariate) return std::nullopt;
      Meaning m;
      m.role = c.role;
      m.index = c.index;
      m.name = c.name;
      m.kind = kindFor(c.role, c.index);
      return m;
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  std::optional<UnitKind> kindFor(CsvRole role, int index) const {
    switch (role) {
      case CsvRole::kTime:
        return UnitKind::kTime;
      case CsvRole::kPosition:
      case CsvRole::kDeviation:
      case CsvRole::kDeviationStd:
      case CsvRole::kMeasured:
        return kindOf(index);
      case CsvRole::kVelocity:
        return kindOf(index) == UnitKind::kLength ? UnitKind::kSpeed : UnitKind::kTurning;
      case CsvRole::kReading:
      case CsvRole::kReference:
        return UnitKind::kLength;
      case CsvRole::kTemperature:
        return UnitKind::kTemperature;
      default:
        return std::nullopt;
    }
  }

  Meaning make(CsvRole role, int index, const std::string& name = "") const {
    Meaning m;
    m.role = role;
    m.index = index;
    m.name = name;
    m.kind = kindFor(role, index);
    return m;
  }

  Meaning leftOut(const std::string& why) const {
    Meaning m;
    m.why = why;
    return m;
  }

  /// A quantity of one joint; without one, of the axis that the file or the mapping tells.
  Meaning ofJoint(CsvRole role, int joint) const {
    if (joint < 0) joint = axis_;
    Meaning m = make(role, std::max(0, joint));
    m.needsAxis = joint < 0;
    return m;
  }

  /// By its words. @param said in the mapping, where words count as they stand.
  std::optional<Meaning> byWords(const std::string& stem, const std::optional<Unit>& unit,
                                 const ColumnSample& sample, bool said) const {
    using W = WordClass;
    std::vector<std::string> rest;
    const std::vector<std::string> words = wordsOf(stem);
    const auto [classes, joint] = classesOf(words, &rest);
    const auto has = [&c = classes](WordClass w) { return c.count(w) > 0; };
    if ((unit && unit->kind == UnitKind::kTemperature) || has(W::kTemperature)) return temperature(words);
    if (has(W::kNote)) return leftOut("a note");
    if (has(W::kFeature)) return make(CsvRole::kFeature, 0);
    if (has(W::kSetup)) return make(CsvRole::kSetup, 0);
    if (has(W::kDirection)) return ofJoint(CsvRole::kDirection, joint);
    if (has(W::kRun) && joint < 0) return leftOut("number of the run; the order of the rows keeps it");
    if (has(W::kDeviation) || has(W::kError)) {
      Meaning m = ofJoint(has(W::kStd) ? CsvRole::kDeviationStd : CsvRole::kDeviation, joint);
      m.reversed = said && has(W::kError) && !has(W::kStd);
      m.unclearSign = !said && has(W::kError) && !has(W::kDeviation) && !has(W::kStd);
      return m;
    }
    if (has(W::kReference) && joint >= 0) {
      const std::string name = lower(machine_.joints()[joint].name);
      if (name == "x" || name == "y" || name == "z") return make(CsvRole::kReference, name[0] - 'x');
    }
    if (has(W::kVelocity)) return ofJoint(CsvRole::kVelocity, joint);
    if (has(W::kMeasured) && (hasTarget_ || said)) return ofJoint(CsvRole::kMeasured, joint);
    if (has(W::kTarget)) return ofJoint(CsvRole::kPosition, joint);
    if (has(W::kReading) && joint < 0) return make(CsvRole::kReading, 0);
    if ((has(W::kTime) || has(W::kDate)) && joint < 0 && (rest.empty() || said))
      return time(has(W::kTime), sample);
    if (joint >= 0 && rest.empty()) return make(CsvRole::kPosition, joint);
    if (has(W::kFiller) && joint < 0 && rest.empty() && (sample.numbers > 0 || said))
      return ofJoint(CsvRole::kPosition, -1);
    if (joint < 0 && rest.empty() && (has(W::kIndex) || words.empty())) return leftOut("number of the row");
    return std::nullopt;
  }

  Meaning time(bool named, const ColumnSample& sample) const {
    const bool dayOnly =
        sample.calendars + sample.slashed > 0 && sample.midnight && timeColumns_ > 0 && !named;
    return make(dayOnly ? CsvRole::kDate : CsvRole::kTime, 0);
  }

  Meaning temperature(const std::vector<std::string>& words) const {
    std::string name;
    for (const std::string& w : words) {
      const auto known = wordClasses().find(w);
      if (known != wordClasses().end() && known->second == WordClass::kTemperature) continue;
      std::string plain;
      for (const char c : w)
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) plain += c;
      if (!plain.empty()) name += (name.empty() ? "" : "_") + plain;
    }
    return make(CsvRole::kTemperature, 0, name.empty() ? "temperature" : name);
  }

  /// Anything else that was logged, where its name has a unit that no reading of this machine has.
  std::optional<Meaning> covariate(const std::string& name, NameAndUnit& split,
                                   const std::optional<Unit>& unit, const ColumnSample& sample) const {
    if (unit || sample.texts > 0) return std::nullopt;
    if (split.unitText.empty()) {  // any last word may be a unit, as in the package's own format
      const std::size_t cut = name.rfind('_');
      if (cut == std::string::npos || cut == 0 || wordClasses().count(lower(name.substr(cut + 1))) > 0)
        return std::nullopt;
      split = {name.substr(0, cut), name.substr(cut + 1)};
    }
    try {
      std::string symbol = split.unitText == "%" ? "percent" : split.unitText;
      for (char& c : symbol)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
      const std::string plain = joined(wordsOf(split.stem), "_");
      const CsvColumn c = parseCsvHeader({plain + "_" + symbol}, machine_, "").front();
      if (c.role != CsvRole::kCovariate) return std::nullopt;
      return make(CsvRole::kCovariate, 0, c.name);
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  /// A table without names: one line says them all.
  void nameless() {
    std::string all;
    for (std::size_t i = 0; i < layout_.names.size(); ++i) {
      const bool constant = samples_[i].lower == samples_[i].upper && samples_[i].numbers > 0;
      const std::string joint = constant || samples_[i].numbers == 0 ? "" : freeJoint(UnitKind::kLength);
      all += (i > 0 ? ", " : "") + std::to_string(i + 1) + ": " + (joint.empty() ? "ignore" : joint + "_mm");
    }
    faults_.add(place() + "no line names the " + std::to_string(layout_.names.size()) +
                " columns; write into the mapping (--columns) what they hold, e.g. columns: {" + all +
                "}, or put a line of names above the rows");
  }

  void column(std::size_t i) {
    UnderstoodColumn seen;
    const ColumnSample& sample = samples_[i];
    seen.name = layout_.headerLine > 0 && !layout_.names[i].empty() ? layout_.names[i]
                                                                    : "column " + std::to_string(i + 1);
    seen.first = sample.first;
    if (sample.numbers > 0) seen.range = format("%.6g … %.6g", sample.lower, sample.upper);
    std::string as;
    for (const auto& [name, value] : mapping_.columns)
      if (mapped(i, name)) as = value;
    CsvColumn c;
    c.header = layout_.names[i];
    c.role = CsvRole::kIgnored;
    const bool said = !as.empty();
    if (as == "ignore" || (!said && mapping_.ignoreOthers && !mapping_.columns.empty())) {
      seen.meaning = "left out: the mapping says so";
    } else {
      understand(i, as, c, seen);
    }
    table_.form.columns.push_back(std::move(c));
    table_.columns.push_back(std::move(seen));
  }

  void understand(std::size_t i, const std::string& as, CsvColumn& c, UnderstoodColumn& seen) {
    const ColumnSample& sample = samples_[i];
    const bool said = !as.empty();
    const std::string name = said ? as : layout_.names[i];
    if (name.empty() && sample.count == 0) {
      seen.meaning = "left out: empty";
      return;
    }
    NameAndUnit split = splitUnit(name);
    if (said && split.unitText.empty()) split.unitText = splitUnit(layout_.names[i]).unitText;
    std::optional<Meaning> meaning = ownFormat(name);
    // a unit of the words' own kind first: m is metres of a length
    const std::optional<Unit> unit = parseUnit(split.unitText.empty() ? layout_.units[i] : split.unitText);
    if (!meaning) meaning = byWords(split.stem, unit, sample, said);
    if (!meaning) meaning = covariate(name, split, unit, sample);
    if (!meaning && !said && layout_.headerLine > 0 && sample.texts > 0 && sample.numbers == 0 && isLabels(i))
      meaning = make(CsvRole::kFeature, 0);
    const bool stamps = sample.count > 0 && sample.calendars + sample.slashed + sample.clocks == sample.count;
    if (!meaning && !said && stamps && !hasTime_) meaning = make(CsvRole::kTime, 0), hasTime_ = true;
    if (!meaning) {
      unknown(i, name, said, unit);
      return;
    }
    if (meaning->unclearSign) {
      const std::string joint = machine_.joints()[meaning->index].name;
      const std::string u = unit                                                           ? unit->symbol
                            : machine_.joints()[meaning->index].kind == JointKind::kLinear ? "um"
                                                                                           : "arcsec";
      fault(i,
            "is an error, and whether it is indicated minus true (VIM) or actual minus target (ISO 230-2) is "
            "not "
            "said; " +
                line(i, "error_" + joint + "_" + u) + " for the first, deviation_" + joint + "_" + u +
                " for the second" + (meaning->needsAxis ? " (joints: " + joints() + ")" : ""));
      return;
    }
    if (meaning->needsAxis) {
      fault(i, "does not say of which joint it is (" + joints() +
                   "); write into the mapping (--columns): axis: " + machine_.joints().front().name +
                   " (for all such columns), or columns: {" + key(i) + ": " + example(*meaning) + "}");
      return;
    }
    take(i, *meaning, split, said, c, seen);
  }

  /// A column of few different words, in which there are names of the artifact.
  bool isLabels(std::size_t i) const {
    if (artifact_ == nullptr) return false;
    const std::string first = samples_[i].first;
    for (const Feature& f : artifact_->features)
      if (lower(f.name) == lower(first)) return true;
    return mapping_.features.count(first) > 0;
  }

  void unknown(std::size_t i, const std::string& name, bool said, const std::optional<Unit>& unit) {
    std::vector<std::string> own = {"time_s", "feature", "setup", "reading_mm"};
    for (const Joint& j : machine_.joints()) {
      const bool linear = j.kind == JointKind::kLinear;
      own.push_back(j.name + (linear ? "_mm" : "_deg"));
      own.push_back(j.name + (linear ? "_velocity_mm_s" : "_velocity_deg_s"));
      own.push_back("deviation_" + j.name + (linear ? "_um" : "_arcsec"));
    }
    for (const char* r : {"reference_x_mm", "reference_y_mm", "reference_z_mm"}) own.emplace_back(r);
    const std::string near = nearestName(name, own);
    if (said) {
      faults_.add(
          mapping_.source + ": columns: '" + key(i) + ": " + name +
          "' is not understood; write <joint>_<unit>, deviation_<joint>_<unit>, reference_x_mm, feature, "
          "time_s, <sensor>_degC, <name>_<unit> or ignore (joints: " +
          joints() + ")" + didYouMean(name, own));
      return;
    }
    if (layout_.headerLine == 0) {
      fault(i, "is not in the mapping" +
                   (samples_[i].numbers > 0 ? format(" (%.6g … %.6g)", samples_[i].lower, samples_[i].upper)
                                            : " ('" + samples_[i].first + "')") +
                   "; " +
                   line(i, i < static_cast<std::size_t>(machine_.jointCount()) ? own[4 + 3 * i] : "ignore"));
      return;
    }
    const std::string plain = joined(wordsOf(splitUnit(name).stem), "_");
    std::string as = !near.empty() ? near : "ignore", or_ = "";
    if (near.empty())
      or_ = ", or say what it holds (joints: " + joints() + "; " + plain + "_<unit> of anything else)";
    const bool measured = classesOf(wordsOf(name)).first.count(WordClass::kMeasured) > 0;
    if (near.empty() && !measured && unit &&
        (unit->kind == UnitKind::kLength || unit->kind == UnitKind::kAngle)) {
      const std::string joint = freeJoint(unit->kind);
      if (!joint.empty()) as = joint + "_" + unit->symbol;
    } else if (near.empty() && measured) {
      as = "measured_" + machine_.joints()[std::max(0, axis_)].name + "_mm";
    } else if (near.empty() && samples_[i].texts > 0 && !hasFeature_ && samples_[i].numbers == 0) {
      as = "feature";
      or_ = ", or ignore";
    }
    fault(i, (layout_.names[i].empty() ? std::string("has no name")
                                       : std::string("is unknown on this machine")) +
                 didYouMean(name, own) + "; " + line(i, as) + or_);
  }

  /// The next joint of that kind for which no column was suggested yet.
  std::string freeJoint(UnitKind kind) {
    for (int j = 0; j < machine_.jointCount(); ++j)
      if (kindOf(j) == kind && taken_.count(meaningText(make(CsvRole::kPosition, j))) == 0 &&
          suggested_.insert(j).second)
        return machine_.joints()[j].name;
    return "";
  }

  /// The unit of a column: of its name, of the units line, of the remarks, or the only one that is possible.
  std::optional<Unit> unitFor(std::size_t i, const Meaning& m, const NameAndUnit& split, bool said,
                              std::string& from) {
    if (!split.unitText.empty()) {
      from = said ? "mapping" : "header";
      const auto unit = parseUnit(split.unitText, m.kind);
      if (!unit)
        fault(i, "is in '" + split.unitText + "', but " + meaningText(m) + " is " + unitsOf(*m.kind) + "; " +
                     line(i, example(m)));
      return unit;
    }
    if (!layout_.units[i].empty()) {
      from = "line " + std::to_string(layout_.unitsLine);
      const auto unit = parseUnit(layout_.units[i], m.kind);
      if (!unit)
        fault(i, "is in '" + layout_.units[i] + "' (line " + std::to_string(layout_.unitsLine) + "), but " +
                     meaningText(m) + " is " + unitsOf(*m.kind) + "; " + line(i, example(m)));
      return unit;
    }
    if (!samples_[i].suffix.empty()) {
      from = "cells";
      const auto unit = parseUnit(samples_[i].suffix, m.kind);
      if (!unit)
        fault(i, "is in '" + samples_[i].suffix + "', but " + meaningText(m) + " is " + unitsOf(*m.kind) +
                     "; " + line(i, example(m)));
      return unit;
    }
    const auto& remark = *m.kind == UnitKind::kAngle ? angleUnit_ : lengthUnit_;
    if ((*m.kind == UnitKind::kLength || *m.kind == UnitKind::kAngle) && remark.second > 0) {
      from = "line " + std::to_string(remark.second);
      return parseUnit(remark.first, m.kind);
    }
    if (auto unit = byRange(i, m)) {
      from = "its range";
      return unit;
    }
    fault(i, "(" + meaningText(m) + format(", %.6g … %.6g", samples_[i].lower, samples_[i].upper) +
                 ") has no unit, and its values do not tell; " + line(i, example(m)) +
                 " (or another unit: " + unitsOf(*m.kind) + ")");
    return std::nullopt;
  }

  std::string example(const Meaning& m) const {
    const bool linear = m.role == CsvRole::kReference || m.role == CsvRole::kReading ||
                        m.role == CsvRole::kTime || m.role == CsvRole::kTemperature ||
                        machine_.joints()[m.index].kind == JointKind::kLinear;
    const std::string joint = m.role == CsvRole::kReference
                                  ? ""
                                  : machine_.joints()[std::min(m.index, machine_.jointCount() - 1)].name;
    switch (m.role) {
      case CsvRole::kTime:
        return "time_s";
      case CsvRole::kReading:
        return "reading_mm";
      case CsvRole::kReference:
        return std::string("reference_") + "xyz"[m.index] + "_mm";
      case CsvRole::kTemperature:
        return m.name + "_degC";
      case CsvRole::kDeviation:
        return (m.reversed ? "error_" : "deviation_") + joint + (linear ? "_um" : "_arcsec");
      case CsvRole::kDeviationStd:
        return "deviation_" + joint + "_std" + (linear ? "_um" : "_arcsec");
      case CsvRole::kVelocity:
        return joint + (linear ? "_velocity_mm_s" : "_velocity_deg_s");
      case CsvRole::kMeasured:
        return "measured_" + joint + (linear ? "_mm" : "_deg");
      default:
        return joint + (linear ? "_mm" : "_deg");
    }
  }

  /// Where only one unit is possible: a machine's joint can go so far and no farther, and is not measured
  /// within a hundredth of its travel; a workshop has 5 to 45 degC, or a kelvin scale begins above 200.
  std::optional<Unit> byRange(std::size_t i, const Meaning& m) {
    const ColumnSample& s = samples_[i];
    if (s.numbers == 0) return std::nullopt;
    if (m.role == CsvRole::kTemperature) {
      if (s.lower >= 5.0 && s.upper <= 45.0) return parseUnit("degC", m.kind);
      if (s.lower >= 250.0 && s.upper <= 400.0) return parseUnit("K", m.kind);
      return std::nullopt;
    }
    if (m.role != CsvRole::kPosition && m.role != CsvRole::kMeasured) return std::nullopt;
    const Joint& joint = machine_.joints()[m.index];
    const double travel = joint.upper - joint.lower;
    if (!std::isfinite(travel) || travel <= 0.0) return std::nullopt;
    const bool linear = joint.kind == JointKind::kLinear;
    std::optional<Unit> only;
    for (const char* name : linear ? std::vector<const char*>{"mm", "um", "m", "inch"}
                                   : std::vector<const char*>{"deg", "rad"}) {
      const auto unit = parseUnit(name, *m.kind);
      const double low = s.lower * unit->factor, high = s.upper * unit->factor;
      if (low < joint.lower - 0.05 * travel || high > joint.upper + 0.05 * travel) continue;
      if (std::max(high - low, std::max(std::abs(low), std::abs(high))) < 0.02 * travel) continue;
      if (only) return std::nullopt;
      only = unit;
    }
    return only;
  }

  std::string meaningText(const Meaning& m) const {
    const std::string joint =
        m.index < machine_.jointCount() ? machine_.joints()[m.index].name : std::string();
    switch (m.role) {
      case CsvRole::kTime:
        return "time";
      case CsvRole::kDate:
        return "day of the time";
      case CsvRole::kPosition:
        return "reading of joint " + joint;
      case CsvRole::kVelocity:
        return "velocity of joint " + joint;
      case CsvRole::kReading:
        return "laser's reading";
      case CsvRole::kFeature:
        return "ball or point touched";
      case CsvRole::kReference:
        return std::string("true position ") + "xyz"[m.index];
      case CsvRole::kDeviation:
        return std::string("deviation of ") + joint + (m.reversed ? ", sign changed" : "");
      case CsvRole::kDeviationStd:
        return "std of the deviation of " + joint;
      case CsvRole::kMeasured:
        return "position of " + joint + " by an instrument";
      case CsvRole::kDirection:
        return "direction of travel of " + joint;
      case CsvRole::kSetup:
        return "setup";
      case CsvRole::kTemperature:
        return "temperature " + m.name;
      case CsvRole::kCovariate:
        return "covariate " + m.name;
      case CsvRole::kIgnored:
        break;
    }
    return "left out: " + m.why;
  }

  void take(std::size_t i, const Meaning& m, const NameAndUnit& split, bool said, CsvColumn& c,
            UnderstoodColumn& seen) {
    c.role = m.role;
    c.index = m.index;
    c.name = m.name;
    c.suffix = samples_[i].suffix;
    seen.meaning = meaningText(m);
    if (m.role == CsvRole::kTime || m.role == CsvRole::kDate) {
      takeTime(i, split, c, seen);
    } else if (m.role == CsvRole::kCovariate) {
      c.unit = seen.unit = split.unitText == "%" ? "percent" : split.unitText;
      seen.from = said ? "mapping" : "header";
    } else if (m.kind) {
      const auto unit = unitFor(i, m, split, said, seen.from);
      if (!unit) return;
      c.factor = unit->factor * (m.reversed ? -1.0 : 1.0);
      c.offset = unit->offset;
      c.unit = m.role == CsvRole::kTemperature ? "degC" : unit->symbol;
      seen.unit = unit->symbol;
    }
    distinct(i, m, c);
  }

  void takeTime(std::size_t i, const NameAndUnit& split, CsvColumn& c, UnderstoodColumn& seen) {
    const ColumnSample& s = samples_[i];
    if (s.calendars > 0) {
      c.timeForm = TimeForm::kCalendar;
      seen.unit = "calendar";
      table_.form.absoluteTime = true;
      return;
    }
    if (s.slashed > 0) {
      const std::string order = mapping_.setting("date");
      if (!order.empty() && order != "month_first" && order != "day_first")
        faults_.add(mapping_.source + ":" + std::to_string(mapping_.lines.at("date")) + ": date: is '" +
                    order + "', but must be month_first or day_first");
      else if (order.empty() && s.monthFirst == s.dayFirst)
        fault(i, "has dates as " + s.first +
                     ", and whether the month or the day comes first cannot be seen; write into the "
                     "mapping (--columns): date: month_first (or day_first)");
      const bool month = order.empty() ? s.monthFirst : order == "month_first";
      c.timeForm = month ? TimeForm::kMonthFirst : TimeForm::kDayFirst;
      seen.unit = month ? "calendar, month first" : "calendar, day first";
      table_.form.absoluteTime = true;
      return;
    }
    if (s.clocks > 0) {
      c.timeForm = TimeForm::kClock;
      seen.unit = "time of day";
      return;
    }
    const std::string text = !split.unitText.empty()     ? split.unitText
                             : !layout_.units[i].empty() ? layout_.units[i]
                                                         : s.suffix;
    seen.from = !split.unitText.empty() ? "header"
                : layout_.unitsLine > 0 ? "line " + std::to_string(layout_.unitsLine)
                                        : "";
    auto unit = parseUnit(text, UnitKind::kTime);
    if (!text.empty() && !unit) {
      fault(i, "is in '" + text + "', but time is " + unitsOf(UnitKind::kTime) + "; " + line(i, "time_s"));
      return;
    }
    // seconds since 1970 stand between 2001 and 2096, whatever part of a second they count
    for (const char* part : {"s", "ms", "us", "ns"}) {
      const auto counted = parseUnit(part, UnitKind::kTime);
      const double first = s.lower * counted->factor, last = s.upper * counted->factor;
      if (first < 1e9 || last > 4e9 || (unit && unit->symbol != part)) continue;
      if (!unit) seen.from = "its range: since 1970";
      unit = counted;
      table_.form.absoluteTime = true;
    }
    if (table_.form.absoluteTime && layout_.names[i] == "time_s") table_.form.absoluteTime = false;
    if (!unit) {
      unit = parseUnit("s");
      seen.from = "assumed";
      table_.notes.push_back("column " + called(i) +
                             ": times without a unit are taken as seconds; if they are not, " +
                             line(i, "time_ms"));
    }
    c.factor = unit->factor;
    seen.unit = unit->symbol;
  }

  /// Two columns may not hold the same.
  void distinct(std::size_t i, const Meaning& m, CsvColumn& c) {
    if (m.role == CsvRole::kIgnored) return;
    std::string what = meaningText(m);
    const auto before = taken_.emplace(what, i);
    if (!before.second) {
      fault(i, "and column " + called(before.first->second) + " are both understood as " + what + "; " +
                   line(i, "ignore") + ", or say what else it holds");
      c.role = CsvRole::kIgnored;
      return;
    }
    if (m.role == CsvRole::kTemperature) c.index = temperatures_++;
    if (m.role == CsvRole::kCovariate) c.index = covariates_++;
  }

  /// What the columns are together.
  void whole() {
    const auto has = [&](std::initializer_list<CsvRole> roles) {
      return std::any_of(table_.form.columns.begin(), table_.form.columns.end(), [&](const CsvColumn& c) {
        return std::find(roles.begin(), roles.end(), c.role) != roles.end();
      });
    };
    if (!faults_.empty()) return;
    if (has({CsvRole::kFeature}) && artifact_ == nullptr)
      faults_.add(
          place() +
          "the file names what was touched; give an artifact that says what these are, with --artifact");
    if (!has({CsvRole::kFeature, CsvRole::kReference, CsvRole::kDeviation, CsvRole::kMeasured})) {
      if (artifact_ != nullptr && artifact_->features.size() == 1) {
        table_.form.onlyFeature = 0;
        table_.notes.push_back("no column says what was touched: '" + artifact_->features.front().name +
                               "', the only one of the artifact");
      } else {
        faults_.add(place() +
                    "no column says what was measured: a ball (feature), a true position (reference_x_mm) or "
                    "a deviation (deviation_x_um); name it in the mapping (--columns), e.g. columns: {" +
                    key(layout_.names.size() - 1) + ": feature}" +
                    (artifact_ == nullptr ? ", or give an --artifact of one ball" : ""));
      }
    }
    if (!has({CsvRole::kPosition}) && faults_.empty() && table_.form.fixed.empty())
      faults_.add(place() + "no column is a reading of a joint of this machine (" + joints() +
                  "); name one in the mapping (--columns): columns: {" + key(0) + ": " +
                  machine_.joints().front().name + "_mm}");
    if (!has({CsvRole::kTime, CsvRole::kDate}))
      table_.notes.push_back("no column of times: rows are taken in their order, a second apart");
  }

  const TextFile& file_;
  const TableLayout& layout_;
  const ColumnMapping& mapping_;
  const Machine& machine_;
  const Artifact* artifact_;
  FaultList& faults_;
  std::vector<ColumnSample> samples_;
  UnderstoodTable table_;
  std::pair<std::string, std::size_t> lengthUnit_, angleUnit_;  // said in a line of the file
  int axis_ = -1;
  bool hasTarget_ = false;
  int timeColumns_ = 0, temperatures_ = 0, covariates_ = 0;
  bool hasFeature_ = false, hasTime_ = false;
  std::set<int> suggested_;
  std::map<std::string, std::size_t> taken_;
};

}  // namespace

UnderstoodTable understandTable(const TextFile& file, const TableLayout& layout, const ColumnMapping& mapping,
                                const Machine& machine, const Artifact* artifact, FaultList& faults) {
  return TableUnderstander(file, layout, mapping, machine, artifact, faults).understand();
}

}  // namespace mm
