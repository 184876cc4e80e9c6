#include "diagnosis/likely_shapes.h"

#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/parallel.h"

namespace mm {
namespace {

constexpr double kNear = 10.0;               // nats behind the likeliest: what is further behind is not drawn
constexpr int kMostSteps = 8;                // causes of a walk
constexpr std::size_t kShapesTogether = 60;  // whose columns are made and compared at a time
constexpr std::size_t kListsOfOne = 2;       // causes, and curves over one variable
constexpr double kSmallTerm = 0.4;           // ratio of a term of the noise for which a cause is tried
constexpr double kAlike = 0.3;               // share of what a term of the noise did that a cause must do
constexpr std::size_t kMostAlike = 8;        // causes that are tried for a term
constexpr double kWorthFitting = 40.0;       // nats behind before the noise is fitted again
constexpr double kKept = 3e7;                // numbers of columns that are kept from look to look: 240 MB

template <typename List>
auto likeliest(List& asked) {
  return std::max_element(asked.begin(), asked.end(),
                          [](const auto& a, const auto& b) { return a.logOdds < b.logOdds; });
}

}  // namespace

LikelyShapes::LikelyShapes(const ResidualSpace& space, Questions& questions, double statedFreedoms)
    : space_(space), q_(questions), statedFreedoms_(statedFreedoms) {
  addList(QuestionList::causes(space));
  addList(QuestionList::profiles(space));
}

void LikelyShapes::addList(QuestionList list) {
  std::size_t before = 0;
  for (const QuestionList& l : lists_) before += l.size();
  std::vector<ListPart> parts;
  double numbers = 0.0;
  for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
    end = list.endOfPart(first, kShapesTogether);
    ListPart part = partOf(list, before, first, end);
    numbers += static_cast<double>(part.problem.columns.size());
    if (numbers <= kKept) parts.push_back(std::move(part));
  }
  if (numbers > kKept) parts.clear();
  // how likely a cause is before the session depends on how many were asked that it can show
  if (lists_.empty()) {
    q_.asked = static_cast<int>(groups_.size());
    for (ListPart& part : parts)
      for (std::size_t g = 0; g < part.groups.size(); ++g)
        part.problem.causes[g].logPriorOdds = logPriorOddsOf(q_, part.groups[g]);
  }
  lists_.push_back(std::move(list));
  made_.push_back(std::move(parts));
}

LikelyShapes::ListPart LikelyShapes::partOf(const QuestionList& list, std::size_t before, std::size_t first,
                                            std::size_t end) {
  Groups groups = list.made(first, end - first);
  ListPart part;
  part.first = before + first;
  part.problem = problemOf(q_, groups, statedFreedoms_);
  for (std::size_t g = 0; g < groups.groups.size(); ++g) {
    Group& group = groups_[part.first + g];
    if (group.key.empty()) {  // not seen before
      group = groups.groups[g];
      group.shapes.clear();
      if (g == 0) notShown_.insert(notShown_.end(), groups.notShown.begin(), groups.notShown.end());
    }
  }
  part.groups = std::move(groups.groups);
  return part;
}

/// What acts is given, as a block of its size; causes that act are not asked.
std::vector<LikelyShapes::Asked> LikelyShapes::askPart(ListPart& part, const NoiseState& noise,
                                                       const std::vector<Taken>& beside,
                                                       Wanted wanted) const {
  std::vector<Asked> asked;
  if (part.groups.empty()) return asked;
  NoiseState state = noise;
  part.problem.scatter = q_.scatter;
  for (const Taken& t : beside) {
    const double size = sizeGrid()[t.size];
    part.problem.scatter.push_back({kept_.at(t.group).at(t.shape).columns, size, 0.0, true});
    state.scatter.push_back(size);
  }
  const Conditionals look = NoiseView(part.problem, state).look({});
  const double most = *std::max_element(look.logOdds.begin(), look.logOdds.end());
  for (std::size_t g = 0; g < part.groups.size(); ++g) {
    const Group& group = part.groups[g];
    const Cause& cause = part.problem.causes[g];
    if (std::any_of(beside.begin(), beside.end(), [&](const Taken& t) { return t.group == part.first + g; }))
      continue;
    Eigen::Index best = 0;
    const auto all = look.logWeights.middleRows(cause.first, cause.end - cause.first);
    all.rowwise().maxCoeff().maxCoeff(&best);
    for (int s = cause.first; s < cause.end; ++s) {
      const auto weights = look.logWeights.row(s).transpose();
      Asked one;
      one.logOdds = logSumExp(weights);
      one.likelier = one.logOdds - cause.logPriorOdds + group.priceOfShape();
      if (wanted == Wanted::kLikelierThanBefore ? !(one.likelier > 0.0)
          : wanted == Wanted::kOneOfEach        ? s != cause.first + best
                                                : one.logOdds < most - kNear)
        continue;
      Eigen::Index size = 0;
      weights.maxCoeff(&size);
      const CauseShape& shape = part.problem.shapes[static_cast<std::size_t>(s)];
      one.taken = {part.first + g, s - cause.first, static_cast<int>(size)};
      one.kept.shape = group.shapes[static_cast<std::size_t>(s - cause.first)];
      one.kept.columns = part.problem.columns.middleCols(shape.first, shape.count);
      asked.push_back(std::move(one));
    }
  }
  return asked;
}

