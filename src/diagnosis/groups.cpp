#include "diagnosis/groups.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/two_threads.h"
#include "diagnosis/structure.h"
#include "effects/inputs.h"
#include "effects/linearity.h"
#include "effects/profile.h"
#include "effects/registry.h"

namespace mm {
namespace {

/// Less than this share of a column is left by the model's unknowns: it is rounding, or would have to be
/// enormous.
constexpr double kSeen = 1e-3;
/// Weights of the members of a family that act together: the lowest two alike, the further ones less.
constexpr double kMixed[] = {1.0, 1.0, 0.7, 0.5, 0.4};

int distinctPositions(const Problem& problem, int joint) {
  std::vector<double> q;
  for (std::size_t o = 0; o < problem.session().observations.size(); ++o)
    q.push_back(problem.state(static_cast<int>(o)).position[joint]);
  std::sort(q.begin(), q.end());
  const double apart = 1e-4 * std::max(q.back() - q.front(), 1e-9);
  int count = 1;
  for (std::size_t i = 1; i < q.size(); ++i) count += q[i] - q[i - 1] > apart;
  return count;
}

/// Columns of one shape as its effects give them, before anything is known of what the model's unknowns
/// leave.
struct Draft {
  struct Part {
    int first, count;
    double share;
  };
  Shape shape;
  std::vector<Part> parts;  // the first has the main columns
  RowMatrix raw;            // length x all
  std::string why;          // not empty: it cannot be shown
};

struct Made {
  Shape shape;
  RowMatrix columns;
  std::string why;
};

class Maker {
 public:
  explicit Maker(const ResidualSpace& space)
      : space_(space), problem_(space.problem()), domain_(problem_.model().domain()) {}

  /// Why the session cannot show an effect, for reasons that need no columns; empty: it may.
  std::string notTried(const Effect& effect) const {
    for (const int joint : effect.mustMove())
      if (!(domain_.upper[joint] - domain_.lower[joint] > 1e-9))
        return domain_.joints[joint].name + " never moved";
    if (effect.positionsNeeded() > 0)
      for (const int joint : effect.mustMove())
        if (distinctPositions(problem_, joint) < effect.positionsNeeded())
          return "too few distinct positions of " + domain_.joints[joint].name + " to tell a period";
    return "";
  }

  Draft draft(const EffectPtr& effect, const std::vector<double>& nonlinear) const {
    Draft d;
    d.shape.spec = effect->spec();
    d.shape.effect = effect;
    d.shape.nonlinear = nonlinear;
    std::vector<RowMatrix> columns;
    int count = 0;
    const auto take = [&](RowMatrix part, double share) {
      d.parts.push_back({count, static_cast<int>(part.cols()), share});
      count += static_cast<int>(part.cols());
      columns.push_back(std::move(part));
    };
    take(linearColumns(*effect, nonlinear, d.why), 1.0);
    if (!d.why.empty()) return d;
    const auto beside = [&](const Effect& other, const std::vector<double>& at, double share) {
      std::string why;
      RowMatrix part = linearColumns(other, at, why);
      if (why.empty()) take(std::move(part), share);
    };
    for (const ShapeFreedom& f : effect->freedom(domain_))
      beside(*createEffect(f.spec, domain_), {}, f.share);
    for (const Effect::NonlinearFreedom& f : effect->freedomBeside(nonlinear))
      beside(*effect, f.nonlinear, f.share);
    for (const int joint : effect->variesAlong(domain_)) {
      RowMatrix varied = columns.front();
      varyAlong(problem_, space_.used(), joint, varied);
      take(std::move(varied), kVariation);
    }
    d.raw.resize(space_.length(), count);
    for (std::size_t k = 0; k < columns.size(); ++k)
      d.raw.middleCols(d.parts[k].first, d.parts[k].count) = columns[k];
    return d;
  }

  /// @param left norm of what the model's unknowns leave, a column of the draft.
  Made finish(const Draft& draft, const Eigen::VectorXd& left) const {
    Made made;
    made.shape = draft.shape;
    made.columns.resize(space_.length(), draft.raw.cols());
    Eigen::VectorXd after(draft.raw.cols());  // left of the columns as they are kept
    int at = 0;
    for (const Draft::Part& part : draft.parts) {
      const auto raw = draft.raw.middleCols(part.first, part.count);
      const Eigen::VectorXd rest = left.segment(part.first, part.count);
      const double scale = scaleOf(raw, rest, made.why);
      if (!made.why.empty()) {
        if (at == 0) return made;
        made.why.clear();
        continue;
      }
      made.columns.middleCols(at, part.count) = part.share * scale * raw;
      after.segment(at, part.count) = part.share * scale * rest;
      at += part.count;
    }
    made.columns.conservativeResize(Eigen::NoChange, at);
    made.shape.count = at;
    made.shape.main = draft.parts.front().count;
    weightByPriors(*draft.shape.effect, after.head(at), made);
    return made;
  }

