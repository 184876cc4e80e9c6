#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "base/range.h"
#include "base/text.h"
#include "import/column_words.h"
#include "import/record_table.h"
#include "import/unit.h"
#include "session/csv_cells.h"

namespace mm {
namespace {

struct Run {
  int number = 0;
  double direction = 0.0;  // 0: not said
};

/// The parts of a run's name: digits together, letters together, each sign for itself.
std::vector<std::string> partsOf(const std::string& name) {
  enum class Kind { kNone, kDigit, kLetter };
  std::vector<std::string> parts;
  Kind last = Kind::kNone;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::string_view(" _()=").find(c) != std::string_view::npos) {
      last = Kind::kNone;
      continue;
    }
    const Kind kind = std::isdigit(byte) != 0                   ? Kind::kDigit
                      : std::isalpha(byte) != 0 || byte >= 0x80 ? Kind::kLetter
                                                                : Kind::kNone;
    if (kind == Kind::kNone || kind != last) parts.emplace_back();
    parts.back() += c;
    last = kind;
  }
  return parts;
}

/// `1+`, `-2`, `Run 3 ↓`, `4 up`, `1 auf`; nothing for another name.
std::optional<Run> runOf(std::string_view name) {
  Run run;
  bool numbered = false;
  for (const std::string& part : partsOf(lower(trim(name)))) {
    if (isOneOf(part, "run|cycle|lauf|zyklus|j")) continue;
    if (std::isdigit(static_cast<unsigned char>(part[0])) != 0) {
      if (numbered || part.size() > 3) return std::nullopt;
      numbered = true;
      run.number = std::stoi(part);
    } else {
      const double direction = directionOf(part);
      if (direction == 0.0 || run.direction != 0.0) return std::nullopt;
      run.direction = direction;
    }
  }
  if (!numbered) return std::nullopt;
  return run;
}

bool isTarget(const std::string& name) {
  for (const std::string& word : wordsOf(name))
    if (isOneOf(word, "target|position|nominal|soll|sollposition|pi|p")) return true;
  return false;
}

/// The name of a column that a table has whose rows are single measurements.
bool isDeviationOrDirection(const std::string& name) {
  for (const std::string& word : wordsOf(name))
    if (classOf(word) == WordClass::kDeviation || classOf(word) == WordClass::kDirection) return true;
  return false;
}

struct Cell {
  double target, value;  // value in its own unit, not yet SI
  Run run;
  std::size_t line;
};

class PositioningReader {
 public:
  explicit PositioningReader(ImportContext& context) : context_(context), table_(context) {}

  void read() {
    const std::string axis = table_.said({"axis", "achse", "axe", "axis under test"}, "axis");
    const int joint = table_.joint(axis, "axis");
    if (joint < 0) return;
    linear_ = context_.machine.joints()[joint].kind == JointKind::kLinear;
    kind_ = linear_ ? UnitKind::kLength : UnitKind::kAngle;
    if (!cells()) return;
    if (!units()) return;
    session(joint);
  }

 private:
  bool cells() {
    const auto& names = table_.layout().names;
    std::size_t runs = 0;
    for (std::size_t i = 1; i < names.size(); ++i) runs += runOf(names[i]).has_value();
    const bool transposed = !names.empty() && isTarget(names[0]) && !table_.rows().empty() &&
                            runOf(table_.rows().front().cells[0]).has_value() && rowsAreRuns();
    if (transposed)
      byRuns();
    else if (runs > 0)
      byTargets();
    else
      table_.refuseHead("no column is a run; name the runs by number and direction: 1+, 1-, 2+, 2-");
    return context_.faults.empty();
  }

  /// The names are numbers (target positions), and each row begins with a run.
  bool rowsAreRuns() const {
    const auto& names = table_.layout().names;
    double value = 0.0;
    for (std::size_t i = 1; i < names.size(); ++i)
      if (!parseNumber(names[i], table_.layout().decimalComma, value)) return false;
    return std::all_of(table_.rows().begin(), table_.rows().end(),
                       [](const auto& row) { return runOf(row.cells[0]).has_value(); });
  }

  bool numberAt(const std::string& cell, std::size_t line, double& value) {
    if (parseNumber(cell, table_.layout().decimalComma, value)) return true;
    context_.refuse(line, "'" + shownText(cell) +
                              "' is not a finite number; leave the cell empty where nothing was measured");
    return false;
  }

  /// That of the values is known once all columns were looked at.
  void showUnit(const std::string& symbol) {
    for (UnderstoodColumn& column : context_.imported.columns)
      if (column.unit.empty()) column.unit = symbol;
  }

  void byTargets() {
    const auto& names = table_.layout().names;
    table_.show(0, "target position", unitOfTargets());
    for (std::size_t i = 1; i < names.size(); ++i) {
      const auto run = runOf(names[i]);
      if (!run) {
        context_.note("column '" + shownText(names[i]) + "' is not a run and was ignored");
        continue;
      }
      table_.show(static_cast<int>(i), "run " + std::to_string(run->number) + directionText(*run), "");
      for (const auto& row : table_.rows()) {
        double target = 0.0, value = 0.0;
        if (i >= row.cells.size() || row.cells[i].empty()) continue;
        if (numberAt(row.cells[0], row.line, target) && numberAt(row.cells[i], row.line, value))
          cells_.push_back({target, value, *run, row.line});
      }
    }
  }

  void byRuns() {
    const auto& names = table_.layout().names;
    for (const auto& row : table_.rows()) {
      const Run run = *runOf(row.cells[0]);
      for (std::size_t i = 1; i < std::min(names.size(), row.cells.size()); ++i) {
        double target = 0.0, value = 0.0;
        if (row.cells[i].empty()) continue;
        if (numberAt(names[i], table_.layout().headerLine, target) && numberAt(row.cells[i], row.line, value))
          cells_.push_back({target, value, run, row.line});
      }
    }
    context_.note("one column per target, one row per run");
  }

