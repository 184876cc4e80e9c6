#pragma once
#include <cstddef>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

/// A place in a file of a controller, for messages.
struct FilePlace {
  std::filesystem::path file;
  std::size_t line = 0;  // from 1; 0: the file as a whole
};

/// A line of a text file without its line break, or a part of it.
struct TextLine {
  std::string text;
  FilePlace place;
};

/// The lines of a text file; line breaks of Unix and Windows, a byte order mark is taken off.
/// @throw InputError when it cannot be read.
std::vector<TextLine> textLines(const std::filesystem::path& file);
/// The files of a folder with one of these extensions (in any case), by their names.
std::vector<std::filesystem::path> filesEndingIn(const std::vector<std::string>& extensions,
                                                 const std::filesystem::path& folder);

/// Throws InputError: "file:line: what".
[[noreturn]] void refuse(const FilePlace& place, const std::string& what);

inline constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// A decimal number as controllers write it, a plus sign allowed, within [lower, upper]. @throw InputError
/// naming place, field and value.
double tableNumber(std::string_view text, const FilePlace& place, const std::string& field,
                   double lower = -kNoBound, double upper = kNoBound);
/// A whole number within [lower, upper].
int tableInteger(std::string_view text, const FilePlace& place, const std::string& field, int lower,
                 int upper);

/// Words between blanks.
std::vector<std::string> wordsBetweenBlanks(std::string_view text);
/// Parts between `separator`, without the blanks around them.
std::vector<std::string> partsBetween(std::string_view text, char separator);
/// Capital letters (ASCII).
std::string capitals(std::string_view text);
/// Capital letters without any blank.
std::string capitalsWithoutBlanks(std::string_view text);

/// Cells of a line of a table.
struct TableRow {
  std::vector<std::string> cells;
  FilePlace place;
};

/// Names of columns, and rows of cells below them.
struct TextTable {
  TableRow names;
  std::vector<TableRow> rows;

  /// Puts a row below the others, or names the columns with the first one. @throw InputError: it has not a
  /// cell for each column.
  void add(std::vector<std::string> cells, const FilePlace& place);
  /// Whether there is such a column.
  bool has(const std::string& column) const;
  /// The numbers of a column that is there.
  std::vector<double> numbers(const std::string& column) const;
  /// The same of positions. @throw InputError: none, more than `most`, or one that is not above the one
  /// before it.
  std::vector<double> rising(const std::string& column,
                             std::size_t most = std::numeric_limits<std::size_t>::max()) const;
};

/// What files say of keys, the last time that they do.
class KeyedValues {
 public:
  /// @param whole place for messages of what is missing.
  explicit KeyedValues(FilePlace whole) : whole_(std::move(whole)) {}

  /// The last one counts.
  void set(const std::string& key, std::string_view text, const FilePlace& place);
  /// Null where it is not given.
  const TextLine* find(const std::string& key) const;
  bool has(const std::string& key) const { return find(key) != nullptr; }  ///< whether it is given
  bool hasAny(const std::string& start) const;                             ///< a key that begins so
  /// @throw InputError where it is missing.
  const TextLine& need(const std::string& key) const;
  const FilePlace& whole() const { return whole_; }  ///< the place of all
  FilePlace place(const std::string& key) const;     ///< of a key; of the whole where it is not given

  /// Its number within [lower, upper]. @param missing what it is where it is not given; null: it must be.
  double number(const std::string& key, std::optional<double> missing = {}, double lower = -kNoBound,
                double upper = kNoBound) const;
  int integer(const std::string& key, int lower, int upper,
              std::optional<int> missing = {}) const;     ///< whole
  bool flag(const std::string& key, bool missing) const;  ///< 0 or 1
  /// @throw InputError where it says another number than the only one of which the interpreter has the rules.
  void only(const std::string& key, int number) const;
  [[noreturn]] void refuse(const std::string& key,
                           const std::string& what) const;  ///< "file:line: key: what"

 private:
  FilePlace whole_;
  std::map<std::string, TextLine> values_;
};

/// `[name]` of a configuration file with its keys.
struct ConfigSection {
  std::string name;
  KeyedValues values;
  std::map<std::string, std::vector<TextLine>> below;  // indented lines below a key without a value
};

/// The sections of a configuration file, `key = value` or `key: value` a line, remarks behind # and ;.
/// Sections of the same name are one. @throw InputError naming file and line.
std::vector<ConfigSection> configSections(const std::filesystem::path& file);
/// The section of that name, or null.
const ConfigSection* findSection(const std::vector<ConfigSection>& sections, std::string_view name);

}  // namespace mm
