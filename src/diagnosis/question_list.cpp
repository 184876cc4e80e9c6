#include "diagnosis/question_list.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/parallel.h"
#include "diagnosis/fine_waves.h"
#include "diagnosis/structure.h"
#include "effects/inputs.h"
#include "effects/owned.h"
#include "effects/profile.h"
#include "effects/registry.h"

namespace mm {
namespace {

/// Weights of the members of a family that act together: the lowest two alike, the further ones less.
constexpr double kMixed[] = {1.0, 1.0, 0.7, 0.5, 0.4};
/// Shapes whose projection is one product: enough columns for it to be worth its packing, few enough to keep
/// all cores busy. Part of the layout of the work, so that the bits do not depend on the number of threads.
constexpr std::size_t kDraftsTogether = 24;

constexpr double kCurve = 0.05;  // how often a curve without a name is met, of a cause with one
/// How often a cause is met that began between two sessions, or is one stylus' alone, of one that always
/// acts.
constexpr double kOwned = 0.5;
/// Positions of a linear joint from which on a profile over it is asked with short bumps, too: fewer are met
/// by smooth ones.
constexpr int kPlacesOfRough = 16;

/// Positions of a joint from which on a size may follow a curve along it: fewer are met by a parabola.
constexpr int kPlacesOfCurve = 5;

/// Whether a session can show that an error changes within few positions of a joint.
bool changesWithinFewPlaces(const ShapeMaker& maker, const Effect& profile) {
  const std::vector<int> joints = profile.nature().mustMove;
  return joints.size() == 1 && maker.domain().joints[joints[0]].kind == JointKind::kLinear &&
         distinctPositions(maker.problem(), joints[0]) >= kPlacesOfRough;
}

/// Whether a session can show that the size of a cause changes along a joint otherwise than slowly.
bool variesAsACurve(const ShapeMaker& maker, const Effect& effect) {
  const std::vector<int>& joints = effect.nature().variesAlong;
  return std::any_of(joints.begin(), joints.end(),
                     [&](int joint) { return distinctPositions(maker.problem(), joint) >= kPlacesOfCurve; });
}

/// Whose a cause may be in several sessions, or of a probe with several styli, beside the machine's own in
/// all of them. What changes while the machine stands still is told by its time or temperature; a probe and
/// its holder have a growth of their own.
std::vector<Owner> ownersOf(const Effect& effect, const Domain& domain) {
  std::vector<Owner> owners = {{}};
  const Inputs inputs = inputsOf(effect, domain);
  if (domain.recordings > 1 && !inputs.dependsOnTime())
    for (int n = 2; n <= domain.recordings; ++n) owners.push_back({n, ""});
  if (domain.styli.size() > 1 && (effect.nature().stage == Stage::kProbe || inputs.dependsOnTemperature()))
    for (const std::string& stylus : domain.styli) owners.push_back({1, stylus});
  return owners;
}

/// Names that a formula may use for what varied in this session.
std::vector<std::string> variablesThatVary(const ResidualSpace& space) {
  std::vector<std::string> names;
  for (const Variable& v : variablesOf(space))
    if (!v.category && !v.symbol.empty()) names.push_back(v.symbol);
  return names;
}

}  // namespace

QuestionList QuestionList::causes(const ResidualSpace& space) {
  QuestionList out(space);
  const ShapeMaker maker(space);
  const Domain& domain = maker.domain();
  const Model& model = maker.problem().model();
  std::map<std::string, std::size_t> byKey;
  std::vector<Wanted> wanted;
  for (const EffectType& type : effectRegistry()) {
    if (type.composite || !type.candidates) continue;
    std::vector<EffectPtr> candidates;
    for (const EffectSpec& spec : type.candidates(domain)) {
      const EffectPtr law = type.create(spec, domain);
      for (const Owner& owner : ownersOf(*law, domain))
        candidates.push_back(owner.isMachine() ? law : ownedEffect(law, owner, domain));
    }
    for (const EffectPtr& effect : candidates) {
      const bool owned = &effect->law() != effect.get();
      std::vector<std::vector<double>> starts = effect->nature().searchStarts;
      const bool again = inModel(model, effect->spec());
      if (again && starts.empty()) continue;
      const std::string reason = maker.notTried(*effect);
      const std::string key = causeOf(*effect);
      auto [at, fresh] = byKey.try_emplace(key, out.groups_.size());
      if (fresh) {
        Group group;
        group.key = key;
        group.met = effect->nature().met * (owned ? kOwned : 1.0);
        group.dependsOnTime = inputsOf(*effect, domain).dependsOnTime();
        out.groups_.push_back(group);
        out.why_.push_back(reason);
        out.first_.push_back(effect);
        out.passedOver_.push_back(0);
      }
      if (!reason.empty()) continue;
      for (const ShapeFreedom& f : effect->freedom(domain)) {
        const std::string other = causeOf(*createEffect(f.spec, domain));
        if (other != key) out.groups_[at->second].parts[other] = f.share;
      }
      const LikelyWaves likely = likelyWaves(space, *effect);
      for (const double length : likely.lengths) starts.push_back({length});
      out.passedOver_[at->second] += likely.looked - static_cast<int>(likely.lengths.size());
      if (starts.empty()) starts.push_back({});
      for (std::vector<double>& start : starts) {
        // what is in the model already may be there once more with another shape, if a key can say it
        if (again && effect->shapedAs(start) == effect->spec()) continue;
        if (!start.empty() && !effect->mayBeClaimed(start)) continue;
        const bool curves = start.empty() && variesAsACurve(maker, *effect);
        wanted.push_back({at->second, effect, std::move(start)});
        if (curves) wanted.push_back({at->second, effect, {}, SizeAlong::kAsACurve});
      }
    }
  }
  std::stable_sort(wanted.begin(), wanted.end(),
                   [](const Wanted& a, const Wanted& b) { return a.group < b.group; });
  out.wanted_ = std::move(wanted);
  return out;
}

std::vector<QuestionList::Wanted> QuestionList::wantedOf(std::size_t first, std::size_t count) const {
  const auto before = [](const Wanted& w, std::size_t group) { return w.group < group; };
  const auto begin = std::lower_bound(wanted_.begin(), wanted_.end(), first, before);
  return {begin, std::lower_bound(begin, wanted_.end(), first + count, before)};
}

std::vector<MadeShape> QuestionList::shapesOf(const std::vector<Wanted>& wanted) const {
  const ShapeMaker maker(*space_);
  std::vector<MadeShape> made(wanted.size());
  parallelFor(partsOf(wanted.size(), kDraftsTogether), [&](std::size_t number) {
    const Part part = partOf(wanted.size(), kDraftsTogether, number);
    std::vector<DraftShape> drafts;
    for (std::size_t i = part.first; i < part.end; ++i) {
      CancelScope::check();
      drafts.push_back(maker.draft(wanted[i].effect, wanted[i].nonlinear, wanted[i].along));
    }
    std::vector<MadeShape> finished = maker.finished(drafts);
    std::move(finished.begin(), finished.end(), made.begin() + static_cast<long>(part.first));
  });
  return made;
}

/// Of degrees that are the same at the positions of this session only the lowest is asked.
void QuestionList::dropAliases(const std::vector<Wanted>& wanted, std::vector<MadeShape>& made) const {
  constexpr double kSame = 1e-6;                               // one minus the cosine of two columns
  std::vector<std::pair<std::size_t, Eigen::VectorXd>> asked;  // of the group that comes next
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!made[i].why.empty() || made[i].shape.main != 1 || !wanted[i].nonlinear.empty() ||
        wanted[i].along != SizeAlong::kSlowly)
      continue;
    if (!asked.empty() && wanted[asked.front().first].group != wanted[i].group) asked.clear();
    Eigen::MatrixXd column = made[i].columns.leftCols(1);
    space_->project(column);
    column.normalize();
    for (const auto& [other, of] : asked)
      if (1.0 - std::abs(of.dot(column.col(0))) < kSame)
        made[i].why = "at these positions it is the same as another shape of its cause";
    if (made[i].why.empty()) asked.emplace_back(i, column.col(0));
  }
}