  static std::string directionText(const Run& run) {
    return run.direction > 0.0 ? ", upwards" : run.direction < 0.0 ? ", downwards" : "";
  }

  std::string unitOfTargets() const {
    const std::string own = splitUnit(table_.layout().names.front()).unitText;
    if (!own.empty()) return own;
    const std::string said = table_.said({"target unit", "position unit", "unit of positions"}, "");
    return !said.empty() ? said : linear_ ? "mm" : "deg";
  }

  /// Positions follow their targets; deviations do not.
  bool arePositions() const {
    Range targets;
    double off = 0.0;
    for (const Cell& c : cells_) {
      targets.add(c.target);
      off = std::max(off, std::abs(c.value - c.target));
    }
    return targets.size() > 0.0 && off < 0.02 * targets.size();
  }

  bool units() {
    const auto targets = parseUnit(unitOfTargets(), kind_);
    if (!targets) {
      context_.refuse("the targets are in '" + shownText(unitOfTargets()) + "', but they are " +
                      factsOf(kind_).inWords + "; write the unit after the name: Target [" +
                      (linear_ ? "mm]" : "deg]"));
      return false;
    }
    targetUnit_ = targets->factor;
    positions_ = arePositions();
    if (positions_) {
      valueUnit_ = targetUnit_;
      showUnit(targets->symbol);
      context_.note("the values follow the targets: they are measured positions, in " + targets->symbol +
                    "; deviation = measured minus target");
      return true;
    }
    std::string said = table_.said({"unit", "units", "deviation", "deviations", "deviation unit",
                                    "unit of deviations", "einheit", "abweichungen"},
                                   "unit");
    if (said.empty())
      for (const auto& [line, text] : table_.layout().remarks) {
        const auto words = wordsOf(text);
        for (std::size_t i = 0; i < words.size(); ++i)
          if (words[i].rfind("deviation", 0) == 0 || words[i].rfind("abweichung", 0) == 0)
            for (std::size_t k = i + 1; k < words.size(); ++k)
              if (words[k] != "in" && parseUnit(words[k], kind_)) said = words[k];
      }
    const auto unit = parseUnit(said, kind_);
    if (!unit) {
      context_.refuse("the unit of the deviations " +
                      (said.empty() ? std::string("is not stated") : "is '" + shownText(said) + "'") + "; " +
                      context_.ask("unit", linear_ ? "um" : "arcsec"));
      return false;
    }
    valueUnit_ = unit->factor;
    showUnit(unit->symbol);
    context_.note("deviations in " + unit->symbol + ", actual minus target");
    return true;
  }

  /// In the order in which the standard measures: each run upwards through the targets, then downwards.
  void session(int joint) {
    for (Cell& c : cells_) c.target *= targetUnit_;
    std::stable_sort(cells_.begin(), cells_.end(), [](const Cell& a, const Cell& b) {
      if (a.run.number != b.run.number) return a.run.number < b.run.number;
      if (a.run.direction != b.run.direction) return a.run.direction > b.run.direction;
      return a.run.direction < 0.0 ? a.target > b.target : a.target < b.target;
    });
    Session session = emptySession(context_);
    session.timesAssumed = kTimesInOrder;
    double time = 0.0;
    for (const Cell& c : cells_) {
      Observation o = blankRow(context_, ObservationKind::kDeviation, c.line, time);
      time += 1.0;
      o.position[joint] = c.target;
      o.deviation[joint] = c.value * valueUnit_ - (positions_ ? c.target : 0.0);
      if (c.run.direction != 0.0) o.velocity[joint] = 0.0, o.travel[joint] = c.run.direction;
      o.setup = setupIndex(session, "iso230-2 " + context_.machine.joints()[joint].name);
      session.observations.push_back(std::move(o));
    }
    context_.note(
        "no times: rows are ordered as in ISO 230-2, run by run, upwards then downwards, and no effect "
        "of time can be told; the instrument's zero is an unknown of the setup");
    finishImport(context_, std::move(session));
  }

  ImportContext& context_;
  RecordTable table_;
  bool linear_ = true, positions_ = false;
  UnitKind kind_ = UnitKind::kLength;
  double targetUnit_ = 1.0, valueUnit_ = 1.0;
  std::vector<Cell> cells_;
};

}  // namespace

bool isPositioningTable(const TextFile& file) {
  constexpr std::size_t kLooked = 40;
  std::vector<std::string_view> cells;
  bool oneRowEach = false;  // a header that has a column of deviations, and none of runs
  for (std::size_t i = 0; i < std::min(kLooked, file.lines().size()); ++i)
    for (const char separator : {'\t', ';', ','}) {
      if (!splitCells(file.lines()[i], cells, separator) || cells.size() < 3 || cells.size() > kMostColumns)
        continue;
      std::size_t directed = 0, runs = 0, measured = 0;
      for (std::size_t k = 1; k < cells.size(); ++k) {
        double value = 0.0;
        const auto run = runOf(cells[k]);
        // +1 is a number in a row, 1+ is a run
        directed += run && run->direction != 0.0 && !parseNumber(cells[k], false, value);
        runs += run.has_value();
        measured += isDeviationOrDirection(std::string(cells[k]));
      }
      if (directed >= 2 && isTarget(std::string(cells[0]))) return true;
      oneRowEach = oneRowEach || (measured > 0 && runs == 0);
    }
  return !oneRowEach && headHas(file, "iso 230-2|iso230-2");
}

void readPositioningTable(ImportContext& context) { PositioningReader(context).read(); }

}  // namespace mm
