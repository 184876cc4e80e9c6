#include "diagnosis/held_out.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "estimation/folds.h"

namespace mm {
namespace {

constexpr int kFolds = 5;
constexpr int kGap = 2;  // observations on either side that are neither fitted nor judged

}  // namespace

HeldOut::HeldOut(const Search& search, const Explanation& found) : search_(search), found_(found) {
  const Questions& q = search.questions();
  const ResidualSpace& space = *q.space;
  const Folds& blocks = space.folds();
  const int rows = space.rows();
  const auto observation = [&](int i) { return space.problem().rows()[space.used()[i]].observation; };
  const int folds = std::max(2, std::min(kFolds, blocks.blocks));
  folds_.resize(static_cast<std::size_t>(folds));
  for (int f = 0; f < folds; ++f) {
    Fold& fold = folds_[f];
    fold.held.assign(static_cast<std::size_t>(rows), 0);
    for (int i = 0; i < rows; ++i) fold.held[i] = blocks.blockOfRow[i] % folds == f;
    fold.unused = fold.held;
    for (int i = 0; i < rows; ++i)
      for (int step : {-1, 1})
        for (int j = i;
             !fold.held[i] && j >= 0 && j < rows && std::abs(observation(j) - observation(i)) <= kGap;
             j += step)
          if (fold.held[j]) fold.unused[i] = 1;
  }
  for (Fold& fold : folds_) {
    fold.own = determinedWithin(q.rows.base, fold.held, fold.unused);
    fold.evidence = search.evidenceAt(found, &fold.unused);
  }
}

Eigen::VectorXd HeldOut::errorsOf(const Fold& fold, const std::vector<Member>& members) const {
  const Questions& q = search_.questions();
  const Eigen::VectorXd expected = fold.evidence->fit(members).expected;
  std::vector<double> of;
  for (int i = 0; i < q.rows.rows(); ++i)
    if (fold.held[i]) of.push_back(q.rows.target[i] - expected[i]);
  Eigen::VectorXd left = Eigen::Map<Eigen::VectorXd>(of.data(), static_cast<long>(of.size()));
  return left - fold.own * (fold.own.transpose() * left).eval();
}

double HeldOut::rmsOf(const std::function<std::vector<Member>(const Fold&)>& members) const {
  double sum = 0.0;
  int n = 0;
  for (const Fold& fold : folds_) {
    const Eigen::VectorXd left = errorsOf(fold, members(fold));
    sum += left.squaredNorm();
    n += static_cast<int>(left.size() - fold.own.cols());
  }
  return n > 0 ? std::sqrt(sum / n) : 0.0;
}

double HeldOut::worthOf(const Member& member, const std::vector<Member>& beside) const {
  const std::vector<int>& blockOfRow = search_.questions().space->folds().blockOfRow;
  std::vector<Member> with = beside;
  with.push_back(member);
  double lower = 0.0;
  std::map<int, double> byChance;  // a block: what its errors have in common with what is predicted
  for (const Fold& fold : folds_) {
    const Eigen::VectorXd before = errorsOf(fold, beside), after = errorsOf(fold, with);
    lower += before.squaredNorm() - after.squaredNorm();
    int at = 0;
    for (std::size_t i = 0; i < fold.held.size(); ++i)
      if (fold.held[i]) byChance[blockOfRow[i]] += 2.0 * after[at] * (before[at] - after[at]), ++at;
  }
  double squares = 0.0;
  for (const auto& [block, value] : byChance) squares += value * value;
  return lower / std::sqrt(std::max(1e-300, squares));
}

double HeldOut::before() const { return withMembers({}); }

double HeldOut::all() const { return withMembers(found_.members); }

double HeldOut::with(std::size_t members) const {
  const auto count = static_cast<long>(std::min(members, found_.members.size()));
  return withMembers({found_.members.begin(), found_.members.begin() + count});
}

double HeldOut::withGroup(int group) const {
  return rmsOf([&](const Fold& fold) {
    const Gain gain = fold.evidence->gainOf(fold.evidence->given({}), group);
    std::vector<Member> one;
    if (gain.group >= 0 && gain.size > 0.0) one.push_back(search_.memberOf(gain));
    return one;
  });
}

double HeldOut::withMembers(const std::vector<Member>& members) const {
  return rmsOf([&](const Fold&) { return members; });
}

}  // namespace mm
