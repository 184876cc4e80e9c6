#include "fleet/sensor_health.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/median.h"
#include "base/range.h"
#include "fleet/robust_numbers.h"

namespace mm {
namespace {

/// Standard deviation of a reading: second differences take out what changes slowly; of white noise their
/// variance is six times that of a reading. Of about as many values in every session, whatever the logger's
/// period: what was interpolated between two readings of the sensor has no noise of its own.
double noiseOf(const std::vector<double>& value) {
  constexpr std::size_t kValues = 20;
  const std::size_t stride = std::max<std::size_t>(1, value.size() / kValues);
  std::vector<double> bends;
  for (std::size_t i = 2 * stride; i < value.size(); i += stride)
    bends.push_back(value[i] - 2.0 * value[i - stride] + value[i - 2 * stride]);
  if (bends.empty()) return kNotMeasured;
  return robustSpread(bends) / std::sqrt(6.0);
}

/// Values of one decimal text differ in the last bits after arithmetic: not a step of the sensor.
double stepOf(std::vector<double> value) {
  std::sort(value.begin(), value.end());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < value.size(); ++i) {
    const double apart = value[i] - value[i - 1];
    if (apart > kSameReading) least = std::min(least, apart);
  }
  return std::isfinite(least) ? least : kNotMeasured;
}

}  // namespace

std::vector<SensorHealth> sensorHealth(const Session& session) {
  std::vector<SensorHealth> all;
  for (const Series& series : session.temperatures) {
    SensorHealth h;
    h.sensor = series.name;
    h.values = series.value.size();
    for (const SetAside& aside : session.setAside)
      if (aside.logged && aside.logged->temperature && aside.logged->series == series.name) ++h.setAside;
    double sum = 0.0;
    Range range;
    for (const double v : series.value) sum += v, range.add(v);
    h.mean = h.values > 0 ? sum / h.values : kNotMeasured;
    h.noise = noiseOf(series.value);
    if (h.values > 0) h.span = range.size();
    h.step = stepOf(series.value);
    all.push_back(h);
  }
  for (SensorHealth& h : all) {
    std::vector<double> others;
    for (const SensorHealth& o : all)
      if (&o != &h && std::isfinite(o.mean)) others.push_back(o.mean);
    h.offset = others.empty() ? kNotMeasured : h.mean - median(others);
  }
  return all;
}

}  // namespace mm
