#include "model/series_history.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

constexpr std::size_t kKept = 16;  // responses: a few sensors, a few time constants of a difference quotient

struct Lag {
  double behind = 0.0;  // response minus temperature
  double byTau = 0.0;
};

/// Lag after `elapsed` seconds of a temperature that rises by `slope` a second.
Lag advance(const Lag& from, double slope, double tau, double elapsed) {
  const double decay = std::exp(-elapsed / tau);
  const double lost = std::expm1(-elapsed / tau);
  Lag to;
  to.behind = from.behind * decay + slope * tau * lost;
  to.byTau = from.byTau * decay + slope * lost + (from.behind + slope * tau) * decay * elapsed / (tau * tau);
  return to;
}

double slopeAt(const Series& series, std::size_t knot) {
  if (knot + 1 >= series.time.size()) return 0.0;
  const double span = series.time[knot + 1] - series.time[knot];
  return span > 0.0 ? (series.value[knot + 1] - series.value[knot]) / span : 0.0;
}

}  // namespace

SeriesHistory::SeriesHistory(std::vector<Series> sensors) : sensors_(std::move(sensors)) {}

std::shared_ptr<const SeriesHistory::Response> SeriesHistory::response(int sensor, double tau) const {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& kept : recent_)
      if (kept->sensor == sensor && kept->tau == tau) return kept;
  }
  const Series& series = sensors_[sensor];
  auto made = std::make_shared<Response>();
  made->sensor = sensor;
  made->tau = tau;
  made->behind.reserve(series.time.size());
  made->byTau.reserve(series.time.size());
  Lag lag;
  for (std::size_t i = 0; i < series.time.size(); ++i) {
    if (i > 0) {
      const double span = series.time[i] - series.time[i - 1];
      // Two values at one stamp are a step: the response has not moved yet, the temperature has.
      if (span > 0.0)
        lag = advance(lag, slopeAt(series, i - 1), tau, span);
      else
        lag.behind -= series.value[i] - series.value[i - 1];
    }
    made->behind.push_back(lag.behind);
    made->byTau.push_back(lag.byTau);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  recent_.insert(recent_.begin(), made);
  if (recent_.size() > kKept) recent_.pop_back();
  return made;
}

double SeriesHistory::lagged(int sensor, double tau, double time, double* byTau) const {
  if (byTau != nullptr) *byTau = 0.0;
  if (sensor < 0 || sensor >= static_cast<int>(sensors_.size()) || sensors_[sensor].time.empty())
    return kNotMeasured;
  const Series& series = sensors_[sensor];
  const auto after = std::upper_bound(series.time.begin(), series.time.end(), time);
  if (after == series.time.begin()) return series.value.front();
  const std::size_t knot = static_cast<std::size_t>(after - series.time.begin()) - 1;
  const double elapsed = time - series.time[knot];
  const double slope = slopeAt(series, knot);
  const double temperature = series.value[knot] + slope * elapsed;
  if (!(tau > 0.0)) {
    if (byTau != nullptr) *byTau = -slope;
    return temperature;
  }
  const std::shared_ptr<const Response> at = response(sensor, tau);
  const Lag lag = advance({at->behind[knot], at->byTau[knot]}, slope, tau, elapsed);
  if (byTau != nullptr) *byTau = lag.byTau;
  return temperature + lag.behind;
}

}  // namespace mm
