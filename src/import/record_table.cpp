#include "import/record_table.h"

#include <algorithm>

#include "base/error.h"
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
  if (layout_.firstRow == 0)
    throw InputError(context.file.path().string() + ": it contains no row of numbers");
  eachRow(context.file, layout_, [&](std::size_t n, std::string_view line, Cells& cells) {
    if (cells.empty()) return context.refuse(n, "a quote is not closed, or text follows it");
    while (!cells.empty() && cells.back().empty()) cells.pop_back();
    if (cells.empty()) return;
    double number = 0.0;
    const bool numbers = std::any_of(cells.begin(), cells.end(), [&](std::string_view c) {
      return parseNumber(c, layout_.decimalComma, number);
    });
    std::string key, value;
    if (cells.size() < layout_.names.size() && keyValue(line, key, value) &&
        key.find_first_not_of("+-.0123456789") != std::string::npos)
      between_[n] = {key, value};
    else if (!numbers || sumsUp(cells))
      context.note("line " + std::to_string(n) + " is not a data row and was skipped: '" +
                   shownText(trim(line)) + "'");
    else
      rows_.push_back({n, {cells.begin(), cells.end()}});
  });
}

int RecordTable::column(std::string_view words) const {
  for (const std::string_view wanted : wordsIn(words))
    for (std::size_t i = 0; i < layout_.names.size(); ++i)
      for (const std::string& word : wordsOf(splitUnit(layout_.names[i]).stem))
        if (word == wanted) return static_cast<int>(i);
  return -1;
}

RecordTable::Said RecordTable::find(const std::vector<std::string>& keys, const std::string& mapped) const {
  const std::string own = context_.mapping.setting(mapped);
  if (!own.empty()) return {mapped, own, ""};
  for (const std::string& key : keys)
    for (const auto& [name, value] : head_) {
      const NameAndUnit split = splitUnit(name);
      if (name == key || split.stem == key) return {name, value, split.unitText};
    }
  return {};
}

bool RecordTable::number(const std::vector<std::string>& keys, const std::string& mapped, UnitKind kind,
                         const std::string& unit, double& value) {
  const Said said = find(keys, mapped);
  if (said.text.empty()) return false;
  const std::size_t end = std::min(said.text.size(), said.text.find_first_not_of("+-.,0123456789eE"));
  const std::string digits(trim(said.text.substr(0, end))), behind(trim(said.text.substr(end)));
  const auto read = parseUnit(!behind.empty() ? behind : !said.unitText.empty() ? said.unitText : unit, kind);
  if (!read || (!parseNumber(digits, false, value) && !parseNumber(digits, true, value))) {
    context_.refuse("'" + shownText(said.key) + "' is '" + shownText(said.text) + "', but must be " +
                    factsOf(kind).inWords + "; " + context_.ask(mapped, "<number>"));
    return false;
  }
  value *= read->factor;
  return true;
}

bool RecordTable::place(const std::vector<std::string>& keys, const std::string& mapped,
                        const std::string& of, const std::vector<int>& joints,
                        std::vector<double>& readings) const {
  const std::vector<double> values = numbersIn(said(keys, mapped), kListMarks);
  const bool all = values.size() == 3;
  if (!all && values.size() != joints.size()) {
    context_.refuse("the position of " + of + " is not stated; " + context_.ask(mapped, "[0, 0, 0]"));
    return false;
  }
  for (std::size_t k = 0; k < values.size(); ++k)
    if (const int j = all ? jointOf(context_.machine, std::string(1, "xyz"[k])) : joints[k]; j >= 0)
      readings[static_cast<std::size_t>(j)] = values[k] * kMillimetre;
  return true;
}

std::pair<std::string, std::string> RecordTable::nameAndUnit(int column) const {
  const auto at = static_cast<std::size_t>(column);
  const std::string name = at < layout_.names.size() ? layout_.names[at] : std::to_string(column + 1);
  const std::string unit = splitUnit(name).unitText;
  return {name, unit.empty() && at < layout_.units.size() ? layout_.units[at] : unit};
}

double RecordTable::value(const Row& row, int column, UnitKind kind, std::string fallback) {
  const std::string cell = text(row, column);
  if (cell.empty() || meansNothing(cell)) return kNotMeasured;
  auto [name, unitText] = nameAndUnit(column);
  double value = 0.0;
  if (!parseNumber(cell, layout_.decimalComma, value)) {
    context_.refuse(row.line,
                    "column '" + shownText(name) + "': '" + shownText(cell) +
                        "' is not a finite number; leave the cell empty where nothing was measured");
    return kNotMeasured;
  }
  if (fallback.empty())
    fallback = kind == UnitKind::kLength  ? context_.mapping.setting("unit")
               : kind == UnitKind::kAngle ? "deg"
                                          : "s";
  if (unitText.empty()) unitText = fallback;
  const auto unit = parseUnit(unitText, kind);
  if (!unit) {
    refuseHead("column '" + shownText(name) +
               (unitText.empty() ? "' has no unit" : "' is in '" + shownText(unitText) + "'") +
               ", but it is " + factsOf(kind).inWords + "; write the unit in brackets after the name, or " +
               context_.ask("unit", kind == UnitKind::kLength ? "um" : "deg"));
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
  if (j < 0)
    context_.refuse(key + " " +
                    (name.empty() ? std::string("is not stated")
                                  : "'" + shownText(name) + "' is not a joint of this machine") +
                    " (" + jointNames(context_.machine) + "); " +
                    context_.ask(key, context_.machine.joints().front().name));
  return j;
}

void RecordTable::show(int column, const std::string& meaning, const std::string& unit) {
  if (column < 0) return;
  const auto [name, own] = nameAndUnit(column);
  ColumnRange range;
  for (const Row& row : rows_) {
    double v = 0.0;
    const std::string cell = text(row, column);
    if (parseNumber(cell, layout_.decimalComma, v)) range.add(cell, v);
  }
  std::vector<std::vector<std::string>>& shown = context_.imported.rows;
  shown.resize(std::min(kRowsShown, rows_.size()));
  for (std::size_t r = 0; r < shown.size(); ++r) shown[r].push_back(text(rows_[r], column));
  context_.imported.columns.push_back({name, meaning, own.empty() ? unit : own, range.lower, range.upper,
                                       rows_.empty() ? "" : text(rows_.front(), column), ""});
}

void RecordTable::refuseHead(const std::string& what) const {
  context_.refuse(std::max<std::size_t>(1, layout_.headerLine), what);
}

bool RecordTable::bringsArtifact(const std::string& instrument, const std::string& of) const {
  if (context_.artifact == nullptr) return true;
  context_.refuse(instrument + " defines its own artifact (" + of + "); omit --artifact");
  return false;
}

Session ownArtifact(const ImportContext& context, const std::string& artifact, Feature feature) {
  Session session = emptySession(context);
  session.artifact = Artifact();
  session.artifact.name = artifact;
  feature.known = false;
  session.artifact.features.push_back(std::move(feature));
  return session;
}

}  // namespace mm
