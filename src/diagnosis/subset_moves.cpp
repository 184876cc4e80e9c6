// How a set of effects is bettered once it is chosen: other values, other members, families of shapes.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/fresh_basis.h"
#include "diagnosis/subset_search.h"

namespace mm {

void SubsetSearch::refineAll(Subset& subset) const {
  for (std::size_t i = 0; i < subset.chosen.size(); ++i) {
    if (subset.chosen[i].nonlinear.empty()) continue;
    const Subset rest = without(subset, i);
    const Gain g = gainOf(rest, subset.chosen[i].candidate, subset.chosen[i].nonlinear, true);
    if (g.objective < subset.objective - 1e-9) {
      Subset next = extend(rest, {g.candidate, g.nonlinear, g.columns});
      std::rotate(next.chosen.begin() + static_cast<long>(i), next.chosen.end() - 1, next.chosen.end());
      subset = next;
    }
  }
}

std::vector<int> SubsetSearch::chooseShapes(const Subset& rest, const Family& family,
                                            double& objective) const {
  const int n = static_cast<int>(family.candidates.size());
  const Eigen::MatrixXd absorbed = rest.basis.transpose() * family.columns;
  Eigen::MatrixXd gram = family.gram - absorbed.transpose() * absorbed;
  const Eigen::VectorXd size = family.gram.diagonal();
  Eigen::VectorXd score = family.columns.transpose() * rest.left;
  std::vector<bool> left(n);
  for (int k = 0; k < n; ++k) left[k] = size[k] > 0.0 && !rest.contains(family.candidates[k]);
  std::vector<int> chosen;
  double rss = rest.rss, penalty = rest.penalty;
  objective = rest.objective;
  // the first shape may pay only together with the second: it is taken on trust
  for (int round = 0; round < n; ++round) {
    int best = -1;
    double bestRss = rss;
    for (int k = 0; k < n; ++k) {
      if (!left[k] || gram(k, k) < kDependent * size[k]) continue;
      const double now = rss - score[k] * score[k] / gram(k, k);
      if (best < 0 || now < bestRss) best = k, bestRss = now;
    }
    if (best < 0) break;
    const int candidate = family.candidates[best];
    const double price = round == 0 ? penaltyOf(rest, candidate) : set_.candidates[candidate].cost;
    const double next = 0.5 * dof_ * std::log(std::max(bestRss, 1e-300) / dof_) + penalty + price;
    if (round > 0 && next >= objective) break;
    objective = next;
    penalty += price;
    rss = bestRss;
    left[best] = false;
    chosen.push_back(best);
    const Eigen::VectorXd column = gram.col(best) / gram(best, best);
    score -= column * score[best];
    gram -= column * gram.row(best).eval();
  }
  return chosen;
}

double SubsetSearch::objectiveWith(const Subset& rest, const Family& family) const {
  double objective = 0.0;
  chooseShapes(rest, family, objective);
  return objective;
}

Subset SubsetSearch::withFamily(const Subset& rest, const Family& family) const {
  double objective = 0.0;
  Subset grown = rest;
  for (const int k : chooseShapes(rest, family, objective))
    grown = extend(grown, {family.candidates[k], {}, family.columns.col(k)});
  return grown;
}

bool SubsetSearch::exchangeForFamilies(Subset& subset) const {
  bool moved = false;
  for (bool again = true; again;) {
    again = false;
    const std::vector<Chosen> all = subset.chosen;
    Subset before = empty();  // the members before i
    for (std::size_t i = 0; i < all.size() && !again; before = extend(before, all[i++])) {
      Subset between = before;  // and those between i and j
      for (std::size_t j = i; j < all.size() && !again; ++j) {
        if (j > i + 1) between = extend(between, all[j - 1]);
        Subset rest = between;
        for (std::size_t k = j + 1; k < all.size(); ++k) rest = extend(rest, all[k]);
        for (const Family& family : families_) {
          if (objectiveWith(rest, family) >= subset.objective - 1e-6) continue;
          const Subset trial = withFamily(rest, family);
          if (trial.objective >= subset.objective - 1e-6) continue;
          subset = trial;
          again = moved = true;
          break;
        }
      }
    }
  }
  return moved;
}

Subset SubsetSearch::completed(const Subset& subset, int but) const {
  for (const Gain& g : bestGains(subset, 2, true))
    if (!sameCause(set_.candidates[g.candidate].spec, set_.candidates[but].spec))
      return significant(g) && g.objective < subset.objective
                 ? extend(subset, {g.candidate, g.nonlinear, g.columns})
                 : subset;
  return subset;
}

Gain SubsetSearch::gainBeside(const Subset& subset, std::size_t member,
                              const Eigen::MatrixXd& columns) const {
  const Chosen& c = subset.chosen[member];
  return gainOf(withColumns(without(subset, member), columns), c.candidate, c.nonlinear, false);
}

Subset SubsetSearch::countingBeside(const Subset& subset, const Eigen::MatrixXd& columns,
                                    const EffectSpec* spared) const {
  Subset kept = subset;
  for (;;) {
    double smallest = 1e300;
    std::size_t goes = kept.chosen.size();
    for (std::size_t i = 0; i < kept.chosen.size(); ++i) {
      if (spared != nullptr && sameCause(set_.candidates[kept.chosen[i].candidate].spec, *spared)) continue;
      const Gain gain = gainBeside(kept, i, columns);
      if (significant(gain) || gain.drop >= smallest) continue;
      smallest = gain.drop;
      goes = i;
    }
    if (goes == kept.chosen.size()) return kept;
    kept = without(kept, goes);
  }
}

void SubsetSearch::exchange(Subset& subset) const {
  const bool large = space_.length() > kLargeSession;
  for (int round = 0; round < 12; ++round) {
    bool moved = false;
    for (std::size_t i = 0; i < subset.chosen.size(); ++i) {
      const Subset rest = without(subset, i);
      for (const Gain& g : bestGains(rest, 3, true)) {
        if (g.candidate == subset.chosen[i].candidate) continue;
        Subset next = extend(rest, {g.candidate, g.nonlinear, g.columns});
        if (!large && next.objective >= subset.objective - 1e-6)
          next = completed(next, subset.chosen[i].candidate);
        if (next.objective >= subset.objective - 1e-6) continue;
        subset = next;
        moved = true;
        break;
      }
      if (moved) break;  // the members have another order now
    }
    if (!large) moved |= exchangeForFamilies(subset);
    refineAll(subset);
    if (!moved) return;
  }
}

}  // namespace mm
