#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace mm {

/// How a cell of a column of times is written.
enum class TimeForm {
  kNumber,      // a number of some unit
  kCalendar,    // a date and a time of day (ISO 8601, 21.11.2026 10:15:03,5)
  kMonthFirst,  // 11/21/2026 10:15:03
  kDayFirst,    // 21/11/2026 10:15:03
  kClock        // a time of day alone; after midnight it begins again
};

/// Seconds from `start` to `stamp`, both whole nanoseconds. All readers use it, so that equal stamps give
/// equal bits.
inline double secondsBetween(std::int64_t start, std::int64_t stamp) {
  return static_cast<double>(stamp - start) / 1e9;
}

/// A calendar time as people and loggers write it, in ns since 1970-01-01 UTC: ISO 8601
/// (2026-11-21T10:15:03.25, a blank for the T, Z or +01:00 at the end, without a zone taken as UTC),
/// 2026/11/21 10:15, or day first with points (21.11.2026 10:15:03,5). A day without a time is its midnight.
/// Nothing for what may be read in two ways (11/12/2026) or is no such time.
std::optional<std::int64_t> parseCalendar(std::string_view text);

/// A calendar time with slashes, month first (11/21/2026 2:05 PM) or day first (21/11/2026 14:05): which of
/// the two must be known.
std::optional<std::int64_t> parseSlashed(std::string_view text, bool monthFirst);

/// A time of day, `10:15`, `10:15:03.5`, `2:05:01 PM`: ns since midnight.
std::optional<std::int64_t> parseClock(std::string_view text);

/// A time stamp in one of the forms but a number, in ns (since 1970, or since midnight of a time of day).
std::optional<std::int64_t> parseTime(TimeForm form, std::string_view text);

/// The clock of a file's rows, in whole nanoseconds of its own.
class RowClock {
 public:
  /// A time of day after those before: one that jumps back by more than half a day has passed midnight.
  std::int64_t afterMidnight(std::int64_t clock);
  void saw(std::int64_t stamp);                        ///< of a row
  std::int64_t earliest() const { return earliest_; }  ///< of those that were seen; 0 before

 private:
  bool any_ = false;
  std::int64_t earliest_ = 0, last_ = 0, midnights_ = 0;
};

}  // namespace mm
