#include "fleet/prior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "base/distributions.h"
#include "base/error.h"
#include "base/range.h"
#include "fleet/robust_numbers.h"

namespace mm {
namespace {

/// Of the standard deviation `spread` between machines: its log density, and what it predicts.
struct AtSpread {
  double logDensity = 0.0, mean = 0.0, variance = 0.0;
};

AtSpread atSpread(const std::vector<Sister>& sisters, double spread) {
  double weight = 0.0, sum = 0.0;
  for (const Sister& s : sisters) {
    const double w = 1.0 / (s.std * s.std + spread * spread);
    weight += w;
    sum += w * s.value;
  }
  AtSpread at;
  at.mean = sum / weight;
  at.variance = spread * spread + 1.0 / weight;
  at.logDensity = -0.5 * std::log(weight);
  for (const Sister& s : sisters) {
    const double v = s.std * s.std + spread * spread, r = s.value - at.mean;
    at.logDensity -= 0.5 * (std::log(v) + r * r / v);
  }
  return at;
}

}  // namespace

PopulationPrior predictiveOf(const std::vector<Sister>& sisters) {
  PopulationPrior prior;
  prior.machines = sisters.size();
  Range values;
  double least = 0.0;
  for (const Sister& s : sisters) {
    values.add(s.value);
    least = std::max(least, s.std);
  }
  const double reach = 4.0 * std::max(values.size(), least);
  if (!(reach > 0.0)) {
    prior.mean = values.lower;
    return prior;
  }
  constexpr int kSteps = 2000;
  std::vector<AtSpread> grid;
  double largest = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSteps; ++i) {
    grid.push_back(atSpread(sisters, reach * (i + 0.5) / kSteps));
    largest = std::max(largest, grid.back().logDensity);
  }
  double total = 0.0, mean = 0.0, square = 0.0;
  for (const AtSpread& at : grid) {
    const double weight = std::exp(at.logDensity - largest);
    total += weight;
    mean += weight * at.mean;
    square += weight * (at.variance + at.mean * at.mean);
  }
  prior.mean = mean / total;
  prior.std = std::sqrt(std::max(0.0, square / total - prior.mean * prior.mean));
  return prior;
}

std::vector<PopulationPrior> populationPriors(const Fleet& fleet, const std::string& except) {
  using Key = std::tuple<std::string, std::string, std::string>;  // effect, name, unit
  std::map<Key, std::set<std::string>> all;                       // machines that have it
  for (const FleetRecord& r : fleet.records)
    for (const FleetParameter& p : r.result.parameters)
      if (r.machine != except) all[{p.effect, p.name, p.unit}].insert(r.machine);
  std::map<std::pair<std::string, std::string>, const FleetSeries*> series;
  for (const FleetSeries& s : fleet.series) series[{s.quantity, s.machine}] = &s;
  std::vector<PopulationPrior> priors;
  for (const auto& [key, machines] : all) {
    const auto& [effect, name, unit] = key;
    std::vector<Sister> sisters;
    for (const std::string& machine : machines)  // without a series: fixed, or never determined
      if (const auto at = series.find({name + " of " + effect, machine}); at != series.end())
        sisters.push_back(presentOf(*at->second));
    if (sisters.size() < kFewestForPrior) continue;
    PopulationPrior prior = predictiveOf(sisters);
    prior.effect = effect;
    prior.name = name;
    prior.unit = unit;
    if (prior.std > 0.0) priors.push_back(prior);
  }
  if (priors.empty())
    throw InputError(fleet.source + ": no parameter is known for " + std::to_string(kFewestForPrior) +
                     " or more machines; a population prior needs that many");
  return priors;
}

double conflictOf(double chi2, double count) {
  return count > 0.0 ? chiSquaredTail(std::max(0.0, chi2), count) : 1.0;
}

}  // namespace mm
