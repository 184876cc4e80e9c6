#include "simulation/wander.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

constexpr int kValues = 8192;          // of the path, a straight line between two of them
constexpr double kLonger = 1.25;       // of the session: a measurement on a real clock takes its time
constexpr double kSettlingPart = 0.7;  // RMS of what settles, of that of the walk

double between(const std::vector<double>& path, double place) {
  if (place <= 0.0) return path.front();
  const auto last = static_cast<double>(path.size() - 1);
  if (place >= last) return path.back();
  const auto i = static_cast<std::size_t>(place);
  return path[i] + (place - static_cast<double>(i)) * (path[i + 1] - path[i]);
}

/// Makes the RMS about the mean 1 at these places of the path, and the mean 0; a path that stays becomes 0.
void normalise(std::vector<double>& path, const std::vector<double>& places) {
  double mean = 0.0, square = 0.0;
  for (const double place : places) mean += between(path, place) / static_cast<double>(places.size());
  for (const double place : places) square += std::pow(between(path, place) - mean, 2);
  const double rms = std::sqrt(square / static_cast<double>(places.size()));
  constexpr double kStays = 1e-12;  // of a walk with steps of order one
  for (double& value : path) value = rms > kStays ? (value - mean) / rms : 0.0;
}

/// A random walk; its pace is drawn anew six times in a session on average.
std::vector<double> walk(double session, Random& random) {
  std::vector<double> path(kValues, 0.0);
  double pace = 1.0, left = 0.0;
  for (int i = 1; i < kValues; ++i) {
    if (left <= 0.0) {
      pace = std::exp(0.7 * random.normal());
      left = -std::log(1.0 - random.uniform()) * session / 6.0;
    }
    left -= 1.0;
    path[i] = path[i - 1] + pace * random.normal();
  }
  return path;
}

/// Parts that begin to settle at any time and do so within a sixtieth to a sixth of the session.
std::vector<double> settling(double session, Random& random) {
  constexpr double kSettlings = 3.0;  // of a session, on average
  std::vector<double> path(kValues, 0.0);
  double start = 0.0;
  for (;;) {
    start -= std::log(1.0 - random.uniform()) * session / kSettlings;
    if (start >= kValues) return path;
    const double amplitude = random.normal(), lag = random.logUniform(session / 60.0, session / 6.0);
    for (int i = static_cast<int>(start) + 1; i < kValues; ++i)
      path[i] += amplitude * (1.0 - std::exp((start - i) / lag));
  }
}

}  // namespace

Wander::Wander(int joint, double rms, const std::vector<double>& times, Random& random) : joint_(joint) {
  const double last = times.empty() ? 3600.0 : *std::max_element(times.begin(), times.end());
  const double session = (kValues - 1) / kLonger;  // in values
  spacing_ = std::max(last, 1.0) / session;
  std::vector<double> places;
  for (const double time : times) places.push_back(time / spacing_);
  if (times.empty())
    for (int i = 0; i < session; ++i) places.push_back(i);
  value_ = walk(session, random);
  normalise(value_, places);
  std::vector<double> settles = settling(session, random);
  normalise(settles, places);
  for (int i = 0; i < kValues; ++i) value_[i] += kSettlingPart * settles[i];
  normalise(value_, places);
  for (double& value : value_) value *= rms;
}

double Wander::at(double time) const { return between(value_, time / spacing_); }

void Wander::operator()(const Condition& condition, Distortion& distortion) const {
  distortion.travel[joint_] += at(condition.time);
}

}  // namespace mm
