#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace mm {

/// How the deviation follows the temperatures.
enum class ThermalLaw {
  kLinear,      // free expansion
  kSaturating,  // bearing preload: growth is taken up more and more as the bearing tightens
  kBending      // growth rises faster than the temperature (losses and clearance change with it)
};

/// Sets of one warm-up, one row each: 32 temperatures in degC and the deviation at 11 positions in um.
struct MillRun {
  Eigen::MatrixXd temperatures;
  Eigen::MatrixXd deviation;
};

/// The experiment of DFNN on a random three-axis mill: 7 sensors on each of three drives, one on the spindle
/// motor, 5 on the headstock, 4 on the column, 1 in the air; 11 positions along x. Heat flows between lumped
/// masses; the deviation is the expansion of the screw from its fixed bearing to the position, and the shift
/// of headstock and column. The laws act on the growth of the parts, not on any sensor's reading.
class HeatedMill {
 public:
  static constexpr int kSensors = 32, kPositions = 11;

  HeatedMill(std::uint64_t seed, ThermalLaw law);

  /// One set each `minutes[k]` after a cold start at `start` degC, with the feeds and spindle at `load` (1:
  /// as in training). Noise: standard deviations in K and um.
  MillRun run(const std::vector<double>& minutes, double start, double load, double noiseT, double noiseY,
              std::uint64_t seed) const;
  double travel() const { return travel_; }  ///< m, from the first position to the last

 private:
  struct Link {
    std::size_t a, b;
    double conductance;  // W/K
  };
  using Temperatures = std::array<double, kSensors>;  // degC

  void link(int a, int b, double conductance);
  void advance(Temperatures& t, double load, double air) const;
  double growth(double rise) const;
  double deviation(const Temperatures& t, double position) const;

  ThermalLaw law_;
  Temperatures capacity_, loss_, gain_;  // J/K, W/K, W at load 1
  std::vector<Link> links_;
  double screw_, head_, column_;  // um/m/K, um/K, um/K
  double travel_, knee_, phase_;  // m, K, rad
};

}  // namespace mm