std::vector<LikelyShapes::Asked> LikelyShapes::ask(const NoiseState& noise, const std::vector<Taken>& beside,
                                                   Wanted wanted) {
  std::vector<Asked> asked;
  std::size_t before = 0;
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    const QuestionList& list = lists_[l];
    std::vector<std::vector<Asked>> ofPart(made_[l].size());
    parallelFor(made_[l].size(), [&](std::size_t p) {
      CancelScope::check();
      ofPart[p] = askPart(made_[l][p], noise, beside, wanted);
    });
    if (made_[l].empty())
      for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
        end = list.endOfPart(first, kShapesTogether);
        ListPart part = partOf(list, before, first, end);
        ofPart.push_back(askPart(part, noise, beside, wanted));
      }
    for (std::vector<Asked>& part : ofPart) std::move(part.begin(), part.end(), std::back_inserter(asked));
    before += list.size();
  }
  if (wanted != Wanted::kNearTheLikeliest) return asked;
  double most = -1e300;
  for (const Asked& a : asked) most = std::max(most, a.logOdds);
  asked.erase(
      std::remove_if(asked.begin(), asked.end(), [&](const Asked& a) { return a.logOdds < most - kNear; }),
      asked.end());
  return asked;
}

/// @return whether any of them is new.
bool LikelyShapes::take(std::vector<Asked> asked) {
  bool any = false;
  for (Asked& a : asked) any |= kept_[a.taken.group].emplace(a.taken.shape, std::move(a.kept)).second;
  return any;
}

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
    while (exchange(walk));
    take(ask(walk.noise, walk.set, Wanted::kLikelierThanBefore));
    walks_.push_back(std::move(walk));
  }
  fill();
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
  Explanation at;
  at.noise.drift = walk.noise.drift;
  at.noise.variance = walk.noise.variance;
  at.scatter = walk.noise.scatter;
  for (const Taken& t : walk.set) {
    Member m;
    m.size = sizeGrid()[t.size];
    m.columns = std::make_shared<RowMatrix>(kept_.at(t.group).at(t.shape).columns);
    m.id = std::to_string(t.group) + "/" + std::to_string(t.shape);
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
      if (densityOf(other) < now - kWorthFitting) continue;
      other.noise = fitted(other.set, term.small);
      const double density = densityOf(other);
      if (density < now - kNear) continue;
      walks_.insert(walks_.begin(), other);  // its noise may be drawn, too
      if (density > most) most = density, best = std::move(other);
    }
  if (!(most > now)) return false;
  walk = std::move(best);
  return true;
}

void LikelyShapes::weigh(const Eigen::VectorXd& variance, const PosteriorAnswer& answer) {
  NoiseState noise = noiseOf(answer);
  noise.variance = variance;
  walks_ = {{foundBy(answer), noise}};
  walks_.front().noise = fitted(walks_.front().set, noise);
  take(ask(walks_.front().noise, walks_.front().set, Wanted::kLikelierThanBefore));
  fill();
}

/// A set alone, and what acts in that problem.
PosteriorProblem LikelyShapes::problemBeside(const std::vector<Taken>& set, ActingSet& acting) const {
  Groups groups;
  for (const Taken& t : set) {
    Groups one;
    one.groups.push_back(groups_.at(t.group));
    const Kept& kept = kept_.at(t.group).at(t.shape);
    one.groups[0].shapes = {kept.shape};
    one.groups[0].shapes[0].first = 0;
    one.columns = kept.columns;
    append(groups, std::move(one));
  }
  for (std::size_t k = 0; k < set.size(); ++k) acting.push_back({static_cast<int>(k), set[k].size});
  return problemOf(q_, groups, statedFreedoms_);
}

