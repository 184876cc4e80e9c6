#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"

namespace mm {

/// Splits a line at its separators; blanks around a cell and quotes around it are taken off. A blank as
/// separator stands for any number of blanks and tabs. The cells point into `line`.
/// @return false when a quote is not closed.
bool splitCells(std::string_view line, std::vector<std::string_view>& cells, char separator = ',');

/// What stands between the values of a list: `[0, 5; 10]`.
inline constexpr std::string_view kListMarks = " \t\r\n,;[]()";

/// The words of a text, cut at blanks (or at what is in `between`), without empty ones.
std::vector<std::string_view> wordsIn(std::string_view text, std::string_view between = kBlanks);

/// Those that are numbers with a decimal point.
std::vector<double> numbersIn(std::string_view text, std::string_view between = kBlanks);

/// Whether a word is one of those in a list: `mean|std dev|max`.
bool isOneOf(std::string_view word, std::string_view list);

/// How loggers and spreadsheets write that there is no value: nan, n/a, #N/A, ---, ….
bool meansNothing(std::string_view cell);

/// Whether a line of somebody else's file is a remark: #, % or // at its beginning.
bool isRemark(std::string_view line);

/// Whether a row is none of measurements but sums them up: its first cell is Average, Std Dev, Summe, Max ….
bool sumsUp(const std::vector<std::string_view>& cells);

/// -1 or +1 of a direction of travel (+, up, forward, →, vor …); 0: it is none.
double directionOf(std::string_view cell);

/// A finite number with a decimal point and nothing else, as the import format wants it.
bool parsePlainNumber(std::string_view cell, double& value);

/// A finite number as people write it: with a decimal point or comma, a minus of typesetters, thousands set
/// apart by the other mark, by blanks or by apostrophes (1,234.567; 1.234,567; 1 234,567; 1'234.567). Groups
/// have three digits, the first one to three and no zero in front.
bool parseNumber(std::string_view cell, bool decimalComma, double& value);

/// What the marks of one number say about the decimal mark of its table.
enum class DecimalMark {
  kNone,        // no number, or one without marks
  kPoint,       // 12.5, 1,234.5, 1,234,567
  kComma,       // 12,5, 1.234,5, 1.234.567
  kPointOrNot,  // 1.234 with a decimal point, or 1234 where commas are decimal
  kCommaOrNot   // 1,234 likewise
};
DecimalMark decimalMarkOf(std::string_view cell);  ///< that it must have

/// Without the unit that stands behind the number in each cell of a column.
std::string_view withoutUnit(std::string_view cell, std::string_view unit);

}  // namespace mm
