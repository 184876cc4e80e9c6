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

struct SelectionSettings {
  InformationSettings information;
  int largestSize = 3;            // sets of 1 to so many sensors
  double enumerationLimit = 1e5;  // all subsets are tried where they are at most so many
  SetSearch search;               // beyond it; needed only then
  int informationSamples = 500;   // longer series are thinned evenly to so many for the information
  bool crossValidate =
      true;             // choose among the proposed sets by held-out error too; else by information alone
  int shortlist = 500;  // sets of each size that information proposes to the cross-validation
  int blocks = 10;      // of time, each held out once
  int gap = 0;          // samples beside a block that are not used
  double equivalent = 0.999;  // series that correlate at least so much may stand for each other
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

/// Chooses sensors as SENSORS does: by their joint information with the displacement, (1) and (2).
/// Information alone picks pairs badly where the series are few and smooth, held-out error alone trusts
/// differences of sensors that only fit the one duty; so information proposes a shortlist, and of it the set
/// with the largest information - log(held-out error) is chosen, both in nat. `temperatures`: samples x
/// sensors in the order of time. Throws InputError for bad series or settings.
SensorSelection selectSensors(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement,
                              const SelectionSettings& settings = {}, const SelectionProgress& progress = {});

}  // namespace mm
