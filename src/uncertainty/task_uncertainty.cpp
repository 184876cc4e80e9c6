#include "uncertainty/task_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/parallel.h"

namespace mm {
namespace {

constexpr std::size_t kBatch = 10000;      // trials, JCGM 101, 7.9.4
constexpr std::size_t kFewestBatches = 5;  // fewer do not tell their own scatter
constexpr std::size_t kAlone = 10000;      // trials of one source alone: shares to 1.4 % of themselves
constexpr std::size_t kPart = 1000;        // trials computed in one piece
constexpr double kTail = 0.025;            // on either side of a 95 % interval
constexpr double kNothing = 1e-15;         // m: below it a figure is certain

/// One figure over the trials of a batch: what is averaged over the batches.
using BatchFigure = Eigen::Array4d;
enum { kMean, kVariance, kLower, kUpper };  // its elements
struct Batch {
  std::vector<BatchFigure> figures;  // a quantity each
  double passes = 0.0;               // share of the trials; NaN: the task has no limits of its own
};

BatchFigure figureOf(std::vector<double> values, double nominal) {
  double sum = 0.0, squares = 0.0;  // about the nominal value, lest a length in m eats the digits of nm
  for (const double v : values) sum += v - nominal;
  const double mean = sum / values.size();
  for (const double v : values) squares += (v - nominal - mean) * (v - nominal - mean);
  std::sort(values.begin(), values.end());
  return {nominal + mean, values.size() > 1 ? squares / (values.size() - 1) : 0.0, quantileOf(values, kTail),
          quantileOf(values, 1.0 - kTail)};
}

/// Runs trials of one stream of random numbers. @param only as VirtualMachine::draw.
Batch runBatch(const MeasurementTask& task, const VirtualMachine& machine, std::uint64_t seed,
               const std::string& name, int only, std::size_t trials) {
  const std::size_t quantities = task.quantities.size();
  std::vector<std::vector<double>> values(quantities, std::vector<double>(trials));
  std::vector<char> passed(trials, 0);
  parallelFor(partsOf(trials, kPart), [&](std::size_t part) {
    CancelScope::check();
    const Part mine = partOf(trials, kPart, part);
    Random random(seed, name + " " + std::to_string(part));
    VirtualMachine::Workspace work;
    std::vector<Eigen::Vector3d> errors;
    std::vector<double> found(quantities);
    for (std::size_t t = mine.first; t < mine.end; ++t) {
      machine.draw(random, only, work, errors);
      for (std::size_t i = 0; i < errors.size(); ++i) errors[i] += task.points[i].place;
      task.figures(errors, found.data());
      passed[t] = task.passes && task.passes(errors);
      for (std::size_t q = 0; q < quantities; ++q) values[q][t] = found[q];
    }
  });
  Batch batch;
  for (std::size_t q = 0; q < quantities; ++q)
    batch.figures.push_back(figureOf(std::move(values[q]), task.quantities[q].nominal));
  const double passes = std::count(passed.begin(), passed.end(), 1);
  batch.passes = task.passes ? passes / trials : kNotMeasured;
  return batch;
}

/// Half a unit of the last of so many significant digits (JCGM 101, 7.9.2).
double toleranceOf(double std, int digits) {
  return 0.5 * std::pow(10.0, std::floor(std::log10(std)) - (digits - 1));
}

/// Whether twice the standard deviations of the averages over the batches are below the tolerance (7.9.4).
bool settled(const std::vector<Batch>& batches, std::size_t headline, int digits) {
  const double h = batches.size();
  if (batches.size() < kFewestBatches) return false;
  double variance = 0.0;
  for (const Batch& b : batches) variance += b.figures[headline][kVariance] / h;
  if (std::sqrt(variance) < kNothing) return true;
  const double tolerance = toleranceOf(std::sqrt(variance), digits);
  const auto judged = [&](const Batch& b) {
    BatchFigure figure = b.figures[headline];
    figure[kVariance] = std::sqrt(figure[kVariance]);  // it is the standard uncertainty that settles
    return figure;
  };
  BatchFigure mean = BatchFigure::Zero(), squares = mean;
  for (const Batch& b : batches) mean += judged(b) / h;
  for (const Batch& b : batches) squares += (judged(b) - mean).square();
  return 2.0 * (squares / (h * (h - 1.0))).sqrt().maxCoeff() < tolerance;
}

/// Of a position, the coordinate that is known worst; of another task its first figure.
std::size_t worstCoordinate(const MeasurementTask& task, const std::vector<Batch>& batches) {
  if (task.quantities.front().name != "x") return 0;
  const auto variance = [&](std::size_t q) {
    double sum = 0.0;
    for (const Batch& b : batches) sum += b.figures[q][kVariance];
    return sum;
  };
  std::size_t worst = 0;
  for (std::size_t q = 1; q < task.quantities.size(); ++q)
    if (variance(q) > variance(worst)) worst = q;
  return worst;
}

std::size_t headlineOf(const MeasurementTask& task, const std::string& name) {
  const std::vector<std::string> names = allNames(task.quantities);
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end())
    throw InputError("--quantity: the task has no '" + name + "'" + didYouMean(name, names) + "; it gives " +
                     listOf(names));
  return at - names.begin();
}

void addBudgets(const MeasurementTask& task, const VirtualMachine& machine, std::uint64_t seed,
                TaskUncertainty& result) {
  const std::size_t trials = task.points.size() > 60 ? kAlone / 5 : kAlone;
  for (std::size_t s = 0; s < machine.sources().size(); ++s) {
    const Batch alone = runBatch(task, machine, seed, "alone " + std::to_string(s), s, trials);
    for (std::size_t q = 0; q < alone.figures.size(); ++q)
      result.quantities[q].budget.push_back(
          {machine.sources()[s], 0.0, std::sqrt(alone.figures[q][kVariance])});
  }
  for (QuantityUncertainty& q : result.quantities) {
    double sum = 0.0;
    for (const UncertaintyShare& s : q.budget) sum += s.std * s.std;
    if (std::sqrt(sum) < kNothing) {
      q.budget.clear();
      continue;
    }
    for (UncertaintyShare& s : q.budget) s.share = s.std * s.std / sum;
    std::stable_sort(q.budget.begin(), q.budget.end(),
                     [](const UncertaintyShare& a, const UncertaintyShare& b) { return a.share > b.share; });
  }
}

}  // namespace

