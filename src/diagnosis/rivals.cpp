// Which of several causes: those that act alike, those that a curve imitates, and near ones with a noise of
// their own.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/tiny.h"
#include "diagnosis/search.h"

namespace mm {

std::vector<Member> Search::beside(const Evidence& evidence, const std::vector<Member>& members,
                                   std::size_t j) const {
  const auto isCurve = [&](const Member& m) { return q_.groups.groups[m.group].profile; };
  std::vector<Member> others;
  for (std::size_t p = 0; p < members.size(); ++p) {
    if (p == j) continue;
    if (isCurve(members[p]) && !isCurve(members[j])) {
      std::vector<Member> rest;
      for (std::size_t k = 0; k < members.size(); ++k)
        if (k != j && k != p) rest.push_back(members[k]);
      const Evidence::Given given = evidence.given(rest);
      const auto explained = [&](const Member& m) {
        return -std::expm1(-2.0 * evidence.gainOf(given, rest, *m.columns).value / given.freedoms);
      };
      if (explained(members[j]) > kMostOfIt * explained(members[p])) continue;
    }
    others.push_back(members[p]);
  }
  return others;
}

bool Search::hasCurve(const Evidence& evidence, const std::vector<Member>& members, std::size_t j) const {
  return beside(evidence, members, j).size() + 1 < members.size();
}

Gain Search::commoner(const Gain& best, const std::vector<Gain>& gains,
                      const std::vector<Member>& there) const {
  constexpr double kByShape = 10.0;  // nats: what the freedom of a shape may cost where the noise is small
  if (best.group < 0) return best;
  if (q_.groups.groups[best.group].profile) {  // a cause with a name that explains most of it comes first
    const double freedoms =
        std::max<double>(1.0, q_.rows.length() - static_cast<double>(q_.rows.base.cols()));
    const auto explained = [&](const Gain& g) { return -std::expm1(-2.0 * g.value / freedoms); };
    Gain named;
    for (const Gain& g : gains)
      if (g.group >= 0 && !q_.groups.groups[g.group].profile && g.value > named.value && !isThere(there, g))
        named = g;
    return named.group >= 0 && explained(named) > kMostOfIt * explained(best) ? commoner(named, gains, there)
                                                                              : best;
  }
  const auto unusual = [&](const Gain& g) {
    return q_.groups.groups[g.group].shapes[g.shape].unusual(g.coefficient);
  };
  const auto isBefore = [&](const Gain& a, const Gain& b) {
    return std::pair(unusual(a), a.group) < std::pair(unusual(b), b.group);
  };
  Gain first = best;
  for (const Gain& g : gains)
    if (g.group >= 0 && isBefore(g, first) && !isThere(there, g) && g.value > best.value - kByShape &&
        actAlike(best.group, best.shape, g.group, g.shape))
      first = g;
  return first;
}

bool Search::actAlike(int group, int shape, int otherGroup, int otherShape) const {
  constexpr double kAlike = 0.9999;  // cosine of what is left of their columns
  const auto columnOf = [&](int g, int s) {
    const Shape& of = q_.groups.groups[g].shapes[s];
    Eigen::MatrixXd column(q_.groups.columns.rows(), of.main == 1 && of.mixed.empty() ? 1 : 0);
    if (column.cols() == 1) {
      column = q_.groups.columns.col(of.first);
      q_.space->project(column);
      column /= std::max(kTiny, column.norm());
    }
    return column;
  };
  const Eigen::MatrixXd own = columnOf(group, shape), other = columnOf(otherGroup, otherShape);
  return own.cols() == 1 && other.cols() == 1 && std::abs(own.col(0).dot(other.col(0))) > kAlike;
}

Explanation Search::settled(Explanation best) const {
  constexpr double kNear =
      20.0;  // nats at the noise of the member: fitted to the rival, it may make up for them
  constexpr int kMostNear = 3;
  constexpr double kBetter = 0.5;
  for (int round = 0; round < 3; ++round) {
    best.rivals.clear();
    Explanation better;
    better.worth = best.worth + kBetter;
    const auto evidence = evidenceAt(best);
    for (std::size_t j = 0; j < best.members.size(); ++j) {
      if (q_.groups.groups[best.members[j].group].profile || hasCurve(*evidence, best.members, j)) continue;
      std::vector<Member> others = best.members;
      others.erase(others.begin() + static_cast<long>(j));
      const Evidence::Given given = evidence->given(others);
      const double own = evidence->gainOf(given, others, *best.members[j].columns).value;
      int tried = 0;
      for (const Gain& g : evidence->gains(given)) {
        if (tried == kMostNear || g.group < 0 || g.value < own - kNear) break;
        if (q_.groups.groups[g.group].profile || g.group == best.members[j].group ||
            std::any_of(others.begin(), others.end(), [&](const Member& m) { return m.group == g.group; }) ||
            actAlike(best.members[j].group, best.members[j].shape, g.group, g.shape))
          continue;
        ++tried;
        std::vector<Member> members = best.members;
        members[j] = refined(*evidence, others, memberOf(g));
        Explanation trial = refitted(members, best, true);
        best.rivals.push_back({j, g.group, g.shape, best.worth - trial.worth});
        if (trial.worth > better.worth) better = std::move(trial);
      }
    }
    if (better.members.empty()) break;
    best = std::move(better);
  }
  return best;
}

Explanation Search::without(const Explanation& found, std::size_t member) const {
  std::vector<Member> others = found.members;
  others.erase(others.begin() + static_cast<long>(member));
  return refitted(others, found, true);
}

}  // namespace mm
