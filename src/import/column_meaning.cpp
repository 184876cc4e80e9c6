#include "import/column_meaning.h"

#include <algorithm>
#include <map>
#include <set>

#include "base/cancel_scope.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "import/column_faults.h"
#include "import/column_unit.h"
#include "import/import_format.h"
#include "import/meaning.h"
#include "import/name_reader.h"
#include "import/table_remarks.h"
#include "import/whole_table.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

class TableUnderstander {
 public:
  TableUnderstander(const ImportContext& context, const TableLayout& layout)
      : import_(context),
        layout_(layout),
        mapping_(context.mapping),
        machine_(context.machine),
        faults_(context.file, layout, context.faults),
        samples_(columnSamples(context.file, layout)),
        names_(machine_),
        remarks_(tableRemarks(layout, machine_)) {}

  TableForm understand() {
    form_.separator = layout_.separator;
    form_.decimalComma = layout_.decimalComma;
    form_.headerLine = layout_.lastHead();
    form_.features = mapping_.features;
    findAxis();
    checkMapping();
    form_.fixed = import_.fixed;
    lookAhead();
    if (layout_.headerLine == 0 && mapping_.columns.empty())
      nameless();
    else if (!mapping_.columns.empty() || !coordinateEachRow())
      for (std::size_t i = 0; i < layout_.names.size(); ++i) column(i);
    if (!form_.columns.empty()) completeTable(import_, layout_, samples_, form_, faults_);
    faults_.tell();
    return std::move(form_);
  }

 private:
  /// The joint of columns that do not say theirs: by the mapping, by the file, or the only one that there is.
  void findAxis() {
    context_.axis = remarks_.axis;
    headed_ = remarks_.axisLine > 0;
    if (const std::string said = mapping_.setting("axis"); !said.empty()) {
      context_.axis = machine_.findJoint(said);
      headed_ = false;
      if (context_.axis < 0)
        faults_.add(mapping_.place("axis") + "axis: '" + shownText(said) + "' is not a joint of machine '" +
                    machine_.name() + "' (" + joints() + ")");
    }
    if (context_.axis < 0 && machine_.jointCount() == 1) context_.axis = 0;
  }

  std::string joints() const { return jointNames(machine_); }

  /// Names of the mapping that are not in the file are misspelt.
  void checkMapping() {
    for (const auto& [name, as] : mapping_.columns) {
      bool found = false;
      for (std::size_t i = 0; i < layout_.names.size(); ++i) found |= faults_.mapped(i, name);
      if (found) continue;
      std::vector<std::string> names;
      for (const std::string& there : layout_.names) names.push_back(shownText(there));
      faults_.add(mapping_.source + ": columns: '" + shownText(name) + "' is not in " +
                  import_.file.path().string() + " (" + listOf(names) + ")" + didYouMean(name, names));
    }
  }

  /// Which other columns there are decides what "measured" and "date" mean.
  void lookAhead() {
    std::set<int> named;  // joints
    for (std::size_t i = 0; i < layout_.names.size(); ++i) {
      const auto [classes, joint] = names_.classesOf(wordsOf(splitUnit(layout_.names[i]).stem));
      context_.hasTarget |= classes.count(WordClass::kTarget) > 0;
      hasFeature_ |= classes.count(WordClass::kFeature) > 0;
      hasTime_ |= classes.count(WordClass::kTime) + classes.count(WordClass::kDate) > 0;
      if (joint >= 0 && classes.count(WordClass::kTemperature) == 0) named.insert(joint);
      context_.timeColumns +=
          classes.count(WordClass::kTime) > 0 && samples_[i].clocks + samples_[i].numbers > 0;
    }
    for (const auto& [name, as] : mapping_.columns) {
      context_.hasTarget |= as.rfind("target", 0) == 0;
      hasFeature_ |= as == "feature";
      hasTime_ |= as.rfind("time", 0) == 0;
    }
    if (headed_ && !named.empty() && named.count(context_.axis) == 0) context_.axis = -1, headed_ = false;
    if (context_.axis < 0 && named.size() == 1) {
      context_.axis = *named.begin();
      onlyNamed_ = true;
    }
  }

