#pragma once
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "session/csv_columns.h"
#include "session/session.h"

namespace mm {

/// The clock of a file's rows, in whole nanoseconds of its own.
class RowClock {
 public:
  /// A time stamp in that form, in ns (since 1970, or since midnight of a time of day). Nothing: it is none.
  static std::optional<std::int64_t> read(TimeForm form, std::string_view cell);
  /// A time of day after those before: one that jumps back by more than half a day has passed midnight.
  std::int64_t afterMidnight(std::int64_t clock);
  void saw(std::int64_t stamp);
  std::int64_t earliest() const { return earliest_; }  ///< of those that were seen; 0 before

 private:
  bool any_ = false;
  std::int64_t earliest_ = 0, last_ = 0, midnights_ = 0;
};

/// What was logged beside the rows, until the earliest time of the file is known.
class LoggedSeries {
 public:
  void resize(std::size_t count) { logged_.resize(count); }  ///< of series
  void add(int series, std::int64_t stamp, double value) {
    logged_[series].push_back({stamp, value});
  }  ///< stamp in ns
  /// Puts the values into their series in the order of their times, s after `zero`, and forgets them.
  void fill(std::vector<Series>& series, std::int64_t zero);

 private:
  struct Logged {
    std::int64_t stamp;  // ns, the file's own clock
    double value;
  };
  std::vector<std::vector<Logged>> logged_;
};

}  // namespace mm
