#include "import/table_layout.h"

#include <algorithm>
#include <map>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/format.h"
#include "base/text.h"
#include "import/unit.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

std::vector<std::string_view> cellsOf(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  if (!splitCells(line, cells, separator)) cells.clear();
  return cells;
}

/// A number and the unit behind it: `12.5 mm`. False where there is no unit.
bool parseWithUnit(std::string_view cell, bool decimalComma, double& value, std::string& unit) {
  cell = trim(cell);
  const std::size_t end = cell.find_last_of("0123456789");
  if (end == std::string_view::npos || end + 1 == cell.size()) return false;
  const std::string_view text = trim(cell.substr(end + 1));
  if (!parseUnit(text) || !parseNumber(cell.substr(0, end + 1), decimalComma, value)) return false;
  unit = std::string(text);
  return true;
}

bool isValue(std::string_view cell) {
  double value = 0.0;
  std::string unit;
  if (parseSlashed(cell, true) || parseSlashed(cell, false)) return true;
  if (parseWithUnit(cell, false, value, unit) || parseWithUnit(cell, true, value, unit)) return true;
  return parseNumber(cell, false, value) || parseNumber(cell, true, value) || parseCalendar(cell) ||
         parseClock(cell);
}

/// Without the brackets that a unit stands in.
std::string_view unbracketed(std::string_view cell) {
  if (cell.size() > 2 &&
      ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')')))
    return cell.substr(1, cell.size() - 2);
  return cell;
}

/// Cells without the empty ones at the end.
std::size_t countOf(const std::vector<std::string_view>& cells) {
  std::size_t n = cells.size();
  while (n > 0 && cells[n - 1].empty()) --n;
  return n;
}

/// The first cell of a line of targets, as ISO 230-2 prints it: `Target;-20;-10;0`.
bool namesTargets(std::string_view cell) {
  return isOneOf(lower(cell.substr(0, cell.find_first_of(" [(_"))), "target|position|soll|sollposition|pi");
}

struct Line {
  std::size_t number;
  std::string_view text;
};

class LayoutFinder {
 public:
  LayoutFinder(const TextFile& file, const ColumnMapping& mapping) : file_(file), mapping_(mapping) {
    for (std::size_t i = 0; i < file.lines().size(); ++i) {
      std::string remark;
      const std::string_view line = file.lines()[i];
      if (trim(line).empty()) continue;
      if (takeRemark(line, remark))
        layout_.remarks.emplace_back(i + 1, remark);
      else
        lines_.push_back({i + 1, line});
    }
  }

  TableLayout find() {
    if (lines_.empty()) throw InputError(file_.path().string() + ": contains remarks only, no measurements");
    findSeparator();
    refuseTooWide(file_, widthLine_, columns_);
    findRows();
    findHeader();
    refuseTooWide(file_, layout_.headerLine, layout_.names.size());
    findDecimalMark();
    for (const Line& line : lines_)
      if (line.number < layout_.lastHead() + 1 && line.number != layout_.headerLine &&
          line.number != layout_.unitsLine && line.number != groupLine_)
        layout_.remarks.emplace_back(line.number, std::string(trim(line.text)));
    std::sort(layout_.remarks.begin(), layout_.remarks.end());
    return std::move(layout_);
  }

