#include "estimation/genetic_subset.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/error.h"
#include "estimation/genetic_run.h"

namespace mm {
namespace {

using Subset = std::vector<std::size_t>;
constexpr const char* kSubset = "subset";
constexpr double kParentShare = 0.3;   // the best of a generation breed the next; the best one lives on
constexpr std::size_t kPatience = 25;  // generations without a better subset

/// Scores subsets, each once, and keeps the best.
class Scorer {
 public:
  Scorer(const SubsetScore& score, SubsetResult& result) : score_(score), result_(result) {
    result_.score = kWorst;
  }
  double operator()(const Subset& subset) {
    const auto known = known_.find(subset);
    if (known != known_.end()) return known->second;
    double value = score_(subset);
    if (!std::isfinite(value)) value = kWorst;
    ++result_.evaluations;
    known_.emplace(subset, value);
    if (value > result_.score) {
      result_.score = value;
      result_.items = subset;
    }
    return value;
  }

 private:
  static constexpr double kWorst = -std::numeric_limits<double>::infinity();
  const SubsetScore& score_;
  SubsetResult& result_;
  std::map<Subset, double> known_;
};

/// Fills `subset` up to `choose` with items drawn at random from those that it does not hold.
void complete(Subset& subset, std::size_t items, std::size_t choose, GeneticRandom& random) {
  while (subset.size() < choose) {
    const std::size_t item = random.below(items);
    if (std::find(subset.begin(), subset.end(), item) == subset.end()) subset.push_back(item);
  }
}

/// What both parents have, then items of either, some exchanged for items of neither or either.
Subset childOf(const Subset& a, const Subset& b, std::size_t items, double mutation, GeneticRandom& random) {
  const std::size_t choose = a.size();
  Subset child, either;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(child));
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(either));
  while (child.size() < choose) {
    const std::size_t pick = random.below(either.size());
    child.push_back(either[pick]);
    either.erase(either.begin() + static_cast<std::ptrdiff_t>(pick));
  }
  for (std::size_t i = 0; choose < items && i < choose; ++i) {
    if (random.unit() >= mutation) continue;
    std::size_t other = random.below(items);
    while (std::find(child.begin(), child.end(), other) != child.end()) other = random.below(items);
    child[i] = other;
  }
  std::sort(child.begin(), child.end());
  return child;
}

using Ranked = std::vector<std::pair<double, Subset>>;  // score and subset, best first

void rank(Ranked& ranked, Scorer& score) {
  for (auto& entry : ranked) entry.first = score(entry.second);
  std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return a.first > b.first || (a.first == b.first && a.second < b.second);
  });
}

}  // namespace

void SubsetSettings::validate() const {
  checkSetting(kSubset, "population", static_cast<double>(population), 2, 1e6);
  checkSetting(kSubset, "generations", static_cast<double>(generations), 0, 1e7);
  checkSetting(kSubset, "mutation", mutation, 0.0, 1.0);
}

SubsetResult bestSubset(std::size_t items, std::size_t choose, const SubsetScore& score,
                        const SubsetSettings& settings, const GeneticControl& control) {
  settings.validate();
  checkSetting(kSubset, "number of items to choose", static_cast<double>(choose), 1,
               static_cast<double>(items));
  SubsetResult result;
  Scorer scorer(score, result);
  Ranked ranked(settings.population), next(settings.population);
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    GeneticRandom random(settings.seed, 0, i);
    complete(ranked[i].second, items, choose, random);
    std::sort(ranked[i].second.begin(), ranked[i].second.end());
  }
  const auto parents =
      std::max<std::size_t>(2, static_cast<std::size_t>(kParentShare * static_cast<double>(ranked.size())));
  std::size_t last = 0;  // generation of the last improvement
  for (std::size_t generation = 0;; ++generation) {
    const double before = result.score;
    rank(ranked, scorer);
    if (result.score > before) last = generation;
    result.curve.push_back(result.score);
    result.generations = generation;
    if (control.progress) control.progress({generation, settings.generations, -result.score});
    if (generation >= settings.generations) break;
    if (generation - last >= kPatience) break;
    result.cancelled = control.cancelled && control.cancelled();
    if (result.cancelled) break;
    next[0] = ranked[0];
    for (std::size_t i = 1; i < next.size(); ++i) {
      GeneticRandom random(settings.seed, generation + 1, i);
      const Subset& a = ranked[random.below(parents)].second;
      const Subset& b = ranked[random.below(parents)].second;
      next[i].second = childOf(a, b, items, settings.mutation, random);
    }
    std::swap(ranked, next);
  }
  if (result.items.empty()) throw NumericalError("subset: no choice of items has a finite score");
  return result;
}

}  // namespace mm
