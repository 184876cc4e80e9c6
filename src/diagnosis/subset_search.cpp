#include "diagnosis/subset_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/fresh_basis.h"
#include "machine/cancel_scope.h"

namespace mm {
namespace {

std::vector<int> membersOf(const Subset& s) {
  std::vector<int> m;
  for (const Chosen& c : s.chosen) m.push_back(c.candidate);
  std::sort(m.begin(), m.end());
  return m;
}

constexpr double kNewCause =
    4.0;  // log of the odds against one more cause rather than one more shape of a known one

}  // namespace

bool Subset::contains(int candidate) const {
  return std::any_of(chosen.begin(), chosen.end(), [&](const Chosen& c) { return c.candidate == candidate; });
}

SubsetSearch::SubsetSearch(const ResidualSpace& space, const CandidateSet& set) : space_(space), set_(set) {
  variables_ = variablesOf(space);
  dof_ = std::max(1.0, static_cast<double>(space.length() - space.baseRank()));
  for (int i = 0; i < static_cast<int>(set.candidates.size()); ++i) {
    const Candidate& c = set.candidates[i];
    if (!c.tried || c.spec.find("degree") == nullptr) continue;
    const auto same = std::find_if(families_.begin(), families_.end(), [&](const Family& f) {
      return sameCause(set.candidates[f.candidates[0]].spec, c.spec);
    });
    if (same != families_.end())
      same->candidates.push_back(i);
    else
      families_.push_back({{i}, {}, {}});
  }
  for (Family& f : families_) {
    f.columns = Eigen::MatrixXd::Zero(space.length(), static_cast<Eigen::Index>(f.candidates.size()));
    for (std::size_t k = 0; k < f.candidates.size(); ++k) {
      const auto atom = std::find_if(set.atoms.begin(), set.atoms.end(),
                                     [&](const Atom& a) { return a.candidate == f.candidates[k]; });
      if (atom != set.atoms.end()) f.columns.col(static_cast<int>(k)) = set.columnsOf(*atom).col(0);
    }
    f.gram = f.columns.transpose() * f.columns;
  }
  for (const Atom& a : set.atoms) {
    const auto c = set.columns.middleCols(a.first, a.count);
    grams_.push_back(c.transpose() * c);
  }
}

double SubsetSearch::penaltyOf(const Subset& subset, int candidate) const {
  const Candidate& c = set_.candidates[candidate];
  const bool known = std::any_of(subset.chosen.begin(), subset.chosen.end(), [&](const Chosen& other) {
    return sameCause(set_.candidates[other.candidate].spec, c.spec);
  });
  return c.cost + (known ? 0.0 : kNewCause);
}

int SubsetSearch::causes(const Subset& subset) const {
  int count = 0;
  for (std::size_t i = 0; i < subset.chosen.size(); ++i) {
    bool first = true;
    for (std::size_t k = 0; k < i; ++k)
      first &= !sameCause(set_.candidates[subset.chosen[i].candidate].spec,
                          set_.candidates[subset.chosen[k].candidate].spec);
    count += first;
  }
  return count;
}

Subset SubsetSearch::empty() const {
  Subset s;
  s.basis.resize(space_.length(), 0);
  s.left = space_.target();
  s.rss = s.left.squaredNorm();
  s.objective = 0.5 * dof_ * std::log(std::max(s.rss, 1e-300) / dof_);
  return s;
}

Subset SubsetSearch::withColumns(const Subset& subset, const Eigen::MatrixXd& columns) const {
  CancelScope::check();
  Subset s = subset;
  const Eigen::MatrixXd fresh = freshBasis(subset.basis, columns);
  s.basis.resize(subset.basis.rows(), subset.basis.cols() + fresh.cols());
  s.basis << subset.basis, fresh;
  s.left = subset.left - fresh * (fresh.transpose() * subset.left);
  s.rss = s.left.squaredNorm();
  return s;
}

Subset SubsetSearch::extend(const Subset& subset, const Chosen& chosen) const {
  Subset s = withColumns(subset, chosen.columns);
  s.chosen.push_back(chosen);
  s.penalty = subset.penalty + penaltyOf(subset, chosen.candidate);
  s.objective = 0.5 * dof_ * std::log(std::max(s.rss, 1e-300) / dof_) + s.penalty;
  return s;
}

Subset SubsetSearch::without(const Subset& subset, std::size_t member) const {
  Subset s = empty();
  for (std::size_t i = 0; i < subset.chosen.size(); ++i)
    if (i != member) s = extend(s, subset.chosen[i]);
  return s;
}

Gain SubsetSearch::evaluate(const Subset& subset, int candidate, const std::vector<double>& nonlinear,
                            Eigen::MatrixXd columns) const {
  CancelScope::check();
  Gain g;
  g.candidate = candidate;
  g.nonlinear = nonlinear;
  const Eigen::MatrixXd fresh = freshBasis(subset.basis, columns);
  g.columns = std::move(columns);
  g.rank = static_cast<int>(fresh.cols());
  g.drop = (fresh.transpose() * subset.left).squaredNorm();
  if (!plausible(subset, candidate, g.columns)) g.drop = 0.0;
  const double rss = std::max(subset.rss - g.drop, 1e-300);
  g.objective = 0.5 * dof_ * std::log(rss / dof_) + subset.penalty + penaltyOf(subset, candidate);
  const int free = g.rank + set_.candidates[candidate].freeParameters -
                   static_cast<int>(set_.candidates[candidate].linear.size());
  const double rest = dof_ - subset.basis.cols() - g.rank;
  g.logP = g.rank > 0 && rest > 0 ? logPValueF(g.drop / free / (rss / rest), free, rest) : 0.0;
  return g;
}

Gain SubsetSearch::gainOf(const Subset& subset, int candidate, const std::vector<double>& nonlinear,
                          bool refine) const {
  Gain best = evaluate(subset, candidate, nonlinear, set_.columnsAt(space_, candidate, nonlinear));
  if (!refine || nonlinear.empty()) return best;
  // descent in one nonlinear parameter after the other, by golden section in the logarithm between the
  // neighbours
  const std::vector<std::vector<double>> starts = set_.candidates[candidate].effect->searchStarts();
  for (std::size_t k = 0; k < nonlinear.size(); ++k) {
    std::vector<double> values;
    for (const auto& s : starts) values.push_back(s[k]);
    std::sort(values.begin(), values.end());
    const double here = best.nonlinear[k];
    double low = here * 0.7, high = here * 1.4;
    for (double v : values) {
      if (v < here * (1 - 1e-9)) low = v;
      if (v > here * (1 + 1e-9)) {
        high = v;
        break;
      }
    }
    if (!(low > 0.0)) continue;
    constexpr double kGolden = 0.6180339887498949;
    double a = std::log(low), b = std::log(high);
    const auto at = [&](double u) {
      std::vector<double> p = best.nonlinear;
      p[k] = std::exp(u);
      return evaluate(subset, candidate, p, set_.columnsAt(space_, candidate, p));
    };
    Gain l = at(b - kGolden * (b - a)), r = at(a + kGolden * (b - a));
    for (int i = 0; i < 16; ++i) {
      if (l.drop > r.drop) {
        b = std::log(r.nonlinear[k]);
        r = l;
        l = at(b - kGolden * (b - a));
      } else {
        a = std::log(l.nonlinear[k]);
        l = r;
        r = at(a + kGolden * (b - a));
      }
    }
    if (l.drop > best.drop) best = l;
    if (r.drop > best.drop) best = r;
  }
  return best;
}

std::vector<Gain> SubsetSearch::bestGains(const Subset& subset, int count, bool refine) const {
  const Eigen::MatrixXd inBasis = subset.basis.transpose() * set_.columns;
  const Eigen::VectorXd score = set_.columns.transpose() * subset.left;
  struct Quick {
    double objective;
    int atom;
  };
  std::map<int, Quick> best;  // candidate -> best atom
  for (std::size_t i = 0; i < set_.atoms.size(); ++i) {
    const Atom& a = set_.atoms[i];
    if (subset.contains(a.candidate)) continue;
    double drop = 0.0;
    if (a.count == 1) {
      const double g = grams_[i](0, 0) - inBasis.col(a.first).squaredNorm();
      if (g > kDependent) drop = score[a.first] * score[a.first] / g;
    } else {
      const auto w = inBasis.middleCols(a.first, a.count);
      const Eigen::MatrixXd g = grams_[i] - w.transpose() * w;
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(g);
      const Eigen::VectorXd s = eigen.eigenvectors().transpose() * score.segment(a.first, a.count);
      for (int k = 0; k < a.count; ++k)
        if (eigen.eigenvalues()[k] > kDependent) drop += s[k] * s[k] / eigen.eigenvalues()[k];
    }
    const double objective = 0.5 * dof_ * std::log(std::max(subset.rss - drop, 1e-300) / dof_) +
                             subset.penalty + penaltyOf(subset, a.candidate);
    auto [it, fresh] = best.try_emplace(a.candidate, Quick{objective, static_cast<int>(i)});
    if (!fresh && objective < it->second.objective) it->second = {objective, static_cast<int>(i)};
  }
  std::vector<Quick> order;
  for (const auto& [candidate, quick] : best) order.push_back(quick);
  std::sort(order.begin(), order.end(),
            [](const Quick& x, const Quick& y) { return x.objective < y.objective; });
  std::vector<Gain> gains;
  const std::size_t looked =
      std::min(order.size(), static_cast<std::size_t>(refine ? count + count / 2 + 2 : count));
  for (std::size_t i = 0; i < looked; ++i) {
    const Atom& a = set_.atoms[order[i].atom];
    if (refine && !a.nonlinear.empty())
      gains.push_back(gainOf(subset, a.candidate, a.nonlinear, true));
    else
      gains.push_back(evaluate(subset, a.candidate, a.nonlinear, set_.columnsOf(a)));
  }
  std::stable_sort(gains.begin(), gains.end(),
                   [](const Gain& x, const Gain& y) { return x.objective < y.objective; });
  if (static_cast<int>(gains.size()) > count) gains.resize(count);
  return gains;
}

double SubsetSearch::correctedLogP(const Gain& gain) const {
  return std::min(0.0, gain.logP + set_.logTried);
}

bool SubsetSearch::significant(const Gain& gain) const {
  return gain.rank > 0 && correctedLogP(gain) < std::log(significance);
}

void SubsetSearch::prune(Subset& subset) const {
  for (;;) {  // of the members that do not count beside the others, the smallest goes first
    double smallest = 1e300;
    std::size_t goes = subset.chosen.size();
    if (cancelling(subset, goes)) {
      subset = without(subset, goes);
      continue;
    }
    for (std::size_t i = 0; i < subset.chosen.size(); ++i) {
      const Subset rest = without(subset, i);
      const Gain g =
          evaluate(rest, subset.chosen[i].candidate, subset.chosen[i].nonlinear, subset.chosen[i].columns);
      if ((!significant(g) || g.objective >= rest.objective || !standsAlone(rest, g)) && g.drop < smallest) {
        smallest = g.drop;
        goes = i;
      }
    }
    if (goes == subset.chosen.size()) return;
    subset = without(subset, goes);
  }
}

Subset SubsetSearch::run() const {
  const bool large = space_.length() > kLargeSession;
  const std::size_t width = large ? 2 : 5;
  const int branches = large ? 3 : 6;
  std::vector<Subset> beam{empty()};
  Subset best = beam[0];
  for (int level = 0; level < largest; ++level) {
    std::map<std::vector<int>, Subset> next;
    for (const Subset& s : beam) {
      if (cancelled && cancelled()) return best;
      for (const Gain& g : bestGains(s, branches, true)) {
        if (!significant(g) || g.objective >= s.objective || !standsAlone(s, g)) continue;
        Subset grown = extend(s, {g.candidate, g.nonlinear, g.columns});
        auto [it, fresh] = next.try_emplace(membersOf(grown), grown);
        if (!fresh && grown.objective < it->second.objective) it->second = grown;
      }
    }
    if (next.empty()) break;
    beam.clear();
    for (auto& [key, s] : next) beam.push_back(std::move(s));
    std::stable_sort(beam.begin(), beam.end(),
                     [](const Subset& x, const Subset& y) { return x.objective < y.objective; });
    if (beam.size() > width) beam.resize(width);
    if (beam[0].objective < best.objective) best = beam[0];
  }
  for (const Family& family : families_) {  // shapes of which each alone says little
    if (objectiveWith(best, family) >= best.objective - kNewCause) continue;
    Subset grown = withFamily(best, family);
    prune(grown);
    if (grown.objective < best.objective) best = grown;
  }
  exchange(best);
  prune(best);
  for (int again = 0; again < 3; ++again) {  // room may have been made for another
    const std::vector<Gain> more = bestGains(best, 1, true);
    if (more.empty() || !significant(more[0]) || more[0].objective >= best.objective ||
        !standsAlone(best, more[0]))
      break;
    best = extend(best, {more[0].candidate, more[0].nonlinear, more[0].columns});
    exchange(best);
    prune(best);
  }
  // in the order of what each explains beside those before it: the error falls as fast as it can
  Subset sorted = empty();
  std::vector<Chosen> left = best.chosen;
  while (!left.empty()) {
    std::size_t first = 0;
    Subset next = extend(sorted, left[0]);
    for (std::size_t i = 1; i < left.size(); ++i) {
      Subset other = extend(sorted, left[i]);
      if (other.rss < next.rss) next = std::move(other), first = i;
    }
    sorted = std::move(next);
    left.erase(left.begin() + static_cast<long>(first));
  }
  return sorted;
}

}  // namespace mm
