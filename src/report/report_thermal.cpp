#include "report/report_thermal.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

constexpr std::size_t kFewestTimes = 5, kMostSensors = 12, kMostSamples = 400;
constexpr double kShortest = 600.0;      // s
constexpr double kSmallestChange = 0.5;  // K
constexpr double kHour = 3600.0;

double rangeOf(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

/// Deviations of one axis by target position.
std::vector<ThermalCourse> coursesOf(const CalibrationResult& fitted, std::size_t joint, bool rotary) {
  const double unit = rotary ? kArcsecond : kMicrometre, place = rotary ? kDegree : kMillimetre;
  const Problem& problem = *fitted.problem;
  struct Point {
    double at, hours, measured, left;
  };
  std::vector<Point> points;
  for (int row = 0; row < problem.rowCount(); ++row) {
    const ResidualRow& r = problem.rows()[static_cast<std::size_t>(row)];
    const Observation& o = problem.session().observations[static_cast<std::size_t>(r.observation)];
    if (o.kind != ObservationKind::kDeviation || r.component != static_cast<int>(joint)) continue;
    if (!(fitted.weight[row] > 0.0)) continue;
    points.push_back(
        {o.position[joint] / place, o.time / kHour, o.deviation[joint] / unit, fitted.residuals[row] / unit});
  }
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.at < b.at; });
  std::vector<ThermalCourse> courses;
  const double tolerance = points.empty() ? 0.0 : kSameTarget * (points.back().at - points.front().at);
  for (std::size_t first = 0; first < points.size();) {
    std::size_t end = first;
    while (end < points.size() && points[end].at - points[first].at <= tolerance) ++end;
    std::stable_sort(points.begin() + static_cast<std::ptrdiff_t>(first),
                     points.begin() + static_cast<std::ptrdiff_t>(end),
                     [](const Point& a, const Point& b) { return a.hours < b.hours; });
    ThermalCourse course;
    course.at = points[first].at;
    for (std::size_t i = first; i < end; ++i) {
      course.hours.push_back(points[i].hours);
      course.measured.push_back(points[i].measured);
      course.left.push_back(points[i].left);
    }
    course.measuredRange = rangeOf(course.measured);
    course.leftRange = rangeOf(course.left);
    if (course.hours.size() >= kFewestTimes &&
        course.hours.back() - course.hours.front() >= kShortest / kHour)
      courses.push_back(std::move(course));
    first = end;
  }
  return courses;
}

/// Every sensor whose temperature changed, those of the networks first.
std::vector<TemperatureCourse> temperatureCourses(const Session& session, const Model& model) {
  std::vector<std::string> first;
  for (const LearnedNetwork& network : model.networks())
    first.insert(first.end(), network.sensors.begin(), network.sensors.end());
  std::vector<TemperatureCourse> all;
  for (const Series& series : session.temperatures) {
    TemperatureCourse course;
    course.sensor = series.name;
    for (std::size_t i = 0; i < series.time.size(); ++i) {
      if (!std::isfinite(series.value[i])) continue;
      course.hours.push_back(series.time[i] / kHour);
      course.temperature.push_back(series.value[i]);
    }
    if (course.hours.empty() || rangeOf(course.temperature) < kSmallestChange) continue;
    const std::size_t step = (course.hours.size() + kMostSamples - 1) / kMostSamples;
    for (std::size_t i = 0; step > 1 && i * step < course.hours.size(); ++i) {
      course.hours[i] = course.hours[i * step];
      course.temperature[i] = course.temperature[i * step];
    }
    const std::size_t kept = (course.hours.size() + step - 1) / step;
    course.hours.resize(kept);
    course.temperature.resize(kept);
    all.push_back(std::move(course));
  }
  std::stable_sort(all.begin(), all.end(), [&](const TemperatureCourse& a, const TemperatureCourse& b) {
    const auto in = [&](const TemperatureCourse& c) {
      return std::find(first.begin(), first.end(), c.sensor) != first.end();
    };
    return in(a) && !in(b);
  });
  if (all.size() > kMostSensors) all.resize(kMostSensors);
  return all;
}

}  // namespace

ThermalTest thermalTest(const CalibrationResult& fitted) {
  ThermalTest test;
  const Problem& problem = *fitted.problem;
  test.temperatures = temperatureCourses(problem.session(), problem.model());
  if (test.temperatures.empty()) return test;
  const std::vector<Joint>& joints = problem.model().machine().joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    AxisThermal axis;
    axis.axis = joints[j].name;
    axis.rotary = joints[j].kind == JointKind::kRotary;
    std::vector<ThermalCourse> courses = coursesOf(fitted, j, axis.rotary);
    if (courses.empty()) continue;
    for (const ThermalCourse& course : courses) {
      axis.measuredRange = std::max(axis.measuredRange, course.measuredRange);
      axis.leftRange = std::max(axis.leftRange, course.leftRange);
    }
    std::vector<std::size_t> shown = {0, courses.size() / 2, courses.size() - 1};
    shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
    for (const std::size_t s : shown) axis.courses.push_back(courses[s]);
    test.axes.push_back(std::move(axis));
  }
  return test;
}

}  // namespace mm
