#include "model/observed_domain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace mm {
namespace {

constexpr double kSamePosition = 1e-6;  // m or rad
constexpr std::size_t kMostPositions = 64;

/// Means of the groups of values no further than kSamePosition from the lowest of their group.
std::vector<double> distinctPositions(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  std::vector<double> distinct;
  for (std::size_t first = 0; first < values.size();) {
    std::size_t last = first;
    double sum = 0.0;
    while (last < values.size() && values[last] - values[first] <= kSamePosition) sum += values[last++];
    distinct.push_back(sum / static_cast<double>(last - first));
    if (distinct.size() > kMostPositions) return {};
    first = last;
  }
  return distinct;
}

/// Where an axis stood, of values that differ by less than a bound: the first and last value of each place.
std::vector<std::pair<double, double>> placesOf(const std::vector<double>& values, double apart) {
  std::vector<std::pair<double, double>> places;
  for (const double value : values) {
    if (places.empty() || value - places.back().second > apart)
      places.emplace_back(value, value);
    else
      places.back().second = value;
  }
  return places;
}

/// The distance of the grid on which places lie, a part of their least distance; 0: they lie on none.
/// @param part one in so many.
double gridOf(const std::vector<std::pair<double, double>>& places, int part) {
  constexpr double kOffGrid = 0.005;  // of the distance: a wave of a third of it is met within 0.1 rad
  std::vector<double> place, number;  // number: of the grid
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [first, last] : places) {
    place.push_back(0.5 * (first + last));
    if (place.size() > 1) nearest = std::min(nearest, place.back() - place[place.size() - 2]);
  }
  number.push_back(0.0);
  for (std::size_t i = 1; i < place.size(); ++i)
    number.push_back(number.back() + std::round((place[i] - place[i - 1]) / nearest * part));
  const double n = static_cast<double>(place.size());
  const double meanPlace = std::accumulate(place.begin(), place.end(), 0.0) / n,
               meanNumber = std::accumulate(number.begin(), number.end(), 0.0) / n;
  double products = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    products += (number[i] - meanNumber) * (place[i] - meanPlace);
    squares += (number[i] - meanNumber) * (number[i] - meanNumber);
  }
  const double spacing = products / squares;
  for (std::size_t i = 0; i < place.size(); ++i) {
    const double expected = meanPlace + spacing * (number[i] - meanNumber);
    for (const double value : {places[i].first, places[i].second})
      if (std::abs(value - expected) > kOffGrid * spacing) return 0.0;
  }
  return spacing;
}

/// The distance of the grid that all values lie on, as the targets of ISO 230-2 do at equal distances, some
/// of them left out or not, and whole degrees; 0: they lie on none.
double gridSpacing(std::vector<double> values) {
  constexpr std::size_t kFewest = 5;                  // places: four gaps that agree by chance are rare
  constexpr double kOnePlace[] = {0.1, 0.01, 0.001};  // of the widest gap
  constexpr int kMostParts = 10;  // gaps that agree with a tenth of the least by chance: 1 in 100 each
  std::sort(values.begin(), values.end());
  double widest = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) widest = std::max(widest, values[i] - values[i - 1]);
  if (widest <= kSamePosition) return 0.0;
  for (const double apart : kOnePlace) {
    const auto places = placesOf(values, apart * widest);
    for (int part = 1; part <= kMostParts && places.size() >= kFewest; ++part)
      if (const double spacing = gridOf(places, part); spacing > 0.0) return spacing;
  }
  return 0.0;
}

/// Names and ranges at the observations of what was logged against time.
void addRanges(const std::vector<Series>& logged, const std::vector<Observation>& observations,
               std::vector<std::string>& names, std::vector<double>& lower, std::vector<double>& upper) {
  for (const Series& series : logged) {
    double low = kNotMeasured, high = kNotMeasured;
    for (const Observation& o : observations) {
      const double value = series.at(o.time);
      low = std::fmin(low, value);  // fmin and fmax pass over NaN
      high = std::fmax(high, value);
    }
    names.push_back(series.name);
    lower.push_back(low);
    upper.push_back(high);
  }
}

/// Midway between one observation and the next.
std::vector<double> gapsOf(const Session& session) {
  constexpr std::size_t kMost = 400;
  std::vector<double> times;
  for (const Observation& o : session.observations)
    if (session.timed(o)) times.push_back(session.ownTime(o));
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  const std::size_t step = times.size() / kMost + 1;
  std::vector<double> gaps;
  for (std::size_t i = step; i < times.size(); i += step) gaps.push_back(0.5 * (times[i - 1] + times[i]));
  return gaps;
}

}  // namespace

Domain observedDomain(const Session& session) {
  Domain domain;
  domain.setMachine(session.machine);
  for (int j = 0; j < session.machine.jointCount(); ++j) {
    std::vector<double> values;
    values.reserve(session.observations.size());
    for (const Observation& o : session.observations) values.push_back(o.position[j]);
    const auto range = std::minmax_element(values.begin(), values.end());
    domain.lower.push_back(values.empty() ? 0.0 : *range.first);
    domain.upper.push_back(values.empty() ? 0.0 : *range.second);
    domain.spacing.push_back(gridSpacing(values));
    domain.positions.push_back(distinctPositions(std::move(values)));
    double slowest = kNotMeasured, fastest = kNotMeasured;
    for (const Observation& o : session.observations) {
      const double v = static_cast<std::size_t>(j) < o.velocity.size() ? o.velocity[j] : kNotMeasured;
      slowest = std::fmin(slowest, v);  // fmin and fmax pass over NaN
      fastest = std::fmax(fastest, v);
    }
    domain.velocityLower.push_back(slowest);
    domain.velocityUpper.push_back(fastest);
  }
  addRanges(session.temperatures, session.observations, domain.sensors, domain.sensorLower,
            domain.sensorUpper);
  addRanges(session.covariates, session.observations, domain.covariates, domain.covariateLower,
            domain.covariateUpper);
  for (const Feature& feature : session.artifact.features) {
    domain.features.push_back(feature.name);
    domain.featureRadius.push_back(feature.kind == FeatureKind::kBall ? feature.radius : 0.0);
  }

  for (const Stylus& stylus : session.artifact.styli) domain.styli.push_back(stylus.name);
  domain.recordings = session.recordingCount();

  bool first = true;
  for (const Observation& o : session.observations) {
    if (session.timed(o)) domain.duration = std::max(domain.duration, session.ownTime(o));
    domain.readingLower = std::fmin(domain.readingLower, o.laserReading);
    domain.readingUpper = std::fmax(domain.readingUpper, o.laserReading);
    for (const double v : o.velocity)
      if (std::isfinite(v)) domain.maxSpeed = std::max(domain.maxSpeed, std::abs(v));
    const Eigen::Vector3d tip = session.machine.nominal(o.position.data(), kNotMeasured).position;
    domain.tipLower = first ? tip : domain.tipLower.cwiseMin(tip);
    domain.tipUpper = first ? tip : domain.tipUpper.cwiseMax(tip);
    first = false;
  }
  domain.gaps = gapsOf(session);
  domain.laser = session.hasLaser();
  domain.artifactExpansion = session.artifact.expansion;
  return domain;
}

}  // namespace mm
