#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

/// A place in a file of a controller, for messages.
struct FilePlace {
  std::filesystem::path file;
  std::size_t line = 0;  // from 1; 0: the file as a whole
};

/// A line of a text file without its line break.
struct TextLine {
  std::string text;
  FilePlace place;
};

/// The lines of a text file; line breaks of Unix and Windows, a byte order mark is taken off.
/// @throw InputError when it cannot be read.
std::vector<TextLine> textLines(const std::filesystem::path& file);

/// Throws InputError: "file:line: what".
[[noreturn]] void refuse(const FilePlace& place, const std::string& what);

/// A decimal number as controllers write it, a plus sign allowed. @throw InputError naming place, field and
/// value.
double tableNumber(std::string_view text, const FilePlace& place, const std::string& field);
/// The same within [lower, upper].
double tableNumber(std::string_view text, const FilePlace& place, const std::string& field, double lower,
                   double upper);
/// A whole number within [lower, upper].
int tableInteger(std::string_view text, const FilePlace& place, const std::string& field, int lower,
                 int upper);
/// 0 or 1.
bool tableFlag(std::string_view text, const FilePlace& place, const std::string& field);

/// Words between blanks.
std::vector<std::string> wordsBetweenBlanks(std::string_view text);
/// Parts between `separator`, without the blanks around them.
std::vector<std::string> partsBetween(std::string_view text, char separator);
/// Capital letters (ASCII).
std::string capitals(std::string_view text);

/// A key of a section of a configuration file.
struct ConfigEntry {
  std::string key;
  std::string value;  // lines after the first one separated by '\n', where the style has them
  FilePlace place;    // of the key
};

/// `[name]` of a configuration file with its keys, in the order of the file.
struct ConfigSection {
  std::string name;
  FilePlace place;
  std::vector<ConfigEntry> entries;

  /// The last entry of that key, or null.
  const ConfigEntry* find(std::string_view key) const;
  /// The same; @throw InputError when it is missing.
  const ConfigEntry& need(std::string_view key) const;
};

/// How a program writes its configuration.
enum class ConfigStyle {
  kIni,      // LinuxCNC: KEY = value, whole lines of # or ; are remarks
  kKlipper,  // key: value or key = value, remarks behind, indented lines continue, the block `#*#`
};

/// The sections of a configuration file; sections of the same name are one. @throw InputError naming file and
/// line.
std::vector<ConfigSection> configSections(const std::filesystem::path& file, ConfigStyle style);
/// The section of that name, or null.
const ConfigSection* findSection(const std::vector<ConfigSection>& sections, std::string_view name);

}  // namespace mm