std::vector<QuestionList::Mixed> QuestionList::mixedOf(const Groups& groups, std::size_t first,
                                                       const std::vector<Wanted>& wanted,
                                                       const std::vector<MadeShape>& made) {
  std::vector<Mixed> mixed;
  for (std::size_t g = 0; g < groups.groups.size(); ++g) {
    Mixed m{g, {}};
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (wanted[i].group == first + g && made[i].why.empty() && made[i].shape.main == 1 &&
          wanted[i].nonlinear.empty() && wanted[i].along == SizeAlong::kSlowly)
        m.members.push_back(i);
    if (!groups.groups[g].profile && m.members.size() > 1 && m.members.size() <= std::size(kMixed))
      mixed.push_back(m);
  }
  return mixed;
}

Groups QuestionList::made(std::size_t first, std::size_t count) const {
  Groups out;
  std::vector<std::string> why(why_.begin() + static_cast<long>(first),
                               why_.begin() + static_cast<long>(first + count));
  for (std::size_t g = first; g < first + count; ++g) out.groups.push_back(groups_[g]);
  const std::vector<Wanted> wanted = wantedOf(first, count);
  std::vector<MadeShape> made = shapesOf(wanted);
  dropAliases(wanted, made);
  const std::vector<Mixed> mixed = mixedOf(out, first, wanted, made);

  // side by side: each shape alone, then those of several members
  int total = 0;
  for (const MadeShape& m : made) total += m.why.empty() ? m.shape.count : 0;
  for (const Mixed& m : mixed) total += static_cast<int>(m.members.size());
  out.columns.resize(space_->length(), total);
  int at = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!made[i].why.empty()) {
      why[wanted[i].group - first] = made[i].why;
      continue;
    }
    made[i].shape.first = at;
    made[i].shape.curved = wanted[i].along == SizeAlong::kAsACurve;
    out.columns.middleCols(at, made[i].shape.count) = made[i].columns;
    at += made[i].shape.count;
    std::vector<Shape>& shapes = out.groups[wanted[i].group - first].shapes;
    shapes.push_back(made[i].shape);
    if (made[i].shape.main == made[i].shape.count || wanted[i].along == SizeAlong::kAsACurve) continue;
    shapes.push_back(made[i].shape);  // as likely as with its freedom: the law and nothing beside it
    shapes.back().count = shapes.back().main;
  }
  for (const Mixed& m : mixed) {
    Shape shape = made[m.members[0]].shape;
    shape.first = at;
    shape.count = shape.main = static_cast<int>(m.members.size());
    for (std::size_t k = 0; k < m.members.size(); ++k) {
      out.columns.col(at++) = kMixed[k] * made[m.members[k]].columns.col(0);
      shape.mixed.push_back(made[m.members[k]].shape.spec);
    }
    out.groups[m.group].shapes.push_back(shape);
  }
  dropEmpty(out, first, why);
  return out;
}

