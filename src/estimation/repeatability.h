#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// Standard deviation of one measurement, found from the same thing measured again.
struct Repeatability {
  double value = 0.0;  // m, or rad of angular rows
  double dof = 0.0;    // degrees of freedom; 0: there are too few repeats to say
  std::string from;    // "consecutive", "runs"; empty: none
  std::string inWords;
  double relativeStd() const;  ///< standard uncertainty of `value` in parts of it; NaN without repeats
};

/// From repeats of the same target: one after the other, else in runs over the same targets (ISO 230-2),
/// whatever else was measured between. A target is a feature, setup, approach, direction of travel and
/// position. Neither drift between repeats nor a shift of a whole run counts: of three in a row the middle
/// one is compared with the mean of its neighbours, of two runs what differs between all their targets is
/// taken out. What stands apart (4 times the bulk) is an outlier, not repeatability.
/// @param residuals m or rad a data row. @param angular which kind of rows.
Repeatability repeatedMeasurements(const Problem& problem, const Eigen::VectorXd& residuals, bool angular);

/// The run to which each observation belongs, from 0 on: one ends where a target comes again.
std::vector<int> runNumbers(const Problem& problem);

/// What the runs over the same targets have in common.
struct SharedByRuns {
  double share = 0.0;  // of the variance: about 1 where values follow the place, about 0 where the time
  int pairs = 0;       // of runs that were compared, for each kind of row; 0: nothing was measured in runs
};
/// How much of some values is the same in runs over the same targets, without what shifts a whole run.
/// @param values a data row, in any unit; NaN: none.
SharedByRuns sharedByRuns(const Problem& problem, const Eigen::VectorXd& values, bool angular);

}  // namespace mm
