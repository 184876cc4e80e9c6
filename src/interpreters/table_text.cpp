#include "interpreters/table_text.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "base/number_text.h"
#include "base/read_file.h"
#include "base/text.h"

namespace mm {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool isBlank(char c) { return kBlanks.find(c) != std::string_view::npos; }

/// A # or ; in the middle of a word begins no remark.
std::string_view withoutRemark(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i)
    if ((text[i] == '#' || text[i] == ';') && (i == 0 || isBlank(text[i - 1]))) return text.substr(0, i);
  return text;
}

}  // namespace

std::vector<TextLine> textLines(const std::filesystem::path& file) {
  std::istringstream stream(readWholeFile(file, "check the path"));
  std::vector<TextLine> lines;
  std::string text;
  while (std::getline(stream, text)) {
    if (lines.empty() && startsWith(text, kByteOrderMark)) text.erase(0, kByteOrderMark.size());
    if (!text.empty() && text.back() == '\r') text.pop_back();
    lines.push_back({text, {file, lines.size() + 1}});
  }
  return lines;
}

std::vector<std::filesystem::path> filesEndingIn(const std::vector<std::string>& extensions,
                                                 const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (std::find(extensions.begin(), extensions.end(), lower(entry.path().extension().string())) !=
        extensions.end())
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void refuse(const FilePlace& place, const std::string& what) {
  const std::string line = place.line == 0 ? "" : ":" + std::to_string(place.line);
  throw InputError(place.file.string() + line + ": " + what);
}

double tableNumber(std::string_view text, const FilePlace& place, const std::string& field, double lower,
                   double upper) {
  const std::string shown(trim(text));
  double value = 0.0;
  if (!parseNumber(shown.substr(shown[0] == '+' ? 1 : 0), value) || !std::isfinite(value))
    refuse(place, field + ": '" + shown + "' is not a number");
  if (value < lower || value > upper)
    refuse(place, field + ": " + shown + " is not within " + numberText(lower) + " to " + numberText(upper));
  return value;
}

int tableInteger(std::string_view text, const FilePlace& place, const std::string& field, int lower,
                 int upper) {
  const double value = tableNumber(text, place, field, lower, upper);
  if (value != std::floor(value))
    refuse(place, field + ": " + std::string(trim(text)) + " is not a whole number");
  return static_cast<int>(value);
}

std::vector<std::string> wordsBetweenBlanks(std::string_view text) {
  std::vector<std::string> words;
  while (!(text = trim(text)).empty()) {
    const std::size_t end = std::min(text.find_first_of(kBlanks), text.size());
    words.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return words;
}

std::vector<std::string> partsBetween(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.emplace_back(trim(text.substr(0, end)));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::string capitals(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return result;
}

std::string capitalsWithoutBlanks(std::string_view text) {
  return capitals(joined(wordsBetweenBlanks(text), ""));
}

void TextTable::add(std::vector<std::string> cells, const FilePlace& place) {
  if (names.cells.empty()) {
    names = {std::move(cells), place};
    return;
  }
  if (cells.size() != names.cells.size())
    refuse(place, "has " + std::to_string(cells.size()) + " cells below " +
                      std::to_string(names.cells.size()) + " columns; one is expected in each");
  rows.push_back({std::move(cells), place});
}

bool TextTable::has(const std::string& column) const {
  return std::find(names.cells.begin(), names.cells.end(), column) != names.cells.end();
}

std::vector<double> TextTable::numbers(const std::string& column) const {
  const auto found = std::find(names.cells.begin(), names.cells.end(), column);
  if (found == names.cells.end()) refuse(names.place, "column " + column + " is missing");
  const auto at = static_cast<std::size_t>(found - names.cells.begin());
  std::vector<double> numbers;
  for (const TableRow& row : rows) numbers.push_back(tableNumber(row.cells[at], row.place, column));
  return numbers;
}

std::vector<double> TextTable::rising(const std::string& column, std::size_t most) const {
  const std::vector<double> positions = numbers(column);
  if (positions.empty()) refuse({names.place.file, 0}, "has no lines of values");
  if (positions.size() > most)
    refuse(rows[most].place, "entry " + std::to_string(most + 1) + " of at most " + std::to_string(most));
  for (std::size_t i = 1; i < positions.size(); ++i)
    if (positions[i] <= positions[i - 1])
      refuse(rows[i].place, column + ": " + numberText(positions[i]) +
                                " is not above that of the line before; values must increase");
  return positions;
}

void KeyedValues::set(const std::string& key, std::string_view text, const FilePlace& place) {
  values_[key] = {std::string(text), place};
}

const TextLine* KeyedValues::find(const std::string& key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? nullptr : &found->second;
}

bool KeyedValues::hasAny(const std::string& start) const {
  const auto found = values_.lower_bound(start);
  return found != values_.end() && startsWith(found->first, start);
}

const TextLine& KeyedValues::need(const std::string& key) const {
  if (!has(key)) mm::refuse(whole_, key + " is missing");
  return *find(key);
}

FilePlace KeyedValues::place(const std::string& key) const { return has(key) ? find(key)->place : whole_; }

double KeyedValues::number(const std::string& key, std::optional<double> missing, double lower,
                           double upper) const {
  if (missing && !has(key)) return *missing;
  const TextLine& said = need(key);
  return tableNumber(said.text, said.place, key, lower, upper);
}

int KeyedValues::integer(const std::string& key, int lower, int upper, std::optional<int> missing) const {
  if (missing && !has(key)) return *missing;
  const TextLine& said = need(key);
  return tableInteger(said.text, said.place, key, lower, upper);
}

bool KeyedValues::flag(const std::string& key, bool missing) const {
  return integer(key, 0, 1, missing) == 1;
}

void KeyedValues::only(const std::string& key, int only) const {
  if (number(key, only) != only)
    refuse(key, find(key)->text + " is not read, only " + std::to_string(only) +
                    "; docs/interpreters.md tells of which tables the rules are known");
}

void KeyedValues::refuse(const std::string& key, const std::string& what) const {
  mm::refuse(place(key), key + ": " + what);
}

std::vector<ConfigSection> configSections(const std::filesystem::path& file) {
  std::vector<ConfigSection> sections;
  ConfigSection* section = nullptr;
  std::string last;   // key; indented lines below it belong to its value
  bool open = false;  // it has none on its own line
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(withoutRemark(line.text));
    if (text.empty()) continue;
    const std::size_t at = text.find_first_of(":="), end = text.find(']');
    if (text.front() == '[') {
      if (end == std::string_view::npos) refuse(line.place, "section '" + std::string(text) + "' has no ]");
      const std::string name(trim(text.substr(1, end - 1)));
      const auto known = std::find_if(sections.begin(), sections.end(),
                                      [&](const ConfigSection& s) { return s.name == name; });
      section = known != sections.end()
                    ? &*known
                    : &sections.emplace_back(ConfigSection{name, KeyedValues(line.place), {}});
      last.clear();
    } else if (!last.empty() && isBlank(line.text[0]) && (open || at == std::string_view::npos || at == 0)) {
      section->below[last].push_back({std::string(text), line.place});
    } else if (at == std::string_view::npos || at == 0) {
      refuse(line.place, "'" + std::string(text) + "' is neither a section nor a key with its value");
    } else {
      const std::string key(trim(text.substr(0, at)));
      const std::string_view value = trim(text.substr(at + 1));
      if (section == nullptr) refuse(line.place, "key '" + key + "' stands before any section");
      section->values.set(key, value, line.place);
      last = key;
      open = value.empty();
    }
  }
  return sections;
}

const ConfigSection* findSection(const std::vector<ConfigSection>& sections, std::string_view name) {
  for (const ConfigSection& section : sections)
    if (section.name == name) return &section;
  return nullptr;
}

}  // namespace mm
