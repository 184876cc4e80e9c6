#include "estimation/genetic.h"

#include <cmath>

#include "base/error.h"

namespace mm {

void GeneticRanges::validate(std::size_t dimension) const {
  if (dimension == 0) throw InputError("genetic ranges: a chromosome needs at least one gene");
  if (low.size() != dimension || high.size() != dimension)
    throw InputError("genetic ranges: " + std::to_string(low.size()) + " low and " +
                     std::to_string(high.size()) + " high values where the problem has " +
                     std::to_string(dimension) + " genes");
  for (std::size_t i = 0; i < dimension; ++i)
    if (!std::isfinite(low[i]) || !std::isfinite(high[i]) || !(low[i] < high[i]))
      throw InputError("genetic ranges: gene " + std::to_string(i) + " has the range " +
                       std::to_string(low[i]) + " to " + std::to_string(high[i]) +
                       "; low must be below high, and both finite");
}

std::string nameOf(GeneticStop stop) {
  switch (stop) {
    case GeneticStop::kTargetCost:
      return "target_cost";
    case GeneticStop::kCancelled:
      return "cancelled";
    default:
      return "generations";
  }
}

double GeneticResult::rms() const { return std::sqrt(cost); }

std::vector<double> GeneticResult::rmsCurve() const {
  std::vector<double> roots;
  roots.reserve(curve.size());
  for (double value : curve) roots.push_back(std::sqrt(value));
  return roots;
}

}  // namespace mm
