#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "thermal/mutual_information.h"

namespace mm {

/// The score of a set of sensors, larger is better; safe to call from several threads.
using SetScore = std::function<double(const std::vector<int>&)>;
/// Searches the subsets of `size` of `sensors` sensors where they are too many to try all, as SENSORS does
/// with a genetic algorithm. Returns the best sets it met, best first, at most `keep`; calls `progress`, from
/// the caller's thread, with the fraction done.
using SetSearch = std::function<std::vector<std::vector<int>>(int sensors, int size, int keep,
                                                              std::uint64_t seed, const SetScore& score,
                                                              const std::function<void(double)>& progress)>;

/// By what the set of each size is chosen. Singles are always ranked by information.
enum class SetChoice {
  kPrediction,   // smallest error on other duties (DutyError) times held-out error
  kHeldOut,      // largest information - log(held-out error), both in nat
  kInformation,  // largest information, as SENSORS does
};

struct SelectionSettings {
  InformationSettings information;
  SetChoice choice = SetChoice::kPrediction;
  int largestSize = 3;            // sets of 1 to so many sensors
  double enumerationLimit = 1e5;  // all subsets are tried where they are at most so many
  SetSearch search;               // beyond it; needed only then
  int blocks = 10;                // of time, each held out once
  int gap = 0;                    // samples beside a block that are not used
  double equivalent = 0.999;      // series that correlate at least so much may stand for each other
  /// The smallest set is recommended whose held-out error is at most `accuracy` (unit of the displacement),
  /// or, where none is wanted or reached, within accuracyMargin of the best.
  double accuracy = 0.0;
  double accuracyMargin = 0.1;
  unsigned threads = 0;  // 0: all cores. Results do not depend on it
  std::uint64_t seed = 1;
};

struct SensorScore {
  int sensor = 0;
  double information = 0.0;  // nat
  double correlation = 0.0;  // absolute
};

struct SensorSet {
  std::vector<int> sensors;  // ascending
  double information = 0.0;  // nat
  double heldOutRms =
      0.0;  // of a ridge-linear model on held-out blocks of time, in the unit of the displacement
  double dutyRms = 0.0;  // expected of a line on other duties, in the unit of the displacement
};

/// Which temperatures to measure. Sensors are indices of the columns given.
struct SensorSelection {
  std::vector<SensorScore> singles;  // most informative first; constant sensors are not in it
  std::vector<SensorSet> sets;       // the chosen set of every size, by ascending size
  std::size_t recommended = 0;       // index into sets
  std::vector<int> constant;         // sensors left out because they do not vary
  /// For each sensor of the recommended set: the others that drift together with it and could take its place
  /// in the set, the held-out error staying within accuracyMargin.
  std::vector<std::pair<int, std::vector<int>>> equivalent;
  std::vector<double> subsetsTried;  // of each size
  std::vector<bool> exhaustive;      // whether these were all subsets of the size
};

/// Tells how far the search is, from 0 to 1; false stops it (throws Cancelled).
using SelectionProgress = std::function<bool(double fraction, const std::string& stage)>;

/// Chooses sensors, all of a set together. As published, by joint information with the displacement, (1) and
/// (2): with few and smooth series that picks badly, pairs above all, because it cannot tell a temperature
/// that the displacement follows on any duty from one that happens to go with it on this one. By default,
/// then, by what a line through the set would leave on other duties and what it leaves of held-out blocks of
/// time: both estimate the error in use, the first hardly sees noise, the second assumes nothing, and the set
/// with the smallest product is chosen. `temperatures`: samples x sensors in the order of time. Throws
/// InputError for bad series or settings.
SensorSelection selectSensors(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement,
                              const SelectionSettings& settings = {}, const SelectionProgress& progress = {});

/// Whether a series is anything but one value.
inline bool varies(const Eigen::VectorXd& series) { return series.maxCoeff() > series.minCoeff(); }

/// Grey relational grade of every input with the outputs, as DFNN chooses its temperatures: each series is
/// scaled to 0 … 1, Delta_i(k) = |x_0(k) - x_i(k)|, xi_i(k) = (Delta_min + rho Delta_max) / (Delta_i(k) + rho
/// Delta_max), rho 0.5, with the extremes over all inputs and samples; the grade is the mean over k, and over
/// the outputs where there are many. An input that falls as the output rises is mirrored. A series that does
/// not vary has grade 0.
/// @param inputs samples x inputs; outputs samples x outputs; any units. Throws InputError for unequal
/// lengths.
Eigen::VectorXd greyRelationalGrade(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs);

}  // namespace mm