  /// A report in long form, as coordinate measuring machines print it: a row a coordinate, its joint in a
  /// column.
  bool coordinateEachRow() {
    for (std::size_t i = 0; i < layout_.names.size(); ++i) {
      const ColumnSample& s = samples_[i];
      const bool joints = s.numbers == 0 && s.words.size() > 1 &&
                          std::all_of(s.words.begin(), s.words.end(),
                                      [&](const std::string& word) { return jointOf(machine_, word) >= 0; });
      if (!joints || isLabels(i)) continue;
      faults_.add(i, "holds " + joined({s.words.begin(), s.words.end()}, ", ") +
                         ": each row is one coordinate; write one row per point with one column per "
                         "coordinate (x_mm, y_mm, z_mm and feature, or reference_x_mm …), or one file per "
                         "axis");
      return true;
    }
    return false;
  }

  /// A table without names: one line says them all.
  void nameless() {
    std::string all;
    for (std::size_t i = 0; i < layout_.names.size(); ++i) {
      const bool zero = samples_[i].lower == 0.0 && samples_[i].upper == 0.0;
      const std::string joint = zero || samples_[i].numbers == 0 ? "" : freeJoint(UnitKind::kLength);
      const std::string as = joint.empty() ? "ignore" : joint + "_mm";
      all += (i > 0 ? ", " : "") + faults_.key(i) + ": " + as;
      faults_.lines().askColumn(faults_.keyName(i), as);
      import_.imported.columns.push_back(asWritten(i));
    }
    faults_.add(faults_.place() + "no line names the " + std::to_string(layout_.names.size()) + " columns; " +
                addToMapping("columns", "{" + all + "}") +
                " (an example), or put a line of names above the rows");
  }

  UnderstoodColumn asWritten(std::size_t i) const {
    UnderstoodColumn seen;
    const ColumnSample& sample = samples_[i];
    seen.name = layout_.headerLine > 0 && !layout_.names[i].empty() ? layout_.names[i]
                                                                    : "column " + std::to_string(i + 1);
    seen.key = faults_.keyName(i);
    seen.first = sample.first;
    if (sample.numbers > 0) seen.lower = sample.lower, seen.upper = sample.upper;
    return seen;
  }

  void column(std::size_t i) {
    CancelScope::check();
    UnderstoodColumn seen = asWritten(i);
    std::string as;
    for (const auto& [name, value] : mapping_.columns)
      if (faults_.mapped(i, name)) as = value;
    CsvColumn c;
    c.header = layout_.names[i];
    c.role = CsvRole::kIgnored;
    if (as == "ignore" || (as.empty() && mapping_.ignoreOthers && !mapping_.columns.empty()))
      seen.meaning = "ignored by the mapping";
    else
      understand(i, as, c, seen);
    form_.columns.push_back(std::move(c));
    import_.imported.columns.push_back(std::move(seen));
  }

  /// A column whose meaning is looked for.
  struct Asked {
    std::size_t column;
    const ColumnSample& sample;
    bool said;          // in the mapping
    std::string name;   // there, else in the file
    NameAndUnit split;  // of the name
    std::optional<Unit> unit;
  };

  /// The first that knows a meaning says it; what that lacks is a fault; else the column is taken.
  void understand(std::size_t i, const std::string& as, CsvColumn& c, UnderstoodColumn& seen) {
    Asked asked = askedOf(i, as);
    if (asked.name.empty() && asked.sample.count == 0) {
      seen.meaning = "left out: empty";
      return;
    }
    std::optional<Meaning> meaning = names_.ownFormat(asked.name);
    if (!meaning) meaning = names_.byWords(asked.split.stem, asked.unit, asked.sample, asked.said, context_);
    if (!meaning) meaning = names_.covariate(asked.name, asked.split, asked.unit, asked.sample);
    if (!meaning) meaning = asLabels(asked);
    if (!meaning) meaning = asStamps(asked);
    if (!meaning) return unknown(i, asked.name, asked.said, asked.unit);
    if (meaning->unclearSign) return unclearSign(asked, *meaning);
    if (meaning->needsAxis) return noJoint(asked, *meaning);
    if (meaning->axisOfTable) noteAxis(i);
    take(i, *meaning, asked.split, asked.said, c, seen);
  }

  Asked askedOf(std::size_t i, const std::string& as) const {
    const bool said = !as.empty();
    Asked asked{i, samples_[i], said, said ? as : layout_.names[i], {}, {}};
    asked.split = splitUnit(asked.name);
    if (said && asked.split.unitText.empty()) asked.split.unitText = splitUnit(layout_.names[i]).unitText;
    // a unit of the words' own kind first: m is metres of a length
    asked.unit = parseUnit(asked.split.unitText.empty() ? layout_.units[i] : asked.split.unitText);
    return asked;
  }