 private:
  void findSeparator() {
    constexpr int kLooked = 400;
    double best = 0.0;
    for (const char candidate : {'\t', ';', ',', '|', ' '}) {
      if (mapping_.separator && candidate != *mapping_.separator) continue;
      struct Seen {
        std::size_t first = 0;  // line
        int lines = 0;
        double share = 0.0;  // of values
      };
      std::map<std::size_t, Seen> counts;  // by the number of cells
      int all = 0;
      for (const Line& line : lines_) {
        CancelScope::check();
        const auto cells = cellsOf(line.text, candidate);
        const std::size_t count = countOf(cells);
        if (count > 0) {
          int values = 0;
          const std::size_t looked = std::min(count, kMostColumns);
          for (std::size_t i = 0; i < looked; ++i) values += cells[i].empty() || isValue(cells[i]);
          Seen& seen = counts[count];
          if (seen.lines++ == 0) seen.first = line.number;
          seen.share += static_cast<double>(values) / static_cast<double>(looked);
        }
        if (++all == kLooked) break;
      }
      for (const auto& [count, seen] : counts) {
        if (count < 2 && !mapping_.separator) continue;
        // lines that agree, and values in their cells: either alone may be chance
        const double score = (static_cast<double>(seen.lines) / all) * (0.05 + seen.share / seen.lines);
        if (score <= best * 1.0001) continue;
        best = score;
        layout_.separator = candidate;
        columns_ = count;
        widthLine_ = seen.first;
      }
    }
    if (best == 0.0)
      throw InputError(file_.place(lines_.front().number) +
                       "no table found: each line has one cell; separate columns with commas, semicolons, "
                       "tabs or blanks");
  }

  bool isRow(const Line& line) const {
    const auto cells = cellsOf(line.text, layout_.separator);
    const std::size_t count = countOf(cells);
    if (count + 2 < columns_ || count > columns_ + 1 || count < 1) return false;
    if (namesTargets(cells.front())) return false;
    std::size_t values = 0, filled = 0;
    for (const auto cell : cells) {
      filled += !cell.empty();
      values += !cell.empty() && isValue(cell);
    }
    // of two columns both: `Radius (mm),100` is of a head
    return values >= 1 && (columns_ == 2 ? values == filled : 3 * values >= filled);
  }

  void findRows() {
    const std::size_t after = mapping_.headerLine.value_or(0);
    const auto first = std::find_if(lines_.begin(), lines_.end(),
                                    [&](const Line& l) { return l.number > after && isRow(l); });
    if (first != lines_.end()) layout_.firstRow = first->number;
  }

  void takeNames(std::string_view text) {
    std::vector<std::string>& names = layout_.names;
    for (const auto cell : cellsOf(text, layout_.separator)) {
      // between blanks, a unit in brackets stands by itself
      if (layout_.separator == ' ' && !names.empty() && !cell.empty() &&
          (cell.front() == '[' || cell.front() == '('))
        names.back() += " " + std::string(cell);
      else
        names.emplace_back(trim(cell));
    }
  }

  void findHeader() {
    if (mapping_.headerLine) {
      layout_.headerLine = *mapping_.headerLine;
      if (layout_.headerLine > file_.lines().size())
        throw InputError(mapping_.source + ": header_line is " + std::to_string(layout_.headerLine) +
                         ", but " + file_.path().string() + " has " + std::to_string(file_.lines().size()) +
                         " lines");
    }
    std::vector<Line> above;  // nearest first
    for (const Line& line : lines_) {
      if (layout_.firstRow > 0 && line.number >= layout_.firstRow) break;
      const std::size_t count = countOf(cellsOf(line.text, layout_.separator));
      if (count > 1 && count + 1 >= columns_) above.insert(above.begin(), line);
      if (layout_.firstRow == 0) break;  // names without a row
    }
    if (!mapping_.headerLine && !above.empty()) {
      std::size_t at = 0;
      if (isUnits(above[0]) && above.size() > 1) layout_.unitsLine = above[at++].number;
      layout_.headerLine = above[at].number;
    } else if (mapping_.headerLine && !above.empty() && above[0].number > layout_.headerLine &&
               isUnits(above[0])) {
      layout_.unitsLine = above[0].number;
    }
    if (layout_.headerLine == 0 && !mapping_.headerLine) headerInRemark();
    if (layout_.headerLine > 0 && layout_.names.empty()) {
      std::string text;
      const std::string_view line = file_.lines()[layout_.headerLine - 1];
      takeNames(takeRemark(line, text) ? std::string_view(text) : line);
    }
    if (!mapping_.headerLine) groupNames();
    if (layout_.headerLine == 0)
      for (std::size_t i = 0; i < columns_; ++i) layout_.names.push_back(std::to_string(i + 1));
    if (layout_.unitsLine > 0)
      for (const auto cell : cellsOf(file_.lines()[layout_.unitsLine - 1], layout_.separator))
        layout_.units.emplace_back(unbracketed(trim(cell)));
    // separators after the last name, as spreadsheets write them, are no columns
    while (layout_.names.size() > columns_ && layout_.names.back().empty()) layout_.names.pop_back();
    layout_.units.resize(layout_.names.size());
  }