/// @param passedOver waves that were looked at, and are none of the shapes.
void QuestionList::setPrices(std::vector<Shape>& shapes, int passedOver) {
  std::vector<std::pair<EffectSpec, int>> ofEffect;  // its shapes; those of several members are one more
  const auto countOf = [&](const Shape& s) -> int& {
    const EffectSpec effect = s.mixed.empty() ? s.spec : EffectSpec("mixed");
    for (auto& [spec, count] : ofEffect)
      if (spec == effect) return count;
    return ofEffect.emplace_back(effect, 0).second;
  };
  for (const Shape& s : shapes)  // that a size may follow a curve, too, takes nothing from the usual shapes
    if (!s.curved) ++countOf(s);
  for (Shape& s : shapes) {
    const int looked = countOf(s) + (s.effect->nature().fineWaves.lengths.empty() ? 0 : passedOver);
    s.price = std::log(static_cast<double>(ofEffect.size())) + std::log(static_cast<double>(looked));
  }
}

void QuestionList::dropEmpty(Groups& out, std::size_t first, const std::vector<std::string>& why) const {
  std::vector<Group> kept;
  for (std::size_t g = 0; g < out.groups.size(); ++g) {
    const EffectPtr& effect = first_[first + g];
    setPrices(out.groups[g].shapes, passedOver_[first + g]);
    if (!out.groups[g].shapes.empty())
      kept.push_back(std::move(out.groups[g]));
    else if (!out.groups[g].profile && !why[g].empty() && &effect->law() == effect.get())
      out.notShown.push_back({effect->spec(), effect, why[g]});
  }
  out.groups = std::move(kept);
  for (const Group& g : out.groups) out.causes += !g.profile;
}