double quantileOf(const std::vector<double>& sorted, double share) {
  const double at = share * (sorted.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (at - low) * (sorted[high] - sorted[low]);
}

TaskUncertainty taskUncertainty(const MeasurementTask& task, const VirtualMachine& machine,
                                const MonteCarloOptions& options) {
  TaskUncertainty result;
  result.task = task.text;
  result.seed = options.seed;
  result.outside = machine.outside();
  result.notes = machine.notes();
  if (!options.quantity.empty()) result.headline = headlineOf(task, options.quantity);
  const auto tell = [&](double share) {
    if (options.progress) options.progress(share);
  };
  std::vector<Batch> batches;
  if (options.trials > 0) {
    batches.push_back(runBatch(task, machine, options.seed, "trials", -1, options.trials));
    result.trials = options.trials;
  } else {
    result.digits = options.digits;
    result.stable = false;
    while (!result.stable && result.trials < options.most) {
      batches.push_back(
          runBatch(task, machine, options.seed, "batch " + std::to_string(batches.size()), -1, kBatch));
      result.trials += kBatch;
      if (batches.size() == kFewestBatches && options.quantity.empty())
        result.headline = worstCoordinate(task, batches);
      result.stable = settled(batches, result.headline, options.digits);
      tell(std::min(0.9, static_cast<double>(result.trials) / options.most));
    }
  }
  for (std::size_t q = 0; q < task.quantities.size(); ++q) {
    const TaskQuantity& quantity = task.quantities[q];
    const double share = 1.0 / batches.size(), nominal = quantity.nominal;
    const BatchFigure offset(nominal, 0.0, nominal, nominal);
    BatchFigure figure = BatchFigure::Zero();
    for (const Batch& b : batches) figure += share * (b.figures[q] - offset);
    result.quantities.push_back({quantity,
                                 nominal + figure[kMean],
                                 std::sqrt(figure[kVariance]),
                                 nominal + figure[kLower],
                                 nominal + figure[kUpper],
                                 {}});
  }
  if (options.trials > 0 && options.quantity.empty()) result.headline = worstCoordinate(task, batches);
  result.passes = 0.0;
  for (const Batch& b : batches) result.passes += b.passes / batches.size();
  addBudgets(task, machine, options.seed, result);
  tell(1.0);
  return result;
}

}  // namespace mm
