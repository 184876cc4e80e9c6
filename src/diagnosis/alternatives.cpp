#include "diagnosis/alternatives.h"

#include <algorithm>
#include <map>

namespace mm {
namespace {

constexpr double kConfusable = 3.0;  // difference of penalised log-likelihoods
constexpr double kNearlyConfusable = 40.0;
constexpr std::size_t kMostConfusable = 4;

}  // namespace

std::vector<Confusable> alternatives(const Round& round, const Subset& subset, std::size_t member,
                                     std::vector<Gain>& rivals) {
  const SubsetSearch& search = round.search;
  const auto specOf = [&](int candidate) -> const EffectSpec& {
    return round.set.candidates[candidate].spec;
  };
  const EffectSpec& own = specOf(subset.chosen[member].candidate);
  Subset others = search.empty();  // of other causes
  for (const Chosen& c : subset.chosen)
    if (!sameCause(specOf(c.candidate), own)) others = search.extend(others, c);
  const Subset rest = search.without(subset, member);
  rivals = search.bestGains(rest, 12, true);
  std::map<int, double> deltas;
  const auto compare = [&](const Subset& without, const std::vector<Gain>& gains) {
    for (const Gain& g : gains) {
      if (g.candidate == subset.chosen[member].candidate) continue;
      double delta = g.objective - subset.objective;
      if (delta > kConfusable && delta < kNearlyConfusable)  // it may need the help of one more
        delta = search
                    .completed(search.extend(without, {g.candidate, g.nonlinear, g.columns}),
                               subset.chosen[member].candidate)
                    .objective -
                subset.objective;
      const auto [at, fresh] = deltas.try_emplace(g.candidate, delta);
      if (!fresh) at->second = std::min(at->second, delta);
    }
  };
  compare(rest, rivals);
  if (others.chosen.size() < rest.chosen.size()) compare(others, search.bestGains(others, 12, true));
  std::vector<Confusable> out;
  for (const auto& [candidate, delta] : deltas)
    if (delta <= kConfusable) out.push_back({specOf(candidate), std::max(0.0, delta)});
  std::stable_sort(out.begin(), out.end(),
                   [](const Confusable& a, const Confusable& b) { return a.delta < b.delta; });
  if (out.size() > kMostConfusable) out.resize(kMostConfusable);
  // the same with one or two members out and one cause in several shapes in their place
  std::map<int, double> families;  // by their first candidate
  for (std::size_t also = 0; also < subset.chosen.size(); ++also) {
    Subset without = search.without(subset, std::max(also, member));
    if (also != member) without = search.without(without, std::min(also, member));
    for (const Family& family : search.families()) {
      if (sameCause(specOf(family.candidates[0]), own)) continue;
      const double delta = search.objectiveWith(without, family) - subset.objective;
      const auto [at, fresh] = families.try_emplace(family.candidates[0], delta);
      if (!fresh) at->second = std::min(at->second, delta);
    }
  }
  for (const auto& [first, delta] : families)
    if (delta <= kConfusable && out.size() < kMostConfusable &&
        std::none_of(out.begin(), out.end(),
                     [&, other = first](const Confusable& c) { return sameCause(c.effect, specOf(other)); }))
      out.push_back({specOf(first), std::max(0.0, delta)});
  return out;
}

}  // namespace mm
