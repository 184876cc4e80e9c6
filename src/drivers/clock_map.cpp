#include "drivers/clock_map.h"

#include <algorithm>

namespace mm {
namespace {

constexpr double kWindow = 10.0;  // s of states that are compared
constexpr double kSlew = 0.01;    // s a second that the map may change by: clocks differ by far less
constexpr double kSet = 5.0;      // s of difference that only setting a clock makes
constexpr double kLess =
    0.02;  // s by which a difference is so much smaller that those before were of late states

}  // namespace

void ClockMap::reset() { *this = ClockMap(); }

void ClockMap::add(double device, double host) {
  const double difference = host - device;
  if (known_ && (device < last_ || difference - offset_ > kSet || difference - offset_ < -kSet)) reset();
  while (!window_.empty() && window_.back().second >= difference) window_.pop_back();
  window_.emplace_back(device, difference);
  while (window_.front().first < device - kWindow) window_.pop_front();
  const double smallest = window_.front().second;
  if (!known_ || smallest < offset_ - kLess)
    offset_ = smallest;
  else
    offset_ += std::clamp(smallest - offset_, -kSlew * (device - last_), kSlew * (device - last_));
  known_ = true;
  last_ = device;
  late_ = difference - offset_;
}

}  // namespace mm
