#include "session/time_stamp.h"

#include <algorithm>
#include <cctype>
#include <ctime>
#include <string>

namespace mm {
namespace {

constexpr std::int64_t kNanoseconds = 1000000000;  // of a second

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) { blanks(); }

  bool end() const { return at_ == text_.size(); }
  char peek() const { return end() ? '\0' : text_[at_]; }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  void blanks() {
    while (peek() == ' ') ++at_;
  }
  /// Digits, `fewest` to `most` of them.
  bool number(int fewest, int most, int& value) {
    int count = 0;
    value = 0;
    for (; count < most && std::isdigit(static_cast<unsigned char>(peek())) != 0; ++count)
      value = 10 * value + (text_[at_++] - '0');
    return count >= fewest && std::isdigit(static_cast<unsigned char>(peek())) == 0;
  }
  /// What follows a point or comma, in ns.
  bool fraction(std::int64_t& ns) {
    ns = 0;
    if (peek() != '.' && peek() != ',') return true;
    ++at_;
    std::int64_t digit = kNanoseconds / 10;
    bool any = false;
    for (; std::isdigit(static_cast<unsigned char>(peek())) != 0; digit /= 10, any = true)
      ns += digit * (text_[at_++] - '0');
    return any;
  }
  bool word(const char* upper) {
    std::size_t i = at_;
    for (; *upper != '\0'; ++upper, ++i)
      if (i >= text_.size() || std::toupper(static_cast<unsigned char>(text_[i])) != *upper) return false;
    at_ = i;
    return true;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

bool clock(Scanner& s, std::int64_t& ns) {
  int hour = 0, minute = 0, second = 0;
  std::int64_t part = 0;
  if (!s.number(1, 2, hour) || !s.take(':') || !s.number(2, 2, minute)) return false;
  if (s.take(':') && (!s.number(2, 2, second) || !s.fraction(part))) return false;
  s.blanks();
  const bool pm = s.word("PM"), am = !pm && s.word("AM");
  if ((am || pm) && (hour < 1 || hour > 12)) return false;
  if (am || pm) hour = hour % 12 + (pm ? 12 : 0);
  if (hour > 23 || minute > 59 || second > 60) return false;  // 60: a leap second
  ns = ((hour * 60LL + minute) * 60 + second) * kNanoseconds + part;
  return true;
}

bool zone(Scanner& s, std::int64_t& ns) {
  ns = 0;
  if (s.take('Z') || s.take('z') || s.word("UTC")) return true;
  const int sign = s.peek() == '+' ? 1 : -1;
  if (!s.take('+') && !s.take('-')) return true;
  int hours = 0, minutes = 0;
  if (s.number(4, 4, hours))
    minutes = hours % 100, hours /= 100;
  else if (hours > 23 || (s.take(':') && !s.number(2, 2, minutes)))
    return false;
  ns = sign * (hours * 60LL + minutes) * 60 * kNanoseconds;
  return true;
}

/// A day of the Gregorian calendar, and what follows it: a time, a zone. Nothing when there is no such day.
std::optional<std::int64_t> stampOf(int year, int month, int day, Scanner& s) {
  std::tm date{};
  date.tm_year = year - 1900;
  date.tm_mon = month - 1;
  date.tm_mday = day;
  const std::int64_t midnight = timegm(&date);  // makes of a day that there is none, 31.2., another: 3.3.
  if (year < 1970 || year > 2105 || date.tm_mon != month - 1 || date.tm_mday != day) return std::nullopt;
  std::int64_t ns = 0, off = 0;
  if (!s.end()) {
    if (!s.take('T') && !s.take('t') && !s.take(',') && s.peek() != ' ') return std::nullopt;
    s.blanks();
    if (!s.end() && (!clock(s, ns) || !zone(s, off))) return std::nullopt;
    s.blanks();
  }
  if (!s.end()) return std::nullopt;
  return midnight * kNanoseconds + ns - off;
}

}  // namespace

std::optional<std::int64_t> parseSlashed(std::string_view text, bool monthFirst) {
  Scanner s(text);
  int first = 0, second = 0, year = 0;
  if (!s.number(1, 2, first) || !s.take('/') || !s.number(1, 2, second) || !s.take('/') ||
      !s.number(4, 4, year))
    return std::nullopt;
  return monthFirst ? stampOf(year, first, second, s) : stampOf(year, second, first, s);
}

std::optional<std::int64_t> parseCalendar(std::string_view text) {
  Scanner s(text);
  int first = 0, second = 0, third = 0;
  if (!s.number(1, 4, first)) return std::nullopt;
  const char mark = s.peek();
  const bool yearFirst = first > 31;
  if (!(yearFirst ? mark == '-' || mark == '/' : mark == '.')) return std::nullopt;
  if (!s.take(mark) || !s.number(1, 2, second) || !s.take(mark) || !s.number(1, 4, third))
    return std::nullopt;
  return yearFirst ? stampOf(first, second, third, s) : stampOf(third, second, first, s);
}

std::optional<std::int64_t> parseClock(std::string_view text) {
  Scanner s(text);
  std::int64_t ns = 0;
  if (!clock(s, ns)) return std::nullopt;
  s.blanks();
  if (!s.end()) return std::nullopt;
  return ns;
}

std::optional<std::int64_t> parseTime(TimeForm form, std::string_view text) {
  if (form == TimeForm::kClock) return parseClock(text);
  if (form == TimeForm::kCalendar) return parseCalendar(text);
  return parseSlashed(text, form == TimeForm::kMonthFirst);
}

std::int64_t RowClock::afterMidnight(std::int64_t clock) {
  constexpr std::int64_t kDay = 86400 * kNanoseconds;
  if (any_ && clock + midnights_ * kDay < last_ - kDay / 2) ++midnights_;
  return last_ = clock + midnights_ * kDay;
}

void RowClock::saw(std::int64_t stamp) {
  earliest_ = any_ ? std::min(earliest_, stamp) : stamp;
  any_ = true;
}

}  // namespace mm