  const Domain& domain() const { return domain_; }
  const Problem& problem() const { return problem_; }
  const ResidualSpace& space() const { return space_; }

 private:
  /// Columns of the linear parameters, whitened. @param why not empty on return: an input is missing.
  RowMatrix linearColumns(const Effect& effect, const std::vector<double>& nonlinear,
                          std::string& why) const {
    int missing = 0;
    const Eigen::MatrixXd all = space_.columns(effect, startsAt(effect, nonlinear), &missing);
    if (10 * missing > space_.rows()) {
      why = "an input is not known for " + std::to_string(missing) + " of " + std::to_string(space_.rows()) +
            " residuals";
      return {};
    }
    const std::vector<int> linear = linearParameters(effect);
    RowMatrix raw(all.rows(), linear.size());
    for (std::size_t k = 0; k < linear.size(); ++k) raw.col(static_cast<int>(k)) = all.col(linear[k]);
    return raw;
  }

  /// What gives the largest column a unit root mean square after projection; the others keep their
  /// proportion: two phases of a wave have one size. @param why not empty on return: nothing of it is seen.
  double scaleOf(const Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>& raw, const Eigen::VectorXd& left,
                 std::string& why) const {
    const Eigen::VectorXd norms = raw.colwise().norm();
    if (!(norms.norm() > 0.0)) {
      why = "nothing in this session excites it";
      return 0.0;
    }
    double largest = 0.0;
    for (int k = 0; k < norms.size(); ++k)
      if (left[k] > kSeen * norms[k]) largest = std::max(largest, left[k]);
    if (!(largest > 0.0)) {
      why = "the model's other unknowns absorb it completely";
      return 0.0;
    }
    return std::sqrt(static_cast<double>(std::max(1, space_.rows()))) / largest;
  }

  /// What is drawn with a prior (a profile's coefficients) has weights of its own.
  void weightByPriors(const Effect& effect, Eigen::VectorXd left, Made& made) const {
    const std::vector<int> linear = linearParameters(effect);
    const auto weightOf = [&](int k) {
      const Parameter& p = effect.parameters()[linear[static_cast<std::size_t>(k)]];
      return p.priorStd / p.scale;
    };
    double widest = 0.0;
    for (int k = 0; k < static_cast<int>(linear.size()); ++k) widest = std::max(widest, weightOf(k));
    if (!(widest > 0.0)) return;
    for (int k = 0; k < static_cast<int>(linear.size()); ++k) {
      made.columns.col(k) *= weightOf(k) / widest;
      left[k] *= weightOf(k) / widest;
    }
    if (left.norm() > 0.0)
      made.columns *= std::sqrt(static_cast<double>(space_.rows())) / left.norm();
    else
      made.why = "the model's other unknowns absorb it completely";
  }

  const ResidualSpace& space_;
  const Problem& problem_;
  const Domain& domain_;
};

/// Finishes drafts together: what the model's unknowns leave is one product for all of their columns.
std::vector<Made> finishAll(const Maker& maker, const std::vector<Draft>& drafts) {
  int columns = 0;
  for (const Draft& d : drafts) columns += static_cast<int>(d.raw.cols());
  RowMatrix together(maker.space().length(), columns);
  int at = 0;
  for (const Draft& d : drafts) {
    if (d.raw.cols() > 0) together.middleCols(at, d.raw.cols()) = d.raw;
    at += static_cast<int>(d.raw.cols());
  }
  const Eigen::VectorXd left = maker.space().leftOf(together);
  std::vector<Made> made(drafts.size());
  at = 0;
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    const int count = static_cast<int>(drafts[i].raw.cols());
    if (drafts[i].why.empty())
      made[i] = maker.finish(drafts[i], left.segment(at, count));
    else
      made[i].why = drafts[i].why;
    at += count;
  }
  return made;
}

}  // namespace

bool inModel(const Model& model, const EffectSpec& spec) {
  return std::any_of(model.effects().begin(), model.effects().end(),
                     [&](const EffectPtr& e) { return e->spec() == spec; });
}

void varyAlong(const Problem& problem, const std::vector<int>& rows, int joint, RowMatrix& columns) {
  const Domain& domain = problem.model().domain();
  const double range = domain.upper[joint] - domain.lower[joint];
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double q = problem.state(problem.rows()[rows[i]].observation).position[joint];
    columns.row(static_cast<int>(i)) *=
        range > 0.0 ? (2.0 * q - domain.upper[joint] - domain.lower[joint]) / range : 0.0;
  }
}