NoiseState LikelyShapes::fitted(const std::vector<Taken>& set, const NoiseState& from) const {
  ActingSet acting;
  const PosteriorProblem problem = problemBeside(set, acting);
  return fittedBeside(problem, acting, from);
}

double LikelyShapes::densityOf(const Walk& walk) const {
  ActingSet acting;
  const PosteriorProblem problem = problemBeside(walk.set, acting);
  return NoiseView(problem, walk.noise).logDensity(acting);
}

/// The questions are what is kept, in the order of the lists.
void LikelyShapes::fill() {
  Groups all;
  int columns = 0;
  for (const auto& [number, shapes] : kept_)
    for (const auto& [s, kept] : shapes) columns += static_cast<int>(kept.columns.cols());
  all.columns.resize(q_.rows.length(), columns);
  int at = 0;
  for (const auto& [number, shapes] : kept_) {
    Group group = groups_.at(number);
    for (const auto& [s, kept] : shapes) {
      group.shapes.push_back(kept.shape);
      group.shapes.back().first = at;
      all.columns.middleCols(at, kept.columns.cols()) = kept.columns;
      at += static_cast<int>(kept.columns.cols());
    }
    all.causes += !group.profile;
    all.groups.push_back(std::move(group));
  }
  all.notShown = notShown_;
  q_.groups = std::move(all);
}

/// As shapes of the problem that the questions are.
ActingSet LikelyShapes::acting(const std::vector<Taken>& set) const {
  ActingSet out;
  for (const Taken& t : set) {
    int shape = 0;
    for (const auto& [number, shapes] : kept_) {
      if (number == t.group) {
        for (const auto& [s, kept] : shapes) {
          if (s == t.shape) out.push_back({shape, t.size});
          ++shape;
        }
        break;
      }
      shape += static_cast<int>(shapes.size());
    }
  }
  std::sort(out.begin(), out.end(), [](const Acting& a, const Acting& b) { return a.shape < b.shape; });
  return out;
}

std::vector<PosteriorStart> LikelyShapes::starts() const {
  std::vector<PosteriorStart> out;
  for (const Walk& w : walks_) out.push_back({acting(w.set), w.noise});
  return out;
}

const NoiseState& LikelyShapes::noiseOf(const PosteriorAnswer& answer) {
  return answer.sample.pool[static_cast<std::size_t>(answer.sample.bestNoise)]->state();
}

std::vector<LikelyShapes::Taken> LikelyShapes::foundBy(const PosteriorAnswer& answer) const {
  std::vector<Taken> set;
  int shape = 0;
  for (const auto& [number, shapes] : kept_)
    for (const auto& [s, kept] : shapes) {
      for (const Acting& a : answer.sample.best)
        if (a.shape == shape) set.push_back({number, s, a.size});
      ++shape;
    }
  return set;
}

bool LikelyShapes::extend(const PosteriorAnswer& answer, bool instead) {
  if (lists_.size() == kListsOfOne) {  // two variables at once, where what was found may be their shadow
    addList(QuestionList::pairs(space_));
  }
  const NoiseState& noise = noiseOf(answer);
  const std::vector<Taken> set = foundBy(answer);
  bool any = take(ask(noise, set, Wanted::kLikelierThanBefore));
  for (std::size_t j = 0; instead && j < set.size(); ++j) {
    std::vector<Taken> others = set;
    others.erase(others.begin() + static_cast<long>(j));
    any |= take(ask(noise, others, Wanted::kNearTheLikeliest));
  }
  if (!any) return false;
  walks_.push_back({set, noise});
  fill();
  return true;
}

void LikelyShapes::appendTheRest(PosteriorAnswer& answer) {
  const NoiseState& noise = noiseOf(answer);
  for (Asked& a : ask(noise, foundBy(answer), Wanted::kOneOfEach)) {
    const Group& group = groups_.at(a.taken.group);
    if (group.profile || kept_.count(a.taken.group) > 0) continue;
    Groups one;
    one.groups.push_back(group);
    one.groups[0].shapes = {a.kept.shape};
    one.groups[0].shapes[0].first = 0;
    one.columns = std::move(a.kept.columns);
    append(q_.groups, std::move(one));
    ++q_.groups.causes;
    answer.rest.push_back(1.0 / (1.0 + std::exp(-a.logOdds)));
  }
}

}  // namespace mm
