#include "model/smoothed_series.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace mm {
namespace {

constexpr std::size_t kFewest = 8;  // readings: of fewer nothing is said of their scatter
constexpr double kUnknown = 1e8;    // variance of level and slope before the first reading, of the noise's

/// Value and slope of the course, and their covariance in units of the noise's variance.
struct Course {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = kUnknown * Eigen::Matrix2d::Identity();
};

/// Readings against time in units of the session's length, so that level and slope are of one size.
struct Readings {
  std::vector<double> time, value;
};

/// The course a while later. @param q its intensity: variance that the slope gains in a unit of time.
Course later(const Course& now, double dt, double q) {
  Eigen::Matrix2d forward = Eigen::Matrix2d::Identity();
  forward(0, 1) = dt;
  Eigen::Matrix2d gained;
  gained << dt * dt * dt / 3.0, dt * dt / 2.0, dt * dt / 2.0, dt;
  return {forward * now.mean, forward * now.covariance * forward.transpose() + q * gained};
}

/// Filters the readings. @param kept a reading: the course before and after it; null: only the likelihood.
/// @return log likelihood, the noise's variance integrated out.
double filter(const Readings& of, double q, std::vector<std::pair<Course, Course>>* kept) {
  Course course;
  double squares = 0.0, logs = 0.0;
  const std::size_t n = of.time.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) course = later(course, of.time[i] - of.time[i - 1], q);
    const Course before = course;
    const double variance = before.covariance(0, 0) + 1.0, miss = of.value[i] - before.mean[0];
    const Eigen::Vector2d gain = before.covariance.col(0) / variance;
    course.mean += gain * miss;
    course.covariance -= gain * before.covariance.row(0);
    if (i >= 2) squares += miss * miss / variance, logs += std::log(variance);  // two make a straight line
    if (kept != nullptr) kept->emplace_back(before, course);
  }
  const double freedoms = static_cast<double>(n) - 2.0;
  return -0.5 * logs - 0.5 * freedoms * std::log(std::max(squares, 1e-300) / freedoms);
}

/// Rauch, Tung and Striebel's smoother: values of the course at the readings.
std::vector<double> smoother(const Readings& of, double q) {
  std::vector<std::pair<Course, Course>> kept;
  filter(of, q, &kept);
  std::vector<double> values(kept.size());
  Course next = kept.back().second;
  values.back() = next.mean[0];
  for (std::size_t i = kept.size() - 1; i-- > 0;) {
    const Course& own = kept[i].second;
    const Course& predicted = kept[i + 1].first;
    Eigen::Matrix2d forward = Eigen::Matrix2d::Identity();
    forward(0, 1) = of.time[i + 1] - of.time[i];
    const Eigen::Matrix2d gain = own.covariance * forward.transpose() * predicted.covariance.inverse();
    Course at;
    at.mean = own.mean + gain * (next.mean - predicted.mean);
    at.covariance = own.covariance + gain * (next.covariance - predicted.covariance) * gain.transpose();
    values[i] = at.mean[0];
    next = at;
  }
  return values;
}

}  // namespace

Series smoothed(Series raw) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < raw.value.size(); ++i)
    if (std::isfinite(raw.value[i])) known.push_back(i);
  if (known.size() < kFewest) return raw;
  const double first = raw.value[known.front()];
  const double start = raw.time[known.front()], length = raw.time[known.back()] - start;
  if (!(length > 0.0)) return raw;
  Readings of;
  for (const std::size_t i : known) {
    of.time.push_back((raw.time[i] - start) / length);
    of.value.push_back(raw.value[i] - first);
  }
  if (std::all_of(of.value.begin(), of.value.end(), [](double v) { return v == 0.0; })) return raw;
  // in the time of `within` the course leaves a straight line by as much as the readings scatter
  const double spacing = 1.0 / static_cast<double>(known.size());
  double likeliest = 0.0, most = 0.0;
  for (double within = 2.0; within > 0.5 * spacing; within /= 2.0) {
    const double q = 1.0 / (within * within * within), likelihood = filter(of, q, nullptr);
    if (likeliest == 0.0 || likelihood > most) most = likelihood, likeliest = q;
  }
  const double rough = 1.0 / (spacing * spacing * spacing);
  if (likeliest >= rough) return raw;  // they follow one another as no noise does
  const std::vector<double> values = smoother(of, likeliest);
  for (std::size_t k = 0; k < known.size(); ++k) raw.value[known[k]] = values[k] + first;
  return raw;
}

}  // namespace mm
