#include "session/csv_cells.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/text.h"

namespace mm {
namespace {

/// What sets groups of three digits apart beside comma and point: blanks of all widths, apostrophes.
constexpr std::string_view kSpacers[] = {" ", "\xC2\xA0",    "\xE2\x80\xAF", "\xE2\x80\x89",
                                         "'", "\xE2\x80\x99"};

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// Digits in groups of three with `mark` between: 1,234,567. @param plain gets the digits alone.
bool groups(std::string_view text, std::string_view mark, std::string& plain) {
  plain.clear();
  std::size_t inGroup = 0, count = 0;
  for (std::size_t i = 0; i < text.size();) {
    if (isDigit(text[i])) {
      plain += text[i++];
      ++inGroup;
      continue;
    }
    const bool first = count == 0;
    if (text.substr(i, mark.size()) != mark || inGroup > 3 || inGroup == 0 || (!first && inGroup != 3))
      return false;
    i += mark.size();
    inGroup = 0;
    ++count;
  }
  return count > 0 && inGroup == 3 && plain.front() != '0';
}

/// The whole part of a number in digits alone, whatever sets its groups apart but the decimal mark.
bool ungrouped(std::string_view whole, char decimal, std::string& plain) {
  const std::string_view other = decimal == ',' ? "." : ",";
  if (groups(whole, other, plain)) return true;
  return std::any_of(std::begin(kSpacers), std::end(kSpacers),
                     [&](std::string_view mark) { return groups(whole, mark, plain); });
}

/// The sign taken off; "-", or nothing.
std::string takeSign(std::string_view& text) {
  for (const std::string_view minus : {"-", "\xE2\x88\x92", "\xE2\x80\x93"})
    if (startsWith(text, minus)) {
      text = trim(text.substr(minus.size()));
      return "-";
    }
  if (startsWith(text, "+")) text.remove_prefix(1);
  return "";
}

bool allDigits(std::string_view text) { return std::all_of(text.begin(), text.end(), isDigit); }

bool splitAtBlanks(std::string_view line, std::vector<std::string_view>& cells) {
  for (line = trim(line); !line.empty(); line = trim(line)) {
    const bool quoted = line.front() == '"';
    const std::size_t end = quoted ? line.find('"', 1) : line.find_first_of(" \t");
    if (quoted && end == std::string_view::npos) return false;
    cells.push_back(line.substr(quoted ? 1 : 0, quoted ? end - 1 : end));
    line.remove_prefix(end == std::string_view::npos ? line.size() : end + 1);
  }
  return true;
}

}  // namespace

bool splitCells(std::string_view line, std::vector<std::string_view>& cells, char separator) {
  cells.clear();
  if (separator == ' ') return splitAtBlanks(line, cells);
  for (std::size_t begin = 0;;) {
    const std::size_t first = std::min(line.size(), line.find_first_not_of(' ', begin));
    const bool quoted = line.substr(first, 1) == "\"";
    const std::size_t close = quoted ? line.find('"', first + 1) : begin;
    if (close == std::string_view::npos) return false;
    const std::size_t next = std::min(line.size(), line.find(separator, close));
    if (!quoted)
      cells.push_back(trim(line.substr(begin, next - begin)));
    else if (trim(line.substr(close + 1, next - close - 1)).empty())
      cells.push_back(line.substr(first + 1, close - first - 1));
    else
      return false;
    if (next == line.size()) return true;
    begin = next + 1;
  }
}

std::vector<std::string_view> wordsIn(std::string_view text, std::string_view between) {
  std::vector<std::string_view> words;
  for (std::size_t begin = 0; (begin = text.find_first_not_of(between, begin)) < text.size();) {
    const std::size_t end = std::min(text.size(), text.find_first_of(between, begin));
    words.push_back(text.substr(begin, end - begin));
    begin = end;
  }
  return words;
}

std::vector<double> numbersIn(std::string_view text, std::string_view between) {
  std::vector<double> numbers;
  double value = 0.0;
  for (const std::string_view word : wordsIn(text, between))
    if (parseNumber(word, false, value)) numbers.push_back(value);
  return numbers;
}

bool isOneOf(std::string_view word, std::string_view list) {
  if (word.empty() || word.find('|') != std::string_view::npos) return false;
  for (std::size_t at = list.find(word); at < list.size(); at = list.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || list[at - 1] == '|') && (end == list.size() || list[end] == '|')) return true;
  }
  return false;
}

