#pragma once
#include "session/session.h"

namespace mm::test_support {

/// A deviation of x that an instrument read with the other axes at zero. @param x, deviation m. @param
/// velocity of x, m/s; NaN: not known.
inline Observation deviationOfX(double x, double velocity, double time, double deviation) {
  Observation o;
  o.kind = ObservationKind::kDeviation;
  o.time = time;
  o.position = {x, 0.0, 0.0};
  o.velocity = {velocity, 0.0, 0.0};
  o.deviation = {deviation, kNotMeasured, kNotMeasured};
  o.deviationStd.assign(3, kNotMeasured);
  return o;
}

}  // namespace mm::test_support
