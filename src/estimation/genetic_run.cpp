#include "estimation/genetic_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "base/error.h"

namespace mm {
namespace {

/// Chromosomes that one thread takes at a time: enough to use a contact's data often while it is in the
/// cache, few enough to keep the threads equally busy. Part of no result.
constexpr std::size_t kIndividualsABlock = 64;

}  // namespace

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

void checkSetting(const char* algorithm, const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  std::ostringstream message;
  message << algorithm << ": " << name << " = " << value << " is not within " << low << " to " << high
          << "; correct the setting or leave it out for its default";
  throw InputError(message.str());
}

void checkSettings(const char* algorithm, const GeneticSettings& settings) {
  checkSetting(algorithm, "population", static_cast<double>(settings.population), 2, 1e7);
  checkSetting(algorithm, "generations", static_cast<double>(settings.generations), 0, 1e7);
  checkSetting(algorithm, "threads", settings.threads, 0, 1024);
}

GeneticRun::GeneticRun(const char* algorithm, GeneticFitness& fitness, const GeneticRanges& ranges,
                       const GeneticSettings& settings, const GeneticControl& control)
    : algorithm_(algorithm),
      fitness_(fitness),
      ranges_(ranges),
      settings_(settings),
      control_(control),
      dimension_(fitness.dimension()),
      threads_(settings.threads) {
  ranges.validate(dimension_);
  current_.resize(settings.population * dimension_);
  next_.resize(current_.size());
  costs_.resize(settings.population);
  order_.resize(settings.population);
  result_.best.resize(dimension_);
  result_.curve.reserve(settings.generations + 1);
  std::vector<double> middle;
  for (std::size_t i = 0; i < dimension_; ++i) middle.push_back(0.5 * (ranges.low[i] + ranges.high[i]));
  fitness_.newGeneration(middle.data());
}

void GeneticRun::fillRandom(double* chromosome, GeneticRandom& random) const {
  for (std::size_t i = 0; i < dimension_; ++i)
    chromosome[i] = random.between(ranges_.low[i], ranges_.high[i]);
}

void GeneticRun::fillFirst() {
  for (std::size_t i = 0; i < population(); ++i) {
    GeneticRandom stream = random(i);
    fillRandom(chromosome(i), stream);
  }
}

void GeneticRun::evaluate() {
  const std::size_t count = population();
  threads_.run([&] {
    parallelFor(partsOf(count, kIndividualsABlock), [&](std::size_t block) {
      const Part part = partOf(count, kIndividualsABlock, block);
      fitness_.evaluate(current_.data() + part.first * dimension_, part.end - part.first,
                        costs_.data() + part.first);
    });
  });
  result_.evaluations += count;
}

void GeneticRun::rank() {
  for (std::size_t i = 0; i < order_.size(); ++i) {
    order_[i] = i;
    if (!std::isfinite(costs_[i])) costs_[i] = std::numeric_limits<double>::infinity();
  }
  // The index settles ties, so that the order is the same in every sort.
  std::sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
    return costs_[a] < costs_[b] || (costs_[a] == costs_[b] && a < b);
  });
}

bool GeneticRun::closeGeneration() {
  std::swap(current_, next_);
  evaluate();
  rank();
  const double cost = rankedCost(0);
  if (!std::isfinite(cost))
    throw NumericalError(std::string(algorithm_) + ": no chromosome of generation " +
                         std::to_string(generation_) + " has a finite cost; narrow the ranges");
  std::copy_n(ranked(0), dimension_, result_.best.begin());
  result_.curve.push_back(cost);
  result_.generations = generation_;
  result_.cost = cost;
  changed_ = fitness_.newGeneration(result_.best.data());
  if (control_.progress) control_.progress({generation_, settings_.generations, cost});
  if (generation_ >= settings_.generations) return false;
  result_.cancelled = control_.cancelled && control_.cancelled();
  if (result_.cancelled) return false;
  ++generation_;
  return true;
}

GeneticResult GeneticRun::result() {
  if (changed_) {
    fitness_.evaluate(result_.best.data(), 1, &result_.cost);
    ++result_.evaluations;
  }
  result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  return std::move(result_);
}

}  // namespace mm
