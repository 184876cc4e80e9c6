#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "uncertainty/measurement_task.h"
#include "uncertainty/virtual_machine.h"

namespace mm {

/// The part of one cause in the variance of a figure.
struct UncertaintyShare {
  std::string source;
  double share = 0.0;  // of the sum over all sources, which is 1
  double std = 0.0;    // m, standard uncertainty by this source alone
};

/// One figure of a task with its uncertainty. m.
struct QuantityUncertainty {
  TaskQuantity quantity;
  double mean = 0.0;                     // of what would be measured
  double std = 0.0;                      // standard uncertainty
  double lower = 0.0, upper = 0.0;       // probabilistically symmetric 95 % coverage interval
  std::vector<UncertaintyShare> budget;  // largest first; empty: nothing makes it uncertain
};

struct TaskUncertainty {
  std::string task;
  std::vector<QuantityUncertainty> quantities;
  std::size_t headline = 0;  // the quantity that was asked for
  std::uint64_t seed = 1;
  std::size_t trials = 0;
  int digits = 0;      // significant digits of the standard uncertainty that were to be stable; 0: not asked
  bool stable = true;  // they are
  double passes = kNotMeasured;  // share of the trials in which the whole test passes; NaN: it has no limits
  std::vector<std::string> outside;  // why the calibration does not hold there; empty: it holds
  std::vector<std::string> notes;
};

/// The value below which a share of the sorted values lies, linear between them. @param sorted at least one.
double quantileOf(const std::vector<double>& sorted, double share);

struct MonteCarloOptions {
  std::uint64_t seed = 1;
  std::size_t trials = 0;  // 0: as many as make `digits` digits stable
  std::size_t most = 1500000;
  int digits = 2;        // 1 or 2
  std::string quantity;  // headline; empty: the first of the task, of a position the least certain
  std::function<void(double)> progress;  // share done, 0 to 1
};

/// Propagates the distributions of everything that is uncertain through a measurement (GUM Supplement 1, JCGM
/// 101:2008, clauses 5 to 7): five or more batches of 10 000 trials until twice the standard deviation of the
/// averages of mean, standard uncertainty and ends of the coverage interval of the headline are below half a
/// unit of the last digit (7.9). Of a position the coordinate is judged that is the least certain after five
/// batches. The result depends on the seed and not on the number of threads. Shares: variance of the figure
/// when one source acts alone, over their sum.
/// @throw InputError: the task has no such quantity. Cancelled.
TaskUncertainty taskUncertainty(const MeasurementTask& task, const VirtualMachine& machine,
                                const MonteCarloOptions& options);

}  // namespace mm
