#pragma once
#include <cstddef>
#include <deque>
#include <utility>

namespace mm {

/// Maps a controller's clock to the host's. A state never arrives before it was made, so the smallest
/// difference of the last while is nearest to the truth (as in Cristian's algorithm with one way); the map
/// follows it slowly enough that mapped times ascend, but for a beginning with states that came late.
class ClockMap {
 public:
  /// @param device s on the controller's clock, of a state. @param host s when it arrived.
  void add(double device, double host);
  /// s on the host's clock.
  double toHost(double device) const { return device + offset_; }
  /// s by which the last state arrived later than the fastest: how well `toHost` can be trusted, and how late
  /// states are.
  double late() const { return late_; }
  /// Either clock was set, or this process paused.
  void reset();

 private:
  std::deque<std::pair<double, double>> window_;  // device time, host - device; the latter ascending
  double offset_ = 0.0, late_ = 0.0, last_ = 0.0;
  bool known_ = false;
};

}  // namespace mm