  /// A line of groups above the names: `Time;Position;;;Deviation;;` over `;X;Y;Z;X;Y;Z`.
  void groupNames() {
    const std::set<std::string> different(layout_.names.begin(), layout_.names.end());
    if (layout_.headerLine == 0 || different.size() == layout_.names.size()) return;
    const auto header = std::find_if(lines_.begin(), lines_.end(),
                                     [&](const Line& l) { return l.number == layout_.headerLine; });
    if (header == lines_.begin() || header == lines_.end()) return;
    const auto cells = cellsOf(std::prev(header)->text, layout_.separator);
    const auto filled = std::count_if(cells.begin(), cells.end(), [](auto c) { return !c.empty(); });
    if (cells.size() != layout_.names.size() || filled < 2 ||
        std::any_of(cells.begin(), cells.end(), isValue))
      return;
    std::string group;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (!cells[i].empty() || layout_.names[i].empty()) group = std::string(trim(cells[i]));
      layout_.names[i] = trim(group + " " + layout_.names[i]);
    }
    groupLine_ = std::prev(header)->number;
  }

  bool isUnits(const Line& line) const {
    int units = 0;
    for (const auto cell : cellsOf(line.text, layout_.separator)) {
      if (cell.empty() || cell == "-" || cell == "[-]") continue;
      if (!parseUnit(unbracketed(cell)) && cell.front() != '[' && cell.front() != '(') return false;
      ++units;
    }
    return units > 0;
  }

  /// `# x y z` above the first row.
  void headerInRemark() {
    for (auto r = layout_.remarks.rbegin(); r != layout_.remarks.rend(); ++r) {
      if (layout_.firstRow > 0 && r->first > layout_.firstRow) continue;
      const auto cells = cellsOf(r->second, layout_.separator);
      if (countOf(cells) != columns_ || std::any_of(cells.begin(), cells.end(), isValue)) continue;
      layout_.headerLine = r->first;
      takeNames(r->second);
      layout_.remarks.erase(std::next(r).base());
      return;
    }
  }

  void findDecimalMark() {
    if (mapping_.decimalComma) {
      layout_.decimalComma = *mapping_.decimalComma;
      return;
    }
    if (layout_.firstRow == 0) return;
    DecimalMarkFinder finder(layout_.names.size());
    for (const Line& line : lines_)
      if (line.number >= layout_.firstRow) finder.look(line.number, cellsOf(line.text, layout_.separator));
    layout_.marks = finder.decide();
    layout_.decimalComma = layout_.marks.comma;
  }

  const TextFile& file_;
  const ColumnMapping& mapping_;
  std::vector<Line> lines_;  // neither blank nor remarks
  std::size_t columns_ = 0, widthLine_ = 0, groupLine_ = 0;
  TableLayout layout_;
};

}  // namespace

bool takeRemark(std::string_view line, std::string& text) {
  if (!isRemark(line)) return false;
  line = trim(line);
  text = std::string(
      trim(line.substr(startsWith(line, "//") ? 2 : std::min(line.size(), line.find_first_not_of("#%")))));
  return true;
}

bool keyValue(std::string_view text, std::string& key, std::string& value) {
  const std::size_t at = text.find_first_of(":=;,\t");
  if (at == std::string_view::npos || at == 0) return false;
  key = lower(trim(text.substr(0, at)));
  std::string_view rest = trim(text.substr(at + 1));
  while (!rest.empty() && (rest.back() == ';' || rest.back() == ','))
    rest = trim(rest.substr(0, rest.size() - 1));
  value = std::string(rest);
  return !value.empty();
}