  std::optional<Meaning> asLabels(const Asked& asked) {
    const bool words = asked.sample.texts > 0 && asked.sample.numbers == 0;
    if (asked.said || layout_.headerLine == 0 || !words || !isLabels(asked.column)) return std::nullopt;
    return meaningOf(CsvRole::kFeature, 0, machine_);
  }
  /// Every cell is a time, and no other column is one.
  std::optional<Meaning> asStamps(const Asked& asked) {
    const ColumnSample& s = asked.sample;
    if (asked.said || hasTime_ || s.count == 0 || s.calendars + s.slashed + s.clocks < s.count) return {};
    hasTime_ = true;
    return meaningOf(CsvRole::kTime, 0, machine_);
  }

  void unclearSign(const Asked& asked, const Meaning& meaning) {
    const Joint& joint = machine_.joints()[meaning.index];
    const std::string of =
        joint.name + "_" + (asked.unit ? asked.unit->symbol : std::string(errorUnit(joint).symbol));
    faults_.add(asked.column,
                "is an error or a difference, but whether it is indicated minus true (VIM) or actual minus "
                "target (ISO 230-2) is not stated",
                "error_" + of,
                " for the first, deviation_" + of + " for the second" +
                    (meaning.needsAxis ? " (joints: " + joints() + ")" : ""));
  }
  void noJoint(const Asked& asked, const Meaning& meaning) {
    const std::string first = machine_.joints().front().name;
    faults_.add(asked.column, "does not name its joint (" + joints() + ")", exampleOf(meaning, machine_),
                ", or for all such columns axis: " + first);
    faults_.lines().ask("axis", first);
  }

  /// From where the joint of a column that does not say its own is known.
  void noteAxis(std::size_t i) {
    const auto note = [&](const std::string& from) {
      import_.note("column " + faults_.called(i) + " is taken as of " +
                   machine_.joints()[context_.axis].name + ", " + from);
    };
    if (headed_) note("the axis that line " + std::to_string(remarks_.axisLine) + " names");
    if (onlyNamed_) note("the only joint that the file names");
  }

  /// A column of few different words, in which there are names of the artifact.
  bool isLabels(std::size_t i) const {
    if (import_.artifact == nullptr) return false;
    const std::string first = samples_[i].first;
    for (const Feature& f : import_.artifact->features)
      if (lower(f.name) == lower(first)) return true;
    return mapping_.features.count(first) > 0;
  }

  void unknown(std::size_t i, const std::string& name, bool said, const std::optional<Unit>& unit) {
    const std::vector<std::string> own = fixedColumns(machine_);
    const std::string near = nearestName(name, own);
    if (said) {
      faults_.add(mapping_.source + ": columns: '" + faults_.key(i) + ": " + shownText(name) +
                  "' is not understood; write <joint>_<unit>, deviation_<joint>_<unit>, reference_x_mm, "
                  "feature, time_s, <sensor>_degC, <name>_<unit> or ignore (joints: " +
                  joints() + ")" + didYouMean(name, own));
      return;
    }
    if (layout_.headerLine == 0) {
      faults_.add(
          i,
          "is not in the mapping" + (samples_[i].numbers > 0
                                         ? format(" (%.6g … %.6g)", samples_[i].lower, samples_[i].upper)
                                         : " ('" + shownText(samples_[i].first) + "')"),
          i < static_cast<std::size_t>(machine_.jointCount())
              ? exampleOf(meaningOf(CsvRole::kPosition, static_cast<int>(i), machine_), machine_)
              : "ignore");
      return;
    }
    const std::string plain = shownText(joined(wordsOf(splitUnit(name).stem), "_"));
    std::string as = "ignore", or_ = ", or state what it contains (joints: " + joints() + "; " + plain +
                                     "_<unit> of anything else)";
    if (!near.empty()) {
      as = near;
      or_.clear();
    } else if (names_.classesOf(wordsOf(name)).first.count(WordClass::kMeasured) > 0) {
      as = "measured_" + machine_.joints()[std::max(0, context_.axis)].name + "_mm";
    } else if (unit && unit->ofAGauge() && context_.axis >= 0) {
      const std::string of = machine_.joints()[context_.axis].name + "_" + unit->symbol;
      as = "deviation_" + of;
      or_ = " (true minus indicated; error_" + of + " for the other sign), or ignore";
    } else if (unit && (unit->kind == UnitKind::kLength || unit->kind == UnitKind::kAngle)) {
      const std::string joint = freeJoint(unit->kind);
      if (!joint.empty()) as = joint + "_" + unit->symbol;
    } else if (samples_[i].texts > 0 && !hasFeature_ && samples_[i].numbers == 0 &&
               import_.artifact != nullptr) {
      as = "feature";
      or_ = ", or ignore";
    }
    faults_.add(
        i,
        (layout_.names[i].empty() ? std::string("has no name") : std::string("is unknown on this machine")) +
            didYouMean(name, own),
        as, or_);
  }

