#pragma once
#include <limits>
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

constexpr double kSameReading = 1e-9;  // K: readings that are no further apart are the same

/// How a temperature sensor did in one session.
struct SensorHealth {
  std::string sensor;
  int values = 0;       // that were logged
  int setAside = 0;     // values that cannot be right (error codes)
  double mean = 0.0;    // degC
  double noise = 0.0;   // K: standard deviation of a reading, from second differences, robust
  double span = 0.0;    // K: largest less smallest; 0: it did not move
  double offset = 0.0;  // K: mean less the median of the other sensors' means; NaN: it is the only one
  // K: smallest difference of two values that differ, which is its resolution or more; NaN: none differ
  double step = std::numeric_limits<double>::quiet_NaN();

  /// See eachField; in the order of the JSON and of the table.
  template <class Self, class F>
  static void fields(Self& self, const F& f) {
    f("sensor", self.sensor);
    f("values", self.values);
    f("set_aside", self.setAside);
    f("mean_degC", self.mean);
    f("noise_K", self.noise);
    f("span_K", self.span);
    f("offset_K", self.offset);
    f("step_K", self.step);
  }
};

/// A line a temperature series of the session, in its order.
std::vector<SensorHealth> sensorHealth(const Session& session);

}  // namespace mm
