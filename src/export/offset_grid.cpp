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

OffsetGrid offsetGrid(const NeededCorrection& needed, CorrectionPart part) {
  using nlohmann::ordered_json;
  OffsetGrid grid;
  std::vector<std::vector<double>> positions;  // a joint, m
  const std::vector<int>& joints = needed.linear();
  const Domain& d = needed.model().domain();
  std::vector<std::size_t> strides(joints.size(), 1);
  std::size_t count = 1;
  for (const int joint : joints) {
    grid.letters.push_back(needed.axis(joint).letter);
    const auto [lower, upper] = needed.tabulated(joint);
    positions.push_back(evenSteps(lower, upper, kGridPoints - 1));
    count *= kGridPoints;
  }
  std::vector<std::vector<double>> own(joints.size());  // what the joint tables are fitted to
  for (std::size_t a = 0; a < joints.size(); ++a)
    for (const double position : positions[a])
      own[a].push_back(meanCorrection(needed, joints[a], position, part)[joints[a]]);
  for (std::size_t a = joints.size(); a-- > 1;) strides[a - 1] = strides[a] * kGridPoints;
  std::vector<double> middle;
  for (std::size_t k = 0; k < d.sensors.size(); ++k)
    middle.push_back(0.5 * (d.sensorLower[k] + d.sensorUpper[k]));

  std::vector<State> others = needed.states(kTemperatureless, kGridSeed);
  const auto mean = [&](std::size_t point, int sensor, double kelvin) {
    return meanOver(needed, part, others, [&](State& state) {
      for (std::size_t a = 0; a < joints.size(); ++a)
        state.position[joints[a]] = positions[a][point / strides[a] % kGridPoints];
      state.temperature = middle;
      if (sensor >= 0) state.temperature[sensor] += kelvin;
    });
  };
  // An axis: m at each grid point, the last joint fastest.
  std::vector<std::vector<double>> base(joints.size(), std::vector<double>(count));
  for (std::size_t point = 0; point < count; ++point) {
    const Eigen::VectorXd value = mean(point, -1, 0.0);
    for (std::size_t a = 0; a < joints.size(); ++a)
      base[a][point] = value[joints[a]] - own[a][point / strides[a] % kGridPoints];
  }
  std::vector<double> reference;
  for (const int joint : joints) reference.push_back(needed.reference(joint));
  for (std::vector<double>& values : base) {
    const double zero = gridValue(gridCorners(positions, reference), values);
    for (double& v : values) {
      v -= zero;
      grid.largest = std::max(grid.largest, std::abs(v));
    }
  }
  ordered_json references = ordered_json::object(), perKelvins = ordered_json::object();
  for (std::size_t k = 0; k < d.sensors.size(); ++k) {
    const double range = d.sensorUpper[k] - d.sensorLower[k];
    if (!(range > kNoRange)) continue;
    std::vector<std::vector<double>> perKelvin(joints.size(), std::vector<double>(count));
    double most = 0.0;
    for (std::size_t point = 0; point < count; ++point) {
      const Eigen::VectorXd change = (mean(point, k, 0.5 * range) - mean(point, k, -0.5 * range)) / range;
      for (std::size_t a = 0; a < joints.size(); ++a) {
        perKelvin[a][point] = change[joints[a]];
        most = std::max(most, std::abs(change[joints[a]]) * range);
      }
    }
    if (most < kGridLeast) continue;
    grid.sensors.push_back(d.sensors[k]);
    references[d.sensors[k]] = middle[k];
    for (std::size_t a = 0; a < joints.size(); ++a)
      perKelvins[d.sensors[k]][grid.letters[a]] = millimetres(perKelvin[a]);
    grid.largest = std::max(grid.largest, most);
  }
  ordered_json json{{"format", "measuring_machine external offsets"}, {"version", 1}, {"axes", grid.letters}};
  for (std::size_t a = 0; a < joints.size(); ++a)
    json["positions_mm"][grid.letters[a]] = millimetres(positions[a]);
  json["sensors"] = grid.sensors;
  json["reference_degC"] = references;
  for (std::size_t a = 0; a < joints.size(); ++a) json["offset_mm"][grid.letters[a]] = millimetres(base[a]);
  json["offset_mm_per_K"] = perKelvins;
  grid.json = json.dump(1) + "\n";
  return grid;
}

}  // namespace mm
