#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "heated_mill.h"
#include "thermal/thermal_network.h"

namespace mm {

/// The experiment of DFNN on one simulated mill: 11 sets of 11 positions, 20 min apart, 32 temperatures; on
/// another day, at another load, tests at 0, 60 and 120 min. Deviations in um, temperatures in degC.
struct Experiment {
  Experiment(std::uint64_t seed, ThermalLaw law, int warmUps = 1);

  std::uint64_t seed;
  HeatedMill mill;
  std::vector<double> minutes, testMinutes;
  MillRun training, test;   // those of the test without noise
  Eigen::MatrixXd truth;    // of the training deviations
  std::vector<int> inputs;  // the 4 sensors of highest grey relational grade, ascending

  /// Columns of the inputs.
  Eigen::MatrixXd chosen(const Eigen::MatrixXd& temperatures) const;
};

/// Names of the 32 sensors, without unit.
std::vector<std::string> sensorNames();

/// What is left of the test's deviations by one method: "dfnn", "dfnn_published" (9 rules, as printed),
/// "rbf", "ridge" or "none". um, tests x positions.
Eigen::MatrixXd leftBy(const std::string& method, const Experiment& experiment);

/// The training or the test in the import format: every set forwards and backwards, 5 s between two
/// positions, with the noise of the instrument.
std::string importCsv(const Experiment& experiment, bool training);

}  // namespace mm
