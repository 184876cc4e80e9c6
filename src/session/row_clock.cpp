#include "session/row_clock.h"

#include <algorithm>

#include "session/session_time.h"
#include "session/time_stamp.h"

namespace mm {

std::optional<std::int64_t> RowClock::read(TimeForm form, std::string_view cell) {
  switch (form) {
    case TimeForm::kClock:
      return parseClock(cell);
    case TimeForm::kMonthFirst:
    case TimeForm::kDayFirst:
      return parseSlashed(cell, form == TimeForm::kMonthFirst);
    default:
      return parseCalendar(cell);
  }
}

std::int64_t RowClock::afterMidnight(std::int64_t clock) {
  constexpr std::int64_t kDay = 86400000000000;  // ns
  if (any_ && clock + midnights_ * kDay < last_ - kDay / 2) ++midnights_;
  return last_ = clock + midnights_ * kDay;
}

void RowClock::saw(std::int64_t stamp) {
  earliest_ = any_ ? std::min(earliest_, stamp) : stamp;
  any_ = true;
}

void LoggedSeries::fill(std::vector<Series>& series, std::int64_t zero) {
  const auto earlier = [](const Logged& a, const Logged& b) { return a.stamp < b.stamp; };
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (!std::is_sorted(logged_[i].begin(), logged_[i].end(), earlier))
      std::stable_sort(logged_[i].begin(), logged_[i].end(), earlier);
    for (const Logged& l : logged_[i]) {
      series[i].time.push_back(secondsBetween(zero, l.stamp));
      series[i].value.push_back(l.value);
    }
    std::vector<Logged>().swap(logged_[i]);
  }
}

}  // namespace mm
