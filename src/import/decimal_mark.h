#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

/// A cell of which it cannot be seen whether its mark is decimal or sets thousands apart: 1,234.
struct UnclearNumber {
  std::size_t line = 0, column = 0;  // line from 1, column from 0
  std::string cell;
};

/// The decimal mark of a table, as its numbers show it.
struct DecimalMarks {
  bool comma = false;                  // numbers have decimal commas, else points
  bool proven = true;                  // by a number that has no other meaning
  std::vector<UnclearNumber> unclear;  // the first of each column in which nothing shows it
};

/// Collects what the numbers of a table show of its decimal mark.
class DecimalMarkFinder {
 public:
  explicit DecimalMarkFinder(std::size_t columns) : columns_(columns) {}    ///< of a table
  void look(std::size_t line, const std::vector<std::string_view>& cells);  ///< at a row
  /// A comma that nothing contradicts is decimal, and so is a point; where the table shows the other mark to
  /// be decimal, a column must show by a number of its own that it sets thousands apart.
  DecimalMarks decide() const;

 private:
  struct Column {
    std::size_t point = 0, comma = 0;  // numbers that have no other meaning
    UnclearNumber pointOrNot, commaOrNot;
  };
  std::vector<Column> columns_;
};

}  // namespace mm