bool meansNothing(std::string_view cell) {
  static constexpr std::string_view kWords =
      "nan|n/a|na|#n/a|<na>|n.a.|n.d.|n. a.|n. d.|k.a.|k. "
      "a.|nd|null|none|nil|#nv|#value!|#div/"
      "0!|#num!|#ref!|#wert!|-nan|nan(ind)|-nan(ind)|1.#qnan|1.#ind|-1.#ind|missing|?";
  constexpr std::size_t kLongest = 9;
  if (cell.size() > kLongest) return false;
  const auto dashes = [](std::string_view text) {
    for (const std::string_view dash : {"-", "\xE2\x80\x93", "\xE2\x80\x94"})
      while (startsWith(text, dash)) text.remove_prefix(dash.size());
    return text.empty();
  };
  return !cell.empty() && (dashes(cell) || isOneOf(lower(cell), kWords));
}

bool isRemark(std::string_view line) {
  line = trim(line);
  return startsWith(line, "#") || startsWith(line, "%") || startsWith(line, "//");
}

bool sumsUp(const std::vector<std::string_view>& cells) {
  static constexpr std::string_view kWords =
      "average|avg|mean|mean value|mittelwert|mittel|moyenne|media|std|std dev|std. "
      "dev.|stdev|stddev|std.dev.|standard deviation|standardabweichung|stdabw|sigma|écart "
      "type|écart-type|min|minimum|max|maximum|range|spannweite|span|sum|summe|somme|total|gesamt|median|"
      "médiane|count|anzahl|rms|minimum value|maximum value";
  const auto first = std::find_if(cells.begin(), cells.end(), [](std::string_view c) { return !c.empty(); });
  return first != cells.end() && isOneOf(lower(trim(*first, " :=\t")), kWords);
}

double directionOf(std::string_view cell) {
  static constexpr std::string_view kUp =
      "+|+1|1|up|fwd|forward|forwards|pos|positive|→|↑|vor|vorwärts|hin|aller|avant|+ve|auf|aufwärts|"
      "ansteigend|steigend|ascending|upwards|increasing|montée|andata";
  static constexpr std::string_view kDown =
      "-|-1|down|bwd|back|backward|backwards|rev|reverse|neg|negative|←|↓|−|zurück|rück|rückwärts|her|retour|"
      "arrière|-ve|ab|abwärts|absteigend|fallend|descending|downwards|decreasing|descente|ritorno";
  const std::string word = lower(cell);
  return isOneOf(word, kUp) ? 1.0 : isOneOf(word, kDown) ? -1.0 : 0.0;
}

bool parsePlainNumber(std::string_view cell, double& value) {
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') cell.remove_prefix(1);
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return !cell.empty() && error == std::errc() && end == cell.data() + cell.size() && std::isfinite(value);
}

bool parseNumber(std::string_view cell, bool decimalComma, double& value) {
  cell = trim(cell);
  const char decimal = decimalComma ? ',' : '.';
  if ((!decimalComma || cell.find_first_of(",.") == std::string_view::npos) && parsePlainNumber(cell, value))
    return true;
  const std::string sign = takeSign(cell);
  if (cell.empty() || (!isDigit(cell[0]) && cell[0] != decimal)) return false;
  const std::size_t cut = std::min(cell.size(), cell.find(decimal));
  const std::string_view whole = cell.substr(0, cut), part = cell.substr(std::min(cell.size(), cut + 1));
  std::string plain(whole), digits;
  if (ungrouped(whole, decimal, digits)) {
    if (!allDigits(part)) return false;  // no exponent behind groups
    plain = digits;
  } else if (decimalComma && cell.find('.') != std::string_view::npos) {
    return false;
  }
  plain.insert(0, sign);
  if (cut < cell.size()) plain.append(1, '.').append(part);
  return parsePlainNumber(plain, value);
}

DecimalMark decimalMarkOf(std::string_view cell) {
  cell = trim(cell);
  takeSign(cell);
  if (cell.empty()) return DecimalMark::kNone;
  cell = cell.substr(0, cell.find_last_of("0123456789") + 1);  // a unit may stand behind
  double value = 0.0;
  const bool point = parseNumber(cell, false, value), comma = parseNumber(cell, true, value);
  const bool points = cell.find('.') != std::string_view::npos,
             commas = cell.find(',') != std::string_view::npos;
  if (!points && !commas) return DecimalMark::kNone;
  if (point && comma) return points ? DecimalMark::kPointOrNot : DecimalMark::kCommaOrNot;
  return point ? DecimalMark::kPoint : comma ? DecimalMark::kComma : DecimalMark::kNone;
}

std::string_view withoutUnit(std::string_view cell, std::string_view unit) {
  if (unit.empty() || cell.size() <= unit.size() || !endsWith(cell, unit)) return cell;
  cell.remove_suffix(unit.size());
  return cell.substr(0, cell.find_last_not_of(' ') + 1);
}

}  // namespace mm