std::size_t QuestionList::endOfPart(std::size_t first, std::size_t shapes) const {
  const auto after = [](std::size_t group, const Wanted& w) { return group < w.group; };
  const auto begin = std::upper_bound(wanted_.begin(), wanted_.end(), first, after);
  if (wanted_.end() - begin <= static_cast<long>(shapes)) return size();
  return std::max(first + 1, begin[static_cast<long>(shapes)].group);
}

/// What a profile is of: a direction and one or two variables.
struct QuestionList::ProfileOf {
  std::string direction;
  std::vector<std::string> variables;
};

QuestionList QuestionList::of(const ResidualSpace& space, const std::vector<ProfileOf>& profiles) {
  QuestionList out(space);
  const ShapeMaker maker(space);
  std::map<std::string, bool> ofTime;  // a variable: it changes while the machine stands still
  for (const auto& [direction, variables] : profiles) {
    const auto make = [&, &along = direction](const std::vector<std::string>& of) {
      return createEffect(profileSpec(along, of), maker.domain());
    };
    const auto dependsOnTime = [&](const std::string& variable) {
      const auto known = ofTime.find(variable);
      if (known != ofTime.end()) return known->second;
      return ofTime[variable] = inputsOf(*make({variable}), maker.domain()).dependsOnTime();
    };
    EffectPtr effect;
    try {
      // two that change with time alone trace one line through their plane: what depends on both is a
      // function of time, and that is drift
      if (variables.size() == 2 && dependsOnTime(variables[0]) && dependsOnTime(variables[1])) continue;
      effect = make(variables);
    } catch (const InputError&) {
      continue;  // a variable that varied, but not enough for a curve
    }
    const auto same = [&](const EffectPtr& e) { return causeOf(*e) == causeOf(*effect); };
    const auto& model = maker.problem().model().effects();
    if (std::any_of(model.begin(), model.end(), same)) continue;  // it is there, whatever its size
    Group group;
    group.key = causeOf(*effect);
    group.profile = true;
    group.variables = static_cast<int>(variables.size());
    group.met = std::pow(kCurve, group.variables);
    group.dependsOnTime = std::any_of(variables.begin(), variables.end(), dependsOnTime);
    out.wanted_.push_back({out.groups_.size(), effect, {}});
    if (variables.size() == 1 && changesWithinFewPlaces(maker, *effect))
      out.wanted_.push_back(
          {out.groups_.size(), createEffect(roughProfileSpec(direction, variables[0]), maker.domain()), {}});
    out.groups_.push_back(std::move(group));
    out.first_.push_back(effect);
    out.passedOver_.push_back(0);
    out.why_.emplace_back();
  }
  return out;
}

QuestionList QuestionList::profiles(const ResidualSpace& space) {
  std::vector<ProfileOf> profiles;
  for (const std::string& direction : directionsOf(space).names)
    for (const std::string& variable : variablesThatVary(space))
      if (variable != "t")
        profiles.push_back({direction, {variable}});  // a course in time without a name is drift
  return of(space, profiles);
}

QuestionList QuestionList::pairs(const ResidualSpace& space) {
  std::vector<ProfileOf> profiles;
  const std::vector<std::string> names = variablesThatVary(space);
  for (const std::string& direction : directionsOf(space).names)
    for (std::size_t a = 0; a < names.size(); ++a)
      for (std::size_t b = a + 1; b < names.size(); ++b)
        profiles.push_back({direction, {names[a], names[b]}});
  return of(space, profiles);
}

}  // namespace mm
