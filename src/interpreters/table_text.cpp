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
constexpr std::string_view kSaveConfig = "#*#";

std::string rangeText(double lower, double upper) { return numberText(lower) + " to " + numberText(upper); }

bool isBlank(char c) { return kBlanks.find(c) != std::string_view::npos; }

std::string_view withoutRemark(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i)
    if ((text[i] == '#' || text[i] == ';') && (i == 0 || isBlank(text[i - 1]))) return text.substr(0, i);
  return text;
}

/// Reads the lines of a configuration file one after the other.
class SectionReader {
 public:
  explicit SectionReader(ConfigStyle style) : style_(style) {}

  void read(const TextLine& line) {
    std::string_view text = line.text;
    const bool klipper = style_ == ConfigStyle::kKlipper;
    if (klipper && startsWith(text, kSaveConfig)) {
      text.remove_prefix(kSaveConfig.size());
      if (!text.empty() && text.front() == ' ') text.remove_prefix(1);
      if (startsWith(text, "<---") || startsWith(trim(text), "DO NOT EDIT")) return;
    }
    const bool indented = !text.empty() && isBlank(text.front());
    text = klipper ? trim(withoutRemark(text)) : remarkLine(trim(text)) ? std::string_view() : trim(text);
    if (klipper && entry_ && (indented || text.empty())) {
      sections_[section_].entries.back().value += "\n" + std::string(text);
      return;
    }
    if (text.empty()) return;
    if (text.front() == '[')
      begin(text, line.place);
    else
      add(text, line.place);
  }

  std::vector<ConfigSection> take() {
    for (ConfigSection& section : sections_)
      for (ConfigEntry& entry : section.entries)
        while (!entry.value.empty() && entry.value.back() == '\n') entry.value.pop_back();
    return std::move(sections_);
  }

 private:
  static bool remarkLine(std::string_view text) {
    return !text.empty() && (text[0] == '#' || text[0] == ';');
  }

  void begin(std::string_view text, const FilePlace& place) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) refuse(place, "section '" + std::string(text) + "' has no ]");
    const std::string name(trim(text.substr(1, end - 1)));
    const auto found = std::find_if(sections_.begin(), sections_.end(),
                                    [&](const ConfigSection& section) { return section.name == name; });
    section_ = static_cast<std::size_t>(found - sections_.begin());
    if (found == sections_.end()) sections_.push_back({name, place, {}});
    entry_ = false;
    inSection_ = true;
  }

  void add(std::string_view text, const FilePlace& place) {
    const std::size_t at = text.find_first_of(style_ == ConfigStyle::kKlipper ? ":=" : "=");
    if (at == std::string_view::npos || at == 0)
      refuse(place, "'" + std::string(text) + "' is neither a section nor a key with its value");
    if (!inSection_)
      refuse(place, "key '" + std::string(trim(text.substr(0, at))) + "' stands before any section");
    std::string key(trim(text.substr(0, at)));
    if (style_ == ConfigStyle::kKlipper) key = lower(key);
    sections_[section_].entries.push_back({key, std::string(trim(text.substr(at + 1))), place});
    entry_ = true;
  }

  ConfigStyle style_;
  std::vector<ConfigSection> sections_;
  std::size_t section_ = 0;
  bool inSection_ = false, entry_ = false;
};

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

void refuse(const FilePlace& place, const std::string& what) {
  const std::string line = place.line == 0 ? "" : ":" + std::to_string(place.line);
  throw InputError(place.file.string() + line + ": " + what);
}

double tableNumber(std::string_view text, const FilePlace& place, const std::string& field) {
  std::string_view digits = trim(text);
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  double value = 0.0;
  if (digits.empty() || !parseNumber(std::string(digits), value) || !std::isfinite(value))
    refuse(place, field + ": '" + std::string(trim(text)) + "' is not a number");
  return value;
}

double tableNumber(std::string_view text, const FilePlace& place, const std::string& field, double lower,
                   double upper) {
  const double value = tableNumber(text, place, field);
  if (value < lower || value > upper)
    refuse(place, field + ": " + std::string(trim(text)) + " is not within " + rangeText(lower, upper));
  return value;
}

int tableInteger(std::string_view text, const FilePlace& place, const std::string& field, int lower,
                 int upper) {
  const double value = tableNumber(text, place, field, lower, upper);
  if (value != std::floor(value))
    refuse(place, field + ": " + std::string(trim(text)) + " is not a whole number");
  return static_cast<int>(value);
}

bool tableFlag(std::string_view text, const FilePlace& place, const std::string& field) {
  return tableInteger(text, place, field, 0, 1) == 1;
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

const ConfigEntry* ConfigSection::find(std::string_view key) const {
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry)
    if (entry->key == key) return &*entry;
  return nullptr;
}

const ConfigEntry& ConfigSection::need(std::string_view key) const {
  const ConfigEntry* entry = find(key);
  if (entry == nullptr) refuse(place, "[" + name + "] has no '" + std::string(key) + "'");
  return *entry;
}

std::vector<ConfigSection> configSections(const std::filesystem::path& file, ConfigStyle style) {
  SectionReader reader(style);
  for (const TextLine& line : textLines(file)) reader.read(line);
  return reader.take();
}

const ConfigSection* findSection(const std::vector<ConfigSection>& sections, std::string_view name) {
  for (const ConfigSection& section : sections)
    if (section.name == name) return &section;
  return nullptr;
}

}  // namespace mm