std::string causeOf(const Effect& effect) {
  const std::vector<std::string> shape = effect.shapeKeys();
  std::string key = effect.spec().type;
  for (const auto& [name, value] : effect.spec().keys) {
    if (std::find(shape.begin(), shape.end(), name) != shape.end()) continue;
    key += " " + name;
    for (const std::string& item : value.items) key += " " + item;
  }
  return key;
}

QuestionList QuestionList::causes(const ResidualSpace& space) {
  QuestionList out(space);
  const Maker maker(space);
  const Domain& domain = maker.domain();
  const Model& model = maker.problem().model();
  std::map<std::string, std::size_t> byKey;
  std::vector<Wanted> wanted;
  for (const EffectType& type : effectRegistry()) {
    if (type.composite || !type.candidates) continue;
    for (const EffectSpec& spec : type.candidates(domain)) {
      const EffectPtr effect = type.create(spec, domain);
      std::vector<std::vector<double>> starts = effect->searchStarts();
      const bool again = inModel(model, effect->spec());
      if (again && starts.empty()) continue;
      const std::string reason = maker.notTried(*effect);
      const std::string key = causeOf(*effect);
      auto [at, fresh] = byKey.try_emplace(key, out.groups_.size());
      if (fresh) {
        Group group;
        group.key = key;
        group.dependsOnTime = inputsOf(*effect, domain).dependsOnTime();
        out.groups_.push_back(group);
        out.why_.push_back(reason);
        out.first_.push_back(effect);
      }
      if (!reason.empty()) continue;
      if (starts.empty()) starts.push_back({});
      for (std::vector<double>& start : starts) {
        // what is in the model already may be there once more with another shape, if a key can say it
        if (again && effect->shapedAs(start) == effect->spec()) continue;
        if (!start.empty() && !effect->mayBeClaimed(start)) continue;
        wanted.push_back({at->second, effect, std::move(start)});
      }
    }
  }
  std::stable_sort(wanted.begin(), wanted.end(),
                   [](const Wanted& a, const Wanted& b) { return a.group < b.group; });
  out.wanted_ = std::move(wanted);
  return out;
}

Groups QuestionList::made(std::size_t first, std::size_t count) const {
  Groups out;
  std::vector<std::string> why(why_.begin() + static_cast<long>(first),
                               why_.begin() + static_cast<long>(first + count));
  for (std::size_t g = first; g < first + count; ++g) out.groups.push_back(groups_[g]);
  const auto begin = std::lower_bound(wanted_.begin(), wanted_.end(), first,
                                      [](const Wanted& w, std::size_t group) { return w.group < group; });
  const auto end = std::lower_bound(begin, wanted_.end(), first + count,
                                    [](const Wanted& w, std::size_t group) { return w.group < group; });
  const std::vector<Wanted> wanted(begin, end);

  // by two threads
  const Maker maker(*space_);
  std::vector<Made> made(wanted.size());
  const CancelScope* scope = CancelScope::current();
  inTwo([&](std::size_t half) {
    constexpr int kTogether = 192;  // columns whose projection is one product
    std::vector<Draft> drafts;
    std::vector<std::size_t> of;
    int columns = 0;
    for (std::size_t i = half; i < wanted.size(); i += 2) {
      if (scope != nullptr && scope->asked()) return;
      drafts.push_back(maker.draft(wanted[i].effect, wanted[i].nonlinear));
      of.push_back(i);
      columns += static_cast<int>(drafts.back().raw.cols());
      if (columns < kTogether && i + 2 < wanted.size()) continue;
      std::vector<Made> finished = finishAll(maker, drafts);
      for (std::size_t k = 0; k < of.size(); ++k) made[of[k]] = std::move(finished[k]);
      drafts.clear(), of.clear(), columns = 0;
    }
  });
  CancelScope::check();

  int total = 0;
  for (const Made& m : made) total += m.why.empty() ? m.shape.count : 0;
  // shapes of several members of a family together
  struct Mixed {
    std::size_t group;
    std::vector<std::size_t> members;
  };
  std::vector<Mixed> mixed;
  for (std::size_t g = 0; g < out.groups.size(); ++g) {
    Mixed m{g, {}};
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (wanted[i].group == first + g && made[i].why.empty() && made[i].shape.main == 1 &&
          wanted[i].nonlinear.empty())
        m.members.push_back(i);
    constexpr std::size_t kFewest = 3;
    if (!out.groups[g].profile && m.members.size() >= kFewest && m.members.size() <= std::size(kMixed)) {
      total += static_cast<int>(m.members.size());
      mixed.push_back(m);
    }
  }
  // side by side
  out.columns.resize(space_->length(), total);
  int at = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!made[i].why.empty()) {
      why[wanted[i].group - first] = made[i].why;
      continue;
    }
    made[i].shape.first = at;
    out.columns.middleCols(at, made[i].shape.count) = made[i].columns;
    at += made[i].shape.count;
    out.groups[wanted[i].group - first].shapes.push_back(made[i].shape);
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
  std::vector<Group> kept;
  for (std::size_t g = 0; g < out.groups.size(); ++g) {
    const EffectPtr& effect = first_[first + g];
    out.groups[g].shapesAsked = static_cast<int>(out.groups[g].shapes.size());
    if (out.groups[g].shapesAsked > 0)
      kept.push_back(std::move(out.groups[g]));
    else if (!out.groups[g].profile && !why[g].empty())
      out.notShown.push_back({effect->spec(), effect, why[g]});
  }
  out.groups = std::move(kept);
  for (const Group& g : out.groups) out.causes += !g.profile;
  return out;
}