void refuseUnclear(const TextFile& file, const TableLayout& layout, const UnclearNumber& u,
                   ImportFaults& faults) {
  double decimal = 0.0, grouped = 0.0;
  const bool comma = u.cell.find(',') != std::string::npos;
  std::string unit;
  if (!parseNumber(u.cell, comma, decimal)) parseWithUnit(u.cell, comma, decimal, unit);
  if (!parseNumber(u.cell, !comma, grouped)) parseWithUnit(u.cell, !comma, grouped, unit);
  const std::string is = layout.decimalComma ? "comma" : "point";
  const std::string other = layout.decimalComma ? "point" : "comma";
  const std::string write = faults.ask("decimal", is);
  faults.add(file.place(u.line) + "column '" + shownText(layout.names[u.column]) + "': whether '" +
             shownText(u.cell) + "' is " + format("%.6g or %.6g", decimal, grouped) + " cannot be seen" +
             (layout.marks.proven
                  ? ", as other columns have a decimal " + is + "; if it has thousands set apart, " + write +
                        ", else correct the file"
                  : "; " + write + " (or " + other + ")"));
}

void refuseTooWide(const TextFile& file, std::size_t line, std::size_t columns) {
  if (columns > kMostColumns)
    throw InputError(file.place(std::max<std::size_t>(1, line)) + std::to_string(columns) +
                     " columns, at most " + std::to_string(kMostColumns) +
                     " are read; omit those that are not needed");
}

TableLayout tableLayout(const TextFile& file, const ColumnMapping& mapping) {
  return LayoutFinder(file, mapping).find();
}

std::string TableLayout::inWords() const {
  const std::string mark = separator == '\t'  ? "tabs"
                           : separator == ' ' ? "blanks"
                                              : "'" + std::string(1, separator) + "'";
  std::string text = "separated by " + mark + (decimalComma ? ", decimal comma" : "");
  text += headerLine > 0 ? ", names in line " + std::to_string(headerLine) : ", no line of names";
  if (unitsLine > 0) text += ", units in line " + std::to_string(unitsLine);
  return text;
}

void eachRow(const TextFile& file, const TableLayout& layout,
             const std::function<void(std::size_t, std::string_view, Cells&)>& tell) {
  for (std::size_t n = layout.firstRow; n > 0 && n <= file.lines().size(); ++n) {
    const std::string_view line = file.lines()[n - 1];
    CancelScope::check();
    if (trim(line).empty() || isRemark(line)) continue;
    Cells cells = cellsOf(line, layout.separator);
    tell(n, line, cells);
  }
}

std::vector<ColumnSample> columnSamples(const TextFile& file, const TableLayout& layout) {
  std::vector<ColumnSample> samples(layout.names.size());
  eachRow(file, layout, [&](std::size_t, std::string_view, const Cells& cells) {
    if (sumsUp(cells)) return;
    for (std::size_t i = 0; i < std::min(cells.size(), samples.size()); ++i) {
      if (cells[i].empty()) continue;
      ColumnSample& s = samples[i];
      if (s.count++ == 0) s.first = std::string(cells[i]);
      double value = 0.0;
      std::string suffix;
      const bool plain = parseNumber(cells[i], layout.decimalComma, value);
      if (plain || parseWithUnit(cells[i], layout.decimalComma, value, suffix)) {
        if (s.numbers == 0) s.suffix = suffix;
        if (s.suffix != suffix) s.suffix.clear();
        s.lower = s.numbers == 0 ? value : std::min(s.lower, value);
        s.upper = s.numbers == 0 ? value : std::max(s.upper, value);
        ++s.numbers;
      } else if (const auto month = parseSlashed(cells[i], true), day = parseSlashed(cells[i], false);
                 month || day || parseCalendar(cells[i])) {
        ++(month || day ? s.slashed : s.calendars);
        s.monthFirst = s.monthFirst && (month || !day);
        s.dayFirst = s.dayFirst && (day || !month);
        s.midnight = s.midnight && cells[i].find(':') == std::string_view::npos;
      } else if (parseClock(cells[i])) {
        ++s.clocks;
      } else {
        ++s.texts;
        constexpr std::size_t kFew = 8;
        if (s.words.size() < kFew) s.words.emplace(cells[i]);
      }
    }
  });
  return samples;
}

}  // namespace mm
