#include "experiment.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "base/random.h"
#include "thermal/sensor_selection.h"

namespace mm {
namespace {

constexpr std::size_t kInputs = 4;
constexpr double kFeed = 1000.0 / 60.0;          // mm/s
constexpr double kPause = 5.0;                   // s between two positions
constexpr double kNoiseT = 0.05, kNoiseY = 0.2;  // K, um

void append(std::string& text, const char* pattern, double value) {
  char number[40];
  std::snprintf(number, sizeof number, pattern, value);
  text += number;
}

}  // namespace

Experiment::Experiment(std::uint64_t seed, ThermalLaw law, int warmUps)

    : seed(seed), mill(seed, law), testMinutes{0, 60, 120} {
  const double loads[] = {1.0, 0.5, 1.3}, starts[] = {20.5, 20.2, 20.8};
  constexpr int kSets = 11;
  std::vector<double> oneDay;
  for (int k = 0; k < kSets; ++k) oneDay.push_back(20.0 * k);
  training.temperatures.resize(warmUps * kSets, HeatedMill::kSensors);
  training.deviation.resize(warmUps * kSets, HeatedMill::kPositions);
  truth = training.deviation;
  for (int day = 0; day < warmUps; ++day) {
    const MillRun run = mill.run(oneDay, starts[day % 3], loads[day % 3], kNoiseT, kNoiseY,
                                 10 * seed + static_cast<std::uint64_t>(day));
    for (const double m : oneDay) minutes.push_back(24.0 * 60.0 * day + m);
    training.temperatures.middleRows(day * kSets, kSets) = run.temperatures;
    truth.middleRows(day * kSets, kSets) = mill.run(oneDay, starts[day % 3], loads[day % 3], kNoiseT, 0.0,
                                                    10 * seed + static_cast<std::uint64_t>(day))
                                               .deviation;
    training.deviation.middleRows(day * kSets, kSets) = run.deviation;
  }
  test = mill.run(testMinutes, 21.0, 0.6 + 0.3 * static_cast<double>(seed % 3), kNoiseT, 0.0, 1000 + seed);
  const Eigen::VectorXd grade = greyRelationalGrade(training.temperatures, training.deviation);
  inputs.resize(HeatedMill::kSensors);
  std::iota(inputs.begin(), inputs.end(), 0);
  std::stable_sort(inputs.begin(), inputs.end(), [&](int a, int b) { return grade[a] > grade[b]; });
  inputs.resize(kInputs);
  std::sort(inputs.begin(), inputs.end());
}

Eigen::MatrixXd Experiment::chosen(const Eigen::MatrixXd& temperatures) const {
  Eigen::MatrixXd columns(temperatures.rows(), static_cast<Eigen::Index>(inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i)
    columns.col(static_cast<Eigen::Index>(i)) = temperatures.col(inputs[i]);
  return columns;
}

std::vector<std::string> sensorNames() {
  std::vector<std::string> names;
  for (const char* drive : {"x", "y", "z"})
    for (const char* part : {"motor", "bearing", "screw_1", "screw_2", "screw_3", "nut", "far_bearing"})
      names.push_back(std::string(drive) + "_" + part);
  names.emplace_back("spindle_motor");
  for (int i = 1; i <= 5; ++i) names.push_back("headstock_" + std::to_string(i));
  for (int i = 1; i <= 4; ++i) names.push_back("column_" + std::to_string(i));
  names.emplace_back("air");
  return names;
}

Eigen::MatrixXd leftBy(const std::string& method, const Experiment& e) {
  if (method == "none") return e.test.deviation;
  NetworkSettings settings;
  settings.dfnn.published = method == "dfnn_published";
  if (settings.dfnn.published) settings.dfnn.largestRules = 9;
  const auto network = makeNetwork(networkKind(settings.dfnn.published ? "dfnn" : method), settings);
  network->fit(e.chosen(e.training.temperatures), e.training.deviation);
  return e.test.deviation - network->evaluateAll(e.chosen(e.test.temperatures));
}

std::string importCsv(const Experiment& e, bool training) {
  const std::vector<double>& minutes = training ? e.minutes : e.testMinutes;
  const Eigen::MatrixXd& temperatures = training ? e.training.temperatures : e.test.temperatures;
  const Eigen::MatrixXd& deviation = training ? e.truth : e.test.deviation;
  Random random(e.seed, training ? "interferometer" : "interferometer on the other day");
  std::string text = "time_s,x_mm,x_velocity_mm_s,deviation_x_um";
  for (const std::string& name : sensorNames()) text += "," + name + "_degC";
  text += "\n";
  const int last = HeatedMill::kPositions - 1;
  for (std::size_t k = 0; k < minutes.size(); ++k)
    for (int step = 0; step <= 2 * last + 1; ++step) {
      const int position = step <= last ? step : 2 * last + 1 - step;
      const auto row = static_cast<Eigen::Index>(k);
      append(text, "%.10g", 60.0 * minutes[k] + kPause * step);
      append(text, ",%.10g", 1e3 * e.mill.travel() * position / last);
      append(text, ",%.6g", step <= last ? kFeed : -kFeed);
      append(text, ",%.6f", deviation(row, position) + kNoiseY * random.normal());
      for (Eigen::Index s = 0; s < temperatures.cols(); ++s) append(text, ",%.4f", temperatures(row, s));
      text += "\n";
    }
  return text;
}

}  // namespace mm