  /// The next joint of that kind for which no column was suggested yet.
  std::string freeJoint(UnitKind kind) {
    for (int j = 0; j < machine_.jointCount(); ++j)
      if (unitKindOf(machine_, j) == kind &&
          taken_.count(meaningText(meaningOf(CsvRole::kPosition, j, machine_), machine_)) == 0 &&
          suggested_.insert(j).second)
        return machine_.joints()[j].name;
    return "";
  }

  void take(std::size_t i, const Meaning& m, const NameAndUnit& split, bool said, CsvColumn& c,
            UnderstoodColumn& seen) {
    c.role = m.role;
    c.index = m.index;
    c.name = m.name;
    c.suffix = samples_[i].suffix;
    seen.meaning = meaningText(m, machine_);
    if (m.role == CsvRole::kTime || m.role == CsvRole::kDate) {
      takeTime(i, split, c, seen);
    } else if (m.role == CsvRole::kCovariate) {
      c.unit = seen.unit = split.unitText == "%" ? "percent" : split.unitText;
      seen.from = said ? "mapping" : "header";
    } else if (m.kind) {
      const auto unit = unitOfColumn({i, samples_[i], layout_, remarks_, machine_}, m,
                                     {split.unitText, said ? "mapping" : "header"}, faults_, seen.from);
      if (!unit) return;
      c.factor = unit->factor * (m.reversed ? -1.0 : 1.0);
      c.offset = unit->offset;
      c.unit = m.role == CsvRole::kTemperature ? "degC" : unit->symbol;
      seen.unit = unit->symbol;
    }
    distinct(i, m, c);
  }

  void takeTime(std::size_t i, const NameAndUnit& split, CsvColumn& c, UnderstoodColumn& seen) {
    const TimeColumn time = timeColumn(i, samples_[i], layout_, mapping_, split.unitText, faults_);
    c.timeForm = time.form;
    c.factor = time.factor;
    seen.unit = time.unit;
    seen.from = time.from;
    form_.absoluteTime |= time.since1970;
    if (time.form == TimeForm::kNumber && layout_.names[i] == "time_s") form_.absoluteTime = false;
    for (const std::string& note : time.notes) import_.note(note);
  }

  /// Two columns may not hold the same.
  void distinct(std::size_t i, const Meaning& m, CsvColumn& c) {
    if (m.role == CsvRole::kIgnored) return;
    std::string what = meaningText(m, machine_);
    const auto before = taken_.emplace(what, i);
    if (!before.second) {
      faults_.add(
          i,
          "and column " + faults_.called(before.first->second) + " are both understood as " + shownText(what),
          "ignore", ", or state what else it contains");
      c.role = CsvRole::kIgnored;
      return;
    }
    if (m.role == CsvRole::kTemperature) c.index = temperatures_++;
    if (m.role == CsvRole::kCovariate) c.index = covariates_++;
  }

  const ImportContext& import_;
  const TableLayout& layout_;
  const ColumnMapping& mapping_;
  const Machine& machine_;
  ColumnFaults faults_;
  std::vector<ColumnSample> samples_;
  TableForm form_;
  NameReader names_;
  TableRemarks remarks_;
  NameContext context_;
  int temperatures_ = 0, covariates_ = 0;
  bool hasFeature_ = false, hasTime_ = false, onlyNamed_ = false, headed_ = false;
  std::set<int> suggested_;
  std::map<std::string, std::size_t> taken_;
};

}  // namespace

TableForm understandTable(const ImportContext& context, const TableLayout& layout) {
  return TableUnderstander(context, layout).understand();
}

}  // namespace mm
