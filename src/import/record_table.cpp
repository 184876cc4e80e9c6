#include "import/record_table.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"
#include "import/meaning.h"
#include "import/unit.h"

namespace mm {

RecordTable::RecordTable(ImportContext& context)
    : context_(context), layout_(tableLayout(context.file, context.mapping)) {
  for (const UnclearNumber& u : layout_.marks.unclear)
    refuseUnclear(context.file, layout_, u, context.faults);
  context.imported.how = context.file.encoding() + ", " + layout_.inWords();
  for (const auto& [line, text] : layout_.remarks) {
    std::string key, value;
    if (!keyValue(text, key, value)) continue;
    if (layout_.firstRow == 0 || line < layout_.firstRow)
      head_.emplace_back(key, value);
    else
      between_[line] = {key, value};
  }
  if (layout_.firstRow == 0) throw InputError(context.file.path().string() + ": there is no row of numbers");
  std::vector<std::string_view> cells;
  for (std::size_t n = layout_.firstRow; n <= context.file.lines().size(); ++n) {
    const std::string_view line = context.file.lines()[n - 1];
    std::string remark;
    if (trim(line).empty() || takeRemark(line, remark)) continue;
    if (!splitCells(line, cells, layout_.separator)) {
      context.faults.add(context.file.place(n) + "a quote is not closed, or text follows it");
      continue;
    }
    while (!cells.empty() && cells.back().empty()) cells.pop_back();
    if (cells.empty()) continue;
    Row row{n, {cells.begin(), cells.end()}};
    const bool numbers = std::any_of(row.cells.begin(), row.cells.end(), [&](const std::string& c) {
      double v = 0.0;
      return parseNumber(c, layout_.decimalComma, v);
    });
    std::string key, value;
    if (row.cells.size() < layout_.names.size() && keyValue(line, key, value) &&
        key.find_first_not_of("+-.0123456789") != std::string::npos)
      between_[n] = {key, value};
    else if (!numbers || sumsUp(cells))
      context.imported.notes.push_back("line " + std::to_string(n) + " is no row and was left out: '" +
                                       std::string(trim(line).substr(0, 60)) + "'");
    else
      rows_.push_back(std::move(row));
  }
}

int RecordTable::column(const std::vector<std::string>& words) const {
  for (const std::string& wanted : words)
    for (std::size_t i = 0; i < layout_.names.size(); ++i)
      for (const std::string& word : wordsOf(splitUnit(layout_.names[i]).stem))
        if (word == wanted) return static_cast<int>(i);
  return -1;
}

std::string RecordTable::said(const std::vector<std::string>& keys, const std::string& mapped) const {
  const std::string own = context_.mapping.setting(mapped);
  if (!own.empty()) return own;
  for (const std::string& key : keys)
    for (const auto& [name, value] : head_)
      if (name == key || splitUnit(name).stem == key) return value;
  return "";
}

bool RecordTable::number(const std::vector<std::string>& keys, const std::string& mapped, UnitKind kind,
                         const std::string& unit, double& value) {
  std::string text = context_.mapping.setting(mapped), unitText = unit, key = mapped;
  if (text.empty())
    for (const std::string& wanted : keys)
      for (const auto& [name, said] : head_) {
        const NameAndUnit split = splitUnit(name);
        if (!text.empty() || (name != wanted && split.stem != wanted)) continue;
        text = said;
        key = name;
        if (!split.unitText.empty()) unitText = split.unitText;
      }
  if (text.empty()) return false;
  const std::size_t end = text.find_first_not_of("+-.,0123456789eE");
  const std::string digits(trim(text.substr(0, end)));
  const std::string behind = end == std::string::npos ? "" : std::string(trim(text.substr(end)));
  if (!behind.empty()) unitText = behind;
  const auto read = parseUnit(unitText, kind);
  if (!read || (!parseNumber(digits, false, value) && !parseNumber(digits, true, value))) {
    context_.faults.add(context_.file.path().string() + ": '" + key + "' is '" + text + "', but must be " +
                        unitsOf(kind) + "; write into the mapping (--columns): " + mapped + ": <number>");
    return false;
  }
  value *= read->factor;
  return true;
}

double RecordTable::value(const Row& row, int column, UnitKind kind, const std::string& fallback) {
  const auto at = static_cast<std::size_t>(column);
  if (column < 0 || at >= row.cells.size() || row.cells[at].empty() || meansNothing(row.cells[at]))
    return kNotMeasured;
  const std::string name = at < layout_.names.size() ? layout_.names[at] : std::to_string(column + 1);
  double value = 0.0;
  if (!parseNumber(row.cells[at], layout_.decimalComma, value)) {
    context_.faults.add(context_.file.place(row.line) + "column '" + name + "': '" + row.cells[at] +
                        "' is not a finite number; leave the cell empty where nothing was measured");
    return kNotMeasured;
  }
  std::string unitText = splitUnit(name).unitText;
  if (unitText.empty() && at < layout_.units.size()) unitText = layout_.units[at];
  if (unitText.empty()) unitText = fallback;
  const auto unit = parseUnit(unitText, kind);
  if (!unit) {
    context_.faults.add(context_.file.place(std::max<std::size_t>(1, layout_.headerLine)) + "column '" +
                        name + (unitText.empty() ? "' has no unit" : "' is in '" + unitText + "'") +
                        ", but it is " + unitsOf(kind) +
                        "; write the unit behind the name in brackets, or into the mapping "
                        "(--columns): unit: " +
                        (kind == UnitKind::kLength ? "um" : "deg"));
    return kNotMeasured;
  }
  return value * unit->factor + unit->offset;
}

std::string RecordTable::text(const Row& row, int column) const {
  const auto at = static_cast<std::size_t>(column);
  return column < 0 || at >= row.cells.size() ? "" : row.cells[at];
}

int RecordTable::joint(const std::string& name, const std::string& key) {
  const int j = jointOf(context_.machine, name);
  if (j >= 0) return j;
  context_.faults.add(
      context_.file.path().string() + ": " + key + " " +
      (name.empty() ? std::string("is not said") : "'" + name + "' is no joint of this machine") + " (" +
      jointNames(context_.machine) + "); write into the mapping (--columns): " + key + ": " +
      context_.machine.joints().front().name);
  return -1;
}

void RecordTable::show(int column, const std::string& meaning, const std::string& unit) {
  if (column < 0) return;
  UnderstoodColumn seen;
  const auto at = static_cast<std::size_t>(column);
  seen.name = at < layout_.names.size() ? layout_.names[at] : std::to_string(column + 1);
  seen.meaning = meaning;
  std::string own = splitUnit(seen.name).unitText;
  if (own.empty() && at < layout_.units.size()) own = layout_.units[at];
  seen.unit = own.empty() ? unit : own;
  double low = INFINITY, high = -INFINITY;
  for (const Row& row : rows_) {
    double v = 0.0;
    if (at >= row.cells.size() || !parseNumber(row.cells[at], layout_.decimalComma, v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (low <= high) seen.lower = low, seen.upper = high;
  if (!rows_.empty() && at < rows_.front().cells.size()) seen.first = rows_.front().cells[at];
  context_.imported.columns.push_back(std::move(seen));
}

bool headHas(const TextFile& file, const std::vector<std::string>& words, std::size_t lines) {
  for (std::size_t i = 0; i < std::min(lines, file.lines().size()); ++i) {
    const std::string line = lower(file.lines()[i]);
    for (const std::string& word : words)
      if (line.find(word) != std::string::npos) return true;
  }
  return false;
}

int setupIndex(Session& session, const std::string& name) {
  for (std::size_t i = 0; i < session.setups.size(); ++i)
    if (session.setups[i] == name) return static_cast<int>(i);
  session.setups.push_back(name);
  return static_cast<int>(session.setups.size()) - 1;
}

Observation blankRow(const ImportContext& context, ObservationKind kind, std::size_t line, double time) {
  const auto joints = static_cast<std::size_t>(context.machine.jointCount());
  Observation o;
  o.kind = kind;
  o.row = static_cast<std::int64_t>(line);
  o.time = time;
  o.position.assign(joints, 0.0);
  o.velocity.assign(joints, kNotMeasured);
  o.travel.assign(joints, 0.0);
  if (kind == ObservationKind::kDeviation) {
    o.deviation.assign(joints, kNotMeasured);
    o.deviationStd.assign(joints, kNotMeasured);
  }
  for (const auto& [name, value] : context.mapping.fixed) {
    const NameAndUnit split = splitUnit(name);
    const int j = jointOf(context.machine, split.stem);
    const auto unit = parseUnit(split.unitText);
    if (j >= 0 && unit) o.position[static_cast<std::size_t>(j)] = value * unit->factor;
  }
  return o;
}

}  // namespace mm
