#include "diagnosis/likely_shapes.h"

#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/parallel.h"

namespace mm {
namespace {

constexpr std::size_t kShapesTogether = 60;  // whose columns are made and compared at a time
constexpr std::size_t kListsOfOne = 2;       // causes, and curves over one variable
constexpr double kKept = 3e7;                // numbers of columns that are kept from look to look: 240 MB

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

/// What acts is given, as a block of its size.
LikelyShapes::Beside LikelyShapes::besideOf(const NoiseState& noise, const std::vector<Taken>& set) const {
  Beside beside{set, noise, q_.scatter, nullptr};
  for (const Taken& t : set) {
    const double size = sizeGrid()[t.size];
    beside.scatter.push_back({kept_.at(t.group).at(t.shape).columns, size, 0.0, true});
    beside.noise.scatter.push_back(size);
  }
  beside.whitened = whitenedAt(q_.rows, beside.scatter, beside.noise);
  return beside;
}

/// Causes that act are not asked.
std::vector<LikelyShapes::Asked> LikelyShapes::askPart(ListPart& part, const Beside& beside,
                                                       Wanted wanted) const {
  std::vector<Asked> asked;
  if (part.groups.empty()) return asked;
  part.problem.scatter = beside.scatter;
  const auto look = NoiseView(part.problem, beside.noise, beside.whitened).look({});
  const double most = *std::max_element(look->logOdds.begin(), look->logOdds.end());
  for (std::size_t g = 0; g < part.groups.size(); ++g) {
    const Group& group = part.groups[g];
    const Cause& cause = part.problem.causes[g];
    const auto isThis = [&](const Taken& t) { return t.group == part.first + g; };
    if (std::any_of(beside.set.begin(), beside.set.end(), isThis)) continue;
    Eigen::Index best = 0;
    const auto all = look->logWeights.middleRows(cause.first, cause.end - cause.first);
    all.rowwise().maxCoeff().maxCoeff(&best);
    for (int s = cause.first; s < cause.end; ++s) {
      const auto weights = look->logWeights.row(s).transpose();
      Asked one;
      one.logOdds = logSumExp(weights);
      one.likelier =
          one.logOdds - cause.logPriorOdds + group.shapes[static_cast<std::size_t>(s - cause.first)].price;
      if (wanted == Wanted::kLikelierThanBefore ? !(one.likelier > 0.0)
          : wanted == Wanted::kOneOfEach        ? s != cause.first + best
                                                : one.logOdds < most - kNear)
        continue;
      Eigen::Index size = 0;
      weights.maxCoeff(&size);
      const CauseShape& shape = part.problem.shapes[static_cast<std::size_t>(s)];
      one.taken = {part.first + g, s - cause.first, static_cast<int>(size)};
      one.kept.shape = group.shapes[static_cast<std::size_t>(s - cause.first)];
      if (!isKept(one.taken)) one.kept.columns = part.problem.columns.middleCols(shape.first, shape.count);
      asked.push_back(std::move(one));
    }
  }
  return asked;
}

std::vector<LikelyShapes::Asked> LikelyShapes::ask(const NoiseState& noise, const std::vector<Taken>& set,
                                                   Wanted wanted) {
  const Beside beside = besideOf(noise, set);
  std::vector<Asked> asked;
  std::size_t before = 0;
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    const QuestionList& list = lists_[l];
    std::vector<std::vector<Asked>> ofPart(made_[l].size());
    parallelFor(made_[l].size(), [&](std::size_t p) {
      CancelScope::check();
      ofPart[p] = askPart(made_[l][p], beside, wanted);
    });
    if (made_[l].empty())
      for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
        end = list.endOfPart(first, kShapesTogether);
        ListPart part = partOf(list, before, first, end);
        ofPart.push_back(askPart(part, beside, wanted));
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

bool LikelyShapes::isKept(const Taken& t) const {
  const auto group = kept_.find(t.group);
  return group != kept_.end() && group->second.count(t.shape) > 0;
}

/// @return whether any of them is new.
bool LikelyShapes::take(std::vector<Asked> asked) {
  bool any = false;
  for (Asked& a : asked) any |= kept_[a.taken.group].emplace(a.taken.shape, std::move(a.kept)).second;
  return any;
}

void LikelyShapes::weigh(const Eigen::VectorXd& variance) {
  for (Walk& w : walks_) {
    w.noise.variance = variance;
    w.noise = fitted(w.set, w.noise, NoiseTerms::kAsTheyAre);
  }
  const Walk& most = likeliestWalk();
  take(ask(most.noise, most.set, Wanted::kLikelierThanBefore));
  fill();
}

const LikelyShapes::Walk& LikelyShapes::likeliestWalk() const {
  std::size_t best = 0;
  double most = -1e300;
  for (std::size_t w = 0; w < walks_.size(); ++w) {
    const double density = densityOf(walks_[w]);
    if (density > most) most = density, best = w;
  }
  return walks_[best];
}

Explanation LikelyShapes::found() const {
  const Walk& most = likeliestWalk();
  return explanationOf(q_, problemOf(q_, q_.groups, statedFreedoms_), acting(most.set), most.noise);
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

NoiseState LikelyShapes::fitted(const std::vector<Taken>& set, const NoiseState& from,
                                NoiseTerms terms) const {
  ActingSet acting;
  const PosteriorProblem problem = problemBeside(set, acting);
  return fittedBeside(problem, acting, from, terms);
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

const NoiseState& LikelyShapes::noiseOf(const PosteriorSample& sample) {
  return sample.pool[static_cast<std::size_t>(sample.bestNoise)]->state();
}

std::vector<LikelyShapes::Taken> LikelyShapes::foundBy(const PosteriorSample& sample) const {
  std::vector<Taken> set;
  int shape = 0;
  for (const auto& [number, shapes] : kept_)
    for (const auto& [s, kept] : shapes) {
      for (const Acting& a : sample.best)
        if (a.shape == shape) set.push_back({number, s, a.size});
      ++shape;
    }
  return set;
}

/// A period or a time constant is asked at some values, and the data may know it much better than these lie
/// apart: what is between them would then have to be another cause.
bool LikelyShapes::takeRefined(const std::vector<Taken>& set, const NoiseState& noise) {
  constexpr double kAnother = 0.01;  // of a value: nearer is the same shape
  constexpr int kRefined = 1 << 20;  // numbers of these shapes, behind all that the lists have
  const Search search(q_);
  const auto evidence = search.evidenceAt(noiseOnly(noise));
  const PosteriorProblem problem = problemOf(q_, q_.groups, statedFreedoms_);
  bool any = false;
  for (const Member& m : membersOf(search, *evidence, problem, acting(set))) {
    const Shape& asked =
        q_.groups.groups[static_cast<std::size_t>(m.group)].shapes[static_cast<std::size_t>(m.shape)];
    bool another = false;
    for (std::size_t k = 0; k < m.nonlinear.size(); ++k)
      another |= std::abs(m.nonlinear[k] - asked.nonlinear[k]) > kAnother * std::abs(asked.nonlinear[k]);
    if (!another) continue;
    Kept refined{asked, *m.columns};
    refined.shape.nonlinear = m.nonlinear;
    refined.shape.count = static_cast<int>(m.columns->cols());
    std::map<int, Kept>& shapes = std::next(kept_.begin(), m.group)->second;
    shapes.emplace(std::max(kRefined, shapes.rbegin()->first + 1), std::move(refined));
    any = true;
  }
  return any;
}

bool LikelyShapes::extend(const PosteriorSample& sample, bool instead) {
  if (lists_.size() == kListsOfOne) {  // two variables at once, where what was found may be their shadow
    addList(QuestionList::pairs(space_));
  }
  const NoiseState& noise = noiseOf(sample);
  const std::vector<Taken> set = foundBy(sample);
  bool any = take(ask(noise, set, Wanted::kLikelierThanBefore));
  for (std::size_t j = 0; instead && j < set.size(); ++j) {
    std::vector<Taken> others = set;
    others.erase(others.begin() + static_cast<long>(j));
    any |= take(ask(noise, others, Wanted::kNearTheLikeliest));
  }
  if (instead) any |= takeTwoForOne({set, noise});
  fill();
  any |= takeRefined(set, noise);
  if (!any) return false;
  walks_.push_back({set, noise});
  fill();
  return true;
}

void LikelyShapes::appendTheRest(PosteriorAnswer& answer) {
  const NoiseState& noise = noiseOf(answer.sample);
  for (Asked& a : ask(noise, foundBy(answer.sample), Wanted::kOneOfEach)) {
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
