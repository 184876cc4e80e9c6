#include "import/decimal_mark.h"

#include <algorithm>

#include "session/csv_cells.h"

namespace mm {

void DecimalMarkFinder::look(std::size_t line, const std::vector<std::string_view>& cells) {
  for (std::size_t i = 0; i < std::min(cells.size(), columns_.size()); ++i) {
    Column& c = columns_[i];
    const auto first = [&](UnclearNumber& unclear) {
      if (unclear.line == 0) unclear = {line, i, std::string(cells[i])};
    };
    const DecimalMark mark = decimalMarkOf(cells[i]);
    c.point += mark == DecimalMark::kPoint;
    c.comma += mark == DecimalMark::kComma;
    if (mark == DecimalMark::kPointOrNot) first(c.pointOrNot);
    if (mark == DecimalMark::kCommaOrNot) first(c.commaOrNot);
  }
}

DecimalMarks DecimalMarkFinder::decide() const {
  std::size_t points = 0, commas = 0;
  bool pointOrNot = false, commaOrNot = false;
  for (const Column& c : columns_) {
    points += c.point;
    commas += c.comma;
    pointOrNot |= c.pointOrNot.line > 0;
    commaOrNot |= c.commaOrNot.line > 0;
  }
  DecimalMarks marks;
  marks.proven = points + commas > 0;
  marks.comma = points == 0 && (commas > 0 || (commaOrNot && !pointOrNot));
  const bool comma = marks.proven && marks.comma;
  for (const Column& c : columns_) {
    const UnclearNumber& unclear = comma ? c.pointOrNot : c.commaOrNot;
    if (unclear.line > 0 && (comma ? c.comma : c.point) == 0) marks.unclear.push_back(unclear);
  }
  return marks;
}

}  // namespace mm
