// How likely shapes are found: the likeliest cause is taken up again and again, and for what the noise then
// does, causes are tried.
#include <algorithm>
#include <cmath>
#include <set>

#include "base/erase_if.h"
#include "diagnosis/likely_shapes.h"

namespace mm {
namespace {

constexpr int kMostSteps = 8;       // causes of a walk
constexpr double kSmallTerm = 0.4;  // ratio of a term of the noise for which a cause is tried
constexpr double kAlike =
    0.3;  // share of what a term of the noise or a cause did that one in its place must do
constexpr std::size_t kMostAlike = 4;  // causes that are tried for a term
constexpr std::size_t kMostFirst = 4;  // causes that are tried as the first of two for one
// nats behind, before the noise is fitted again; and with the sizes of its terms fitted, before all of it is
constexpr double kWorthSizing = 40.0, kWorthFitting = 20.0;

template <typename List>
auto likeliest(List& asked) {
  return std::max_element(asked.begin(), asked.end(),
                          [](const auto& a, const auto& b) { return a.logOdds < b.logOdds; });
}

}  // namespace

void LikelyShapes::walk(const Eigen::VectorXd& variance) {
  walks_.clear();
  const PosteriorProblem bare = problemOf(q_, {}, statedFreedoms_);
  std::vector<NoiseState> plain = plainStates(bare, variance);
  const NoiseState* densest = &plain.front();
  double most = -1e300;
  for (const NoiseState& s : plain) {
    const double density = NoiseView(bare, s).logDensity({});
    if (density > most) most = density, densest = &s;
  }
  for (const NoiseState& start : {plain.front(), fitted({}, *densest)}) {
    Walk walk{{}, start};
    do grow(walk);
    while (!endsLikeAnother(walk) && exchange(walk));
    take(ask(walk.noise, walk.set, Wanted::kLikelierThanBefore));
    walks_.push_back(std::move(walk));
  }
  fill();
}

bool LikelyShapes::endsLikeAnother(const Walk& walk) const {
  const auto groupsOf = [](const Walk& w) {
    std::set<std::size_t> groups;
    for (const Taken& t : w.set) groups.insert(t.group);
    return groups;
  };
  return std::any_of(walks_.begin(), walks_.end(),
                     [&](const Walk& other) { return groupsOf(other) == groupsOf(walk); });
}

void LikelyShapes::grow(Walk& walk) {
  while (static_cast<int>(walk.set.size()) < kMostSteps) {
    std::vector<Asked> asked = ask(walk.noise, walk.set, Wanted::kNearTheLikeliest);
    const auto best = likeliest(asked);
    if (best == asked.end() || !(best->logOdds > 0.0)) break;
    walk.set.push_back(best->taken);
    take(std::move(asked));
    walk.noise = fitted(walk.set, walk.noise);
  }
}

std::vector<LikelyShapes::Term> LikelyShapes::termsOf(const Walk& walk) const {
  const Questions rows = rowsOf(q_);
  Explanation at = noiseOnly(walk.noise);
  for (const Taken& t : walk.set) {
    Member m;
    m.size = sizeGrid()[t.size];
    m.columns = std::make_shared<RowMatrix>(kept_.at(t.group).at(t.shape).columns);
    at.members.push_back(std::move(m));
  }
  const auto evidence = Search(rows).evidenceAt(at);
  const int n = q_.rows.rows();
  const Eigen::VectorXd left = (q_.rows.target - evidence->fit(at.members).withoutDrift).head(n);
  Eigen::VectorXd weighed = Eigen::VectorXd::Zero(q_.rows.length());
  weighed.head(n) = (left - evidence->whitener().driftIn(left)).cwiseQuotient(walk.noise.variance);
  std::vector<Term> terms;
  for (std::size_t b = 0; b < walk.noise.scatter.size(); ++b) {
    const double ratio = walk.noise.scatter[b];
    if (q_.scatter[b].fixed || !(ratio > kSmallTerm)) continue;
    const RowMatrix& columns = q_.scatter[b].columns;
    terms.push_back({walk.noise, ratio * ratio * (columns * (columns.transpose() * weighed))});
    terms.back().small.scatter[b] = kSmallTerm;
  }
  const Eigen::MatrixXd drift = evidence->whitener().driftByTerm(left);
  for (std::size_t k = 0; k < walk.noise.drift.size(); ++k) {
    if (!(walk.noise.drift[k].ratio > kSmallTerm)) continue;
    terms.push_back({walk.noise, Eigen::VectorXd::Zero(q_.rows.length())});
    terms.back().did.head(n) = drift.col(static_cast<long>(k));
    terms.back().small.drift[k].ratio = kSmallTerm;
  }
  for (Term& t : terms) {
    Eigen::MatrixXd one = t.did;
    space_.project(one);
    t.did = one;
  }
  return terms;
}

std::vector<LikelyShapes::Asked> LikelyShapes::alike(const Eigen::VectorXd& did) const {
  std::vector<Asked> found;  // `likelier`: share of what was done
  for (const ListPart& part : made_.front()) {
    const Eigen::VectorXd products = part.problem.columns.transpose() * did;
    for (std::size_t g = 0; g < part.groups.size(); ++g) {
      Asked best;
      for (std::size_t s = 0; s < part.groups[g].shapes.size(); ++s) {
        const int at = part.problem.causes[g].first + static_cast<int>(s);
        const CauseShape& columns = part.problem.shapes[static_cast<std::size_t>(at)];
        const Shape& shape = part.groups[g].shapes[s];
        const double square = products.segment(columns.first, shape.main).squaredNorm();
        const double share = square / (space_.rows() * did.squaredNorm());
        if (!(share > std::max(kAlike, best.likelier))) continue;
        best.likelier = share;
        Eigen::Index size = 0;
        (sizeGrid() - std::sqrt(square) / space_.rows()).abs().minCoeff(&size);
        best.taken = {part.first + g, static_cast<int>(s), static_cast<int>(size)};
        best.kept = {shape, part.problem.columns.middleCols(columns.first, columns.count)};
      }
      if (best.likelier > 0.0) found.push_back(std::move(best));
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Asked& a, const Asked& b) { return a.likelier > b.likelier; });
  if (found.size() > kMostAlike) found.resize(kMostAlike);
  return found;
}

bool LikelyShapes::exchange(Walk& walk) {
  if (static_cast<int>(walk.set.size()) >= kMostSteps) return false;
  const double now = densityOf(walk);
  Walk best = walk;
  double most = now;
  for (const Term& term : termsOf(walk))
    for (Asked& one : alike(term.did)) {
      if (std::any_of(walk.set.begin(), walk.set.end(),
                      [&](const Taken& t) { return t.group == one.taken.group; }))
        continue;
      Walk other = {walk.set, term.small};
      other.set.push_back(one.taken);
      kept_[one.taken.group].emplace(one.taken.shape, std::move(one.kept));
      if (densityOf(other) < now - kWorthSizing) continue;
      other.noise = fitted(other.set, term.small, NoiseTerms::kAsTheyAre);
      if (densityOf(other) < now - kWorthFitting) continue;
      other.noise = fitted(other.set, other.noise);
      const double density = densityOf(other);
      if (density < now - kNear) continue;
      walks_.insert(walks_.begin(), other);  // its noise may be drawn, too
      if (density > most) most = density, best = std::move(other);
    }
  if (!(most > now)) return false;
  walk = std::move(best);
  return true;
}

std::vector<LikelyShapes::Asked> LikelyShapes::askBeside(const Walk& walk, const Asked& one) {
  Walk with = walk;
  with.set.push_back(one.taken);
  std::map<int, Kept>& shapes = kept_[one.taken.group];
  const bool isNew = shapes.emplace(one.taken.shape, one.kept).second;
  std::vector<Asked> asked = ask(with.noise, with.set, Wanted::kNearTheLikeliest);
  const double density = densityOf(with);
  for (Asked& a : asked) a.logOdds += density;
  if (isNew) shapes.erase(one.taken.shape);
  if (shapes.empty()) kept_.erase(one.taken.group);
  return asked;
}

bool LikelyShapes::takeTwoForOne(const Walk& found) {
  const double density = densityOf(found), least = density - kNear;
  std::vector<Asked> pairs;
  for (std::size_t j = 0; j < found.set.size(); ++j) {
    Walk others = found;
    others.set.erase(others.set.begin() + static_cast<long>(j));
    const auto keepOthers = [&](std::vector<Asked>& of) {
      const auto isSame = [&](const Asked& a) {
        return a.taken.group == found.set[j].group || groups_.at(a.taken.group).profile;
      };
      eraseIf(of, isSame);
    };
    const double worth = density - densityOf(others);
    std::vector<Asked> firsts = ask(found.noise, others.set, Wanted::kOneOfEach);
    keepOthers(firsts);
    const auto doesLittle = [&](const Asked& a) { return a.likelier < kAlike * worth; };
    eraseIf(firsts, doesLittle);
    std::stable_sort(firsts.begin(), firsts.end(),
                     [](const Asked& a, const Asked& b) { return a.logOdds > b.logOdds; });
    if (firsts.size() > kMostFirst) firsts.resize(kMostFirst);
    for (const Asked& first : firsts) {
      std::vector<Asked> seconds = askBeside(others, first);
      keepOthers(seconds);
      const auto second = likeliest(seconds);
      if (second == seconds.end() || second->logOdds < least - kWorthFitting) continue;
      // alone the first may have done some of the other's part: which of its shapes is it beside that one?
      std::vector<Asked> again = askBeside(others, *second);
      keepOthers(again);
      const auto partner = likeliest(again);
      if (partner == again.end() || partner->logOdds < least) continue;
      Walk both = others;
      both.set.push_back(second->taken);
      both.set.push_back(partner->taken);
      if (endsLikeAnother(both)) continue;
      walks_.push_back(std::move(both));  // a sample may begin there
      pairs.push_back(*second);
      pairs.push_back(*partner);
    }
  }
  const bool any = !pairs.empty();
  take(std::move(pairs));
  return any;
}

}  // namespace mm
