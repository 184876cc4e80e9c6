#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace mm {

/// What the user says of a file of measurements, in a small YAML: whatever is not said is seen in the file.
struct ColumnMapping {
  std::string source;  // path, for messages; empty: there is none
  std::string format;
  std::optional<char> separator;
  std::optional<bool> decimalComma;
  std::optional<std::size_t> headerLine;        // 0: none, the columns are called 1, 2 …
  std::map<std::string, std::string> columns;   // name in the file -> name_unit, or `ignore`
  bool ignoreOthers = false;                    // columns that are not listed
  std::map<std::string, std::string> features;  // name in the file -> in the artifact
  std::map<std::string, std::string> settings;  // what a format asks for: axis, radius_mm, …
  std::map<std::string, double> fixed;          // <joint>_mm, _deg: joints without a column
  std::map<std::string, int> lines;             // of each setting, for messages

  /// A setting, or empty.
  std::string setting(const std::string& key) const;
  /// "file:line: " of a setting that is said, for messages.
  std::string place(const std::string& key) const;
};

/// @throw InputError naming file, line and key.
ColumnMapping loadColumnMapping(const std::filesystem::path& file);
ColumnMapping parseColumnMapping(const std::string& yaml, const std::string& source);

}  // namespace mm
