#include "export/offset_grid.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/grid_values.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kNoRange = 1e-3;  // K: a temperature that hardly changed

constexpr int kGridPoints = 9;        // along each axis
constexpr double kGridLeast = 1e-8;   // m, of a temperature over its range
constexpr int kTemperatureless = 12;  // states of everything else, over which the grid is the mean
constexpr unsigned kGridSeed = 61;

std::vector<double> millimetres(const std::vector<double>& metres) {
  std::vector<double> out;
  for (const double m : metres) out.push_back(std::round(m / kMillimetre * 1e8) / 1e8);
  return out;
}

}  // namespace

OffsetGrid::OffsetGrid(const NeededCorrection& needed, CorrectionPart part) : joints_(needed.linear()) {
  const Domain& d = needed.model().domain();
  std::vector<std::size_t> strides(joints_.size(), 1);
  std::size_t count = 1;
  for (const int joint : joints_) {
    letters_.push_back(needed.axis(joint).letter);
    const auto [lower, upper] = needed.tabulated(joint);
    at_.push_back(evenSteps(lower, upper, kGridPoints - 1));
    count *= kGridPoints;
  }
  std::vector<std::vector<double>> own(joints_.size());  // what the joint tables are fitted to
  for (std::size_t a = 0; a < joints_.size(); ++a)
    for (const double position : at_[a])
      own[a].push_back(meanCorrection(needed, joints_[a], position, part)[joints_[a]]);
  for (std::size_t a = joints_.size(); a-- > 1;) strides[a - 1] = strides[a] * kGridPoints;
  std::vector<double> middle;
  for (std::size_t k = 0; k < d.sensors.size(); ++k)
    middle.push_back(0.5 * (d.sensorLower[k] + d.sensorUpper[k]));

  std::vector<State> others = needed.states(kTemperatureless, kGridSeed);
  const auto mean = [&](std::size_t point, int sensor, double kelvin) {
    return meanOver(needed, part, others, [&](State& state) {
      for (std::size_t a = 0; a < joints_.size(); ++a)
        state.position[joints_[a]] = at_[a][point / strides[a] % kGridPoints];
      state.temperature = middle;
      if (sensor >= 0) state.temperature[sensor] += kelvin;
    });
  };
  base_.assign(joints_.size(), std::vector<double>(count));
  for (std::size_t point = 0; point < count; ++point) {
    const Eigen::VectorXd value = mean(point, -1, 0.0);
    for (std::size_t a = 0; a < joints_.size(); ++a)
      base_[a][point] = value[joints_[a]] - own[a][point / strides[a] % kGridPoints];
  }
  State reference = others[0];
  for (const int joint : joints_) reference.position[joint] = needed.reference(joint);
  for (std::vector<double>& values : base_) {
    const double zero = interpolated(values, reference);
    for (double& v : values) {
      v -= zero;
      largest_ = std::max(largest_, std::abs(v));
    }
  }
  for (std::size_t k = 0; k < d.sensors.size(); ++k) {
    const double range = d.sensorUpper[k] - d.sensorLower[k];
    if (!(range > kNoRange)) continue;
    std::vector<std::vector<double>> perKelvin(joints_.size(), std::vector<double>(count));
    double most = 0.0;
    for (std::size_t point = 0; point < count; ++point) {
      const Eigen::VectorXd change = (mean(point, k, 0.5 * range) - mean(point, k, -0.5 * range)) / range;
      for (std::size_t a = 0; a < joints_.size(); ++a) {
        perKelvin[a][point] = change[joints_[a]];
        most = std::max(most, std::abs(change[joints_[a]]) * range);
      }
    }
    if (most < kGridLeast) continue;
    sensors_.push_back(d.sensors[k]);
    sensorOf_.push_back(k);
    referenceTemperature_.push_back(middle[k]);
    perKelvin_.push_back(std::move(perKelvin));
    largest_ = std::max(largest_, most);
  }
}

double OffsetGrid::interpolated(const std::vector<double>& values, const State& state) const {
  std::vector<double> place;
  for (const int joint : joints_) place.push_back(state.position[joint]);
  return gridValue(gridCorners(at_, place), values);
}

std::vector<double> OffsetGrid::at(const State& state) const {
  std::vector<double> added;
  for (std::size_t a = 0; a < joints_.size(); ++a) {
    double sum = interpolated(base_[a], state);
    for (std::size_t k = 0; k < sensors_.size(); ++k) {
      const double t = state.temperature[sensorOf_[k]];
      if (std::isfinite(t)) sum += (t - referenceTemperature_[k]) * interpolated(perKelvin_[k][a], state);
    }
    added.push_back(sum);
  }
  return added;
}

std::string OffsetGrid::json() const {
  nlohmann::ordered_json json{
      {"format", "measuring_machine external offsets"}, {"version", 1}, {"axes", letters_}};
  for (std::size_t a = 0; a < letters_.size(); ++a) json["positions_mm"][letters_[a]] = millimetres(at_[a]);
  json["sensors"] = sensors_;
  json["reference_degC"] = nlohmann::ordered_json::object();
  for (std::size_t k = 0; k < sensors_.size(); ++k)
    json["reference_degC"][sensors_[k]] = referenceTemperature_[k];
  for (std::size_t a = 0; a < letters_.size(); ++a) json["offset_mm"][letters_[a]] = millimetres(base_[a]);
  json["offset_mm_per_K"] = nlohmann::ordered_json::object();
  for (std::size_t k = 0; k < sensors_.size(); ++k)
    for (std::size_t a = 0; a < letters_.size(); ++a)
      json["offset_mm_per_K"][sensors_[k]][letters_[a]] = millimetres(perKelvin_[k][a]);
  return json.dump(1) + "\n";
}

}  // namespace mm