RowMatrix GroupColumns::operator()(const EffectPtr& effect, const std::vector<double>& nonlinear) const {
  const Maker maker(space_);
  std::vector<Made> made = finishAll(maker, {maker.draft(effect, nonlinear)});
  return made.front().why.empty() ? std::move(made.front().columns) : RowMatrix(space_.length(), 0);
}

void append(Groups& to, Groups more) {
  const int before = static_cast<int>(to.columns.cols());
  RowMatrix all(std::max(to.columns.rows(), more.columns.rows()), before + more.columns.cols());
  if (before > 0) all.leftCols(before) = to.columns;
  if (more.columns.cols() > 0) all.rightCols(more.columns.cols()) = more.columns;
  to.columns = std::move(all);
  for (Group& g : more.groups) {
    for (Shape& s : g.shapes) s.first += before;
    to.groups.push_back(std::move(g));
  }
  to.notShown.insert(to.notShown.end(), more.notShown.begin(), more.notShown.end());
}

std::size_t QuestionList::endOfPart(std::size_t first, std::size_t shapes) const {
  const auto after = [](std::size_t group, const Wanted& w) { return group < w.group; };
  const auto begin = std::upper_bound(wanted_.begin(), wanted_.end(), first, after);
  if (wanted_.end() - begin <= static_cast<long>(shapes)) return size();
  return std::max(first + 1, begin[static_cast<long>(shapes)].group);
}

Groups oneOf(const Groups& all, std::size_t group, const std::vector<int>& shapes) {
  Groups one;
  one.groups.push_back(all.groups[group]);
  std::vector<Shape>& kept = one.groups[0].shapes;
  kept.clear();
  int count = 0;
  for (const int s : shapes) count += all.groups[group].shapes[s].count;
  one.columns.resize(all.columns.rows(), count);
  int at = 0;
  for (const int s : shapes) {
    Shape shape = all.groups[group].shapes[s];
    one.columns.middleCols(at, shape.count) = all.columns.middleCols(shape.first, shape.count);
    shape.first = at;
    at += shape.count;
    kept.push_back(std::move(shape));
  }
  one.causes = !one.groups[0].profile;
  return one;
}

Groups oneOf(const Groups& all, std::size_t group) {
  std::vector<int> shapes(all.groups[group].shapes.size());
  std::iota(shapes.begin(), shapes.end(), 0);
  return oneOf(all, group, shapes);
}

/// What a profile is of: a direction and one or two variables.
struct QuestionList::ProfileOf {
  std::string direction;
  std::vector<std::string> variables;
};

QuestionList QuestionList::of(const ResidualSpace& space, const std::vector<ProfileOf>& profiles) {
  QuestionList out(space);
  const Maker maker(space);
  std::map<std::string, bool> ofTime;  // a variable: it changes while the machine stands still
  for (const auto& [direction, variables] : profiles) {
    const auto make = [&, &along = direction](const std::vector<std::string>& of) {
      return createEffect(profileSpec(along, of, 0.0, maker.domain()), maker.domain());
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
    group.dependsOnTime = std::any_of(variables.begin(), variables.end(), dependsOnTime);
    out.wanted_.push_back({out.groups_.size(), effect, {}});
    out.groups_.push_back(std::move(group));
    out.first_.push_back(effect);
    out.why_.emplace_back();
  }
  return out;
}

namespace {

/// Names that a formula may use for what varied in this session.
std::vector<std::string> variablesThatVary(const ResidualSpace& space) {
  std::vector<std::string> names;
  for (const Variable& v : variablesOf(space))
    if (!v.category && !v.symbol.empty()) names.push_back(v.symbol);
  return names;
}

}  // namespace

QuestionList QuestionList::profiles(const ResidualSpace& space) {
  std::vector<ProfileOf> profiles;
  for (const std::string& direction : directionsOf(space).names)
    for (const std::string& variable : variablesThatVary(space)) profiles.push_back({direction, {variable}});
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
