#pragma once
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

/// How a temperature sensor did in one session.
struct SensorHealth {
  std::string sensor;
  int values = 0;       // that were logged
  int setAside = 0;     // values that cannot be right (error codes)
  double mean = 0.0;    // degC
  double noise = 0.0;   // K: standard deviation of a reading, from second differences, robust
  double span = 0.0;    // K: largest less smallest; 0 in a long series: the sensor is stuck
  double offset = 0.0;  // K: mean less the median of the other sensors' means; NaN: it is the only one
};

/// A line a temperature series of the session, in its order.
std::vector<SensorHealth> sensorHealth(const Session& session);

}  // namespace mm
