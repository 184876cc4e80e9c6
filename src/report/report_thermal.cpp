#include <algorithm>
#include <cmath>

#include "base/range.h"
#include "base/units.h"
#include "report/iso_tests.h"
#include "report/text_parts.h"

namespace mm {
namespace {

constexpr std::size_t kMostSensors = 12, kMostSamples = 400;
constexpr double kHour = 3600.0;  // s

TemperatureCourse temperatureCourse(const Series& series) {
  TemperatureCourse course;
  course.sensor = series.name;
  Range range;
  const std::size_t step = (series.time.size() + kMostSamples - 1) / kMostSamples;
  for (std::size_t i = 0; i < series.time.size(); ++i) {
    range.add(series.value[i]);
    if (i % step != 0 || !std::isfinite(series.value[i])) continue;
    course.hours.push_back(series.time[i] / kHour);
    course.temperature.push_back(series.value[i]);
  }
  course.range = range.any() ? range.size() : 0.0;
  return course;
}

std::vector<TemperatureCourse> temperatureCourses(const Session& session, const Model& model) {
  std::vector<std::string> first;
  for (const LearnedNetwork& network : model.networks())
    first.insert(first.end(), network.sensors.begin(), network.sensors.end());
  std::vector<TemperatureCourse> all;
  for (const Series& series : session.temperatures) {
    all.push_back(temperatureCourse(series));
    if (all.back().hours.empty()) all.pop_back();
  }
  std::stable_partition(all.begin(), all.end(), [&](const TemperatureCourse& c) {
    return std::find(first.begin(), first.end(), c.sensor) != first.end();
  });
  if (all.size() > kMostSensors) all.resize(kMostSensors);
  return all;
}

}  // namespace

ThermalReport thermalReport(const CalibrationResult& fitted) {
  const Problem& problem = *fitted.problem;
  ThermalReport report;
  const bool angular = angularOnly(fitted), known = fitted.repeatabilityFrom != "estimated";
  for (ThermalTest& test : thermalTests(problem.session(), residualsOf(fitted))) {
    const double unit = test.angular ? kArcsecond : kMicrometre;
    const double noise = known && test.angular == angular ? fitted.repeatability / unit : kNotMeasured;
    ThermalTestFigures figures;
    for (const ThermalCourse& course : test.courses) {
      const double one = course.between ? std::sqrt(2.0) * noise : noise;
      figures.measured.push_back(driftFigures(course.measured, test.heated, one));
      figures.left.push_back(driftFigures({course.measured.hours, course.left}, test.heated, one));
    }
    figures.test = std::move(test);
    report.tests.push_back(std::move(figures));
  }
  if (!report.tests.empty()) report.temperatures = temperatureCourses(problem.session(), problem.model());
  return report;
}

}  // namespace mm
