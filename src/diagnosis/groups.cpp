#include "diagnosis/groups.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

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

/// Columns of one shape, while it is being made.
struct Made {
  Shape shape;
  RowMatrix columns;
  std::string why;  // not empty: it cannot be shown
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

  /// Columns of the linear parameters, each of unit root mean square after projection; those that are not
  /// seen are left out. @param why not empty on return: nothing of it is seen.
  RowMatrix unitColumns(const Effect& effect, const std::vector<double>& nonlinear, double* factor,
                        std::string& why) const {
    int missing = 0;
    const Eigen::MatrixXd all = space_.columns(effect, startsAt(effect, nonlinear), &missing);
    if (10 * missing > space_.rows()) {
      why = "an input is not known for " + std::to_string(missing) + " of " + std::to_string(space_.rows()) +
            " residuals";
      return {};
    }
    const std::vector<int> linear = linearParameters(effect);
    Eigen::MatrixXd raw(all.rows(), linear.size());
    for (std::size_t k = 0; k < linear.size(); ++k) raw.col(static_cast<int>(k)) = all.col(linear[k]);
    return normalised(raw, factor, why);
  }

  RowMatrix normalised(const Eigen::MatrixXd& raw, double* factor, std::string& why) const {
    Eigen::MatrixXd projected = raw;
    space_.project(projected);
    if (!(raw.norm() > 0.0)) {
      why = "nothing in this session excites it";
      return {};
    }
    const double rows = std::max(1, space_.rows());
    // main columns keep their proportion: two phases of a wave have one size
    double largest = 0.0;
    for (int k = 0; k < raw.cols(); ++k)
      if (projected.col(k).norm() > kSeen * raw.col(k).norm())
        largest = std::max(largest, projected.col(k).norm());
    if (!(largest > 0.0)) {
      why = "the model's other unknowns absorb it completely";
      return {};
    }
    const double scale = std::sqrt(rows) / largest;
    if (factor != nullptr) *factor = scale;
    return raw * scale;
  }

  Made make(const EffectPtr& effect, const std::vector<double>& nonlinear) const {
    Made made;
    made.shape.spec = effect->spec();
    made.shape.effect = effect;
    made.shape.nonlinear = nonlinear;
    double factor = 1.0;
    const RowMatrix main = unitColumns(*effect, nonlinear, &factor, made.why);
    if (!made.why.empty()) return made;
    std::vector<RowMatrix> parts = {main};
    const auto beside = [&](const Effect& other, const std::vector<double>& at, double share) {
      std::string why;
      RowMatrix columns = unitColumns(other, at, nullptr, why);
      if (why.empty()) parts.push_back(columns * share);
    };
    for (const ShapeFreedom& f : effect->freedom(domain_))
      beside(*createEffect(f.spec, domain_), {}, f.share);
    for (const Effect::NonlinearFreedom& f : effect->freedomBeside(nonlinear))
      beside(*effect, f.nonlinear, f.share);
    for (const int joint : effect->variesAlong(domain_)) {
      RowMatrix varied = main;
      varyAlong(problem_, space_.used(), joint, varied);
      std::string why;
      Eigen::MatrixXd raw = varied;
      const RowMatrix columns = normalised(raw, nullptr, why);
      if (why.empty()) parts.push_back(columns * kVariation);
    }
    int count = 0;
    for (const RowMatrix& m : parts) count += static_cast<int>(m.cols());
    made.columns.resize(space_.length(), count);
    int at = 0;
    for (const RowMatrix& m : parts) {
      made.columns.middleCols(at, m.cols()) = m;
      at += static_cast<int>(m.cols());
    }
    made.shape.count = count;
    made.shape.main = static_cast<int>(main.cols());
    // what is drawn with a prior (a profile's coefficients) has weights of its own
    const std::vector<int> linear = linearParameters(*effect);
    double widest = 0.0;
    for (const int k : linear)
      widest = std::max(widest, effect->parameters()[k].priorStd / effect->parameters()[k].scale);
    if (widest > 0.0) {
      double total = 0.0;
      for (std::size_t k = 0; k < linear.size(); ++k)
        made.columns.col(static_cast<int>(k)) *=
            effect->parameters()[linear[k]].priorStd / effect->parameters()[linear[k]].scale / widest;
      Eigen::MatrixXd projected = made.columns;
      space_.project(projected);
      total = projected.norm();
      if (!(total > 0.0)) {
        made.why = "the model's other unknowns absorb it completely";
        return made;
      }
      made.columns *= std::sqrt(static_cast<double>(space_.rows())) / total;
    }
    return made;
  }

  const Domain& domain() const { return domain_; }
  const Problem& problem() const { return problem_; }

 private:
  const ResidualSpace& space_;
  const Problem& problem_;
  const Domain& domain_;
};

/// A shape to be made: the effect and values of its nonlinear parameters.
struct Wanted {
  std::size_t group;
  EffectPtr effect;
  std::vector<double> nonlinear;
};

/// Makes all, by two threads, and lays their columns side by side.
void makeAll(const Maker& maker, const std::vector<Wanted>& wanted, Groups& out, int length,
             std::vector<std::string>* why) {
  std::vector<Made> made(wanted.size());
  const CancelScope* scope = CancelScope::current();
  inTwo([&](std::size_t half) {
    for (std::size_t i = half; i < wanted.size(); i += 2) {
      if (scope != nullptr && scope->asked()) return;
      made[i] = maker.make(wanted[i].effect, wanted[i].nonlinear);
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
      if (wanted[i].group == g && made[i].why.empty() && made[i].shape.main == 1 &&
          wanted[i].nonlinear.empty())
        m.members.push_back(i);
    constexpr std::size_t kFewest = 3;
    if (!out.groups[g].profile && m.members.size() >= kFewest && m.members.size() <= std::size(kMixed)) {
      total += static_cast<int>(m.members.size());
      mixed.push_back(m);
    }
  }
  out.columns.resize(length, total);
  int at = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!made[i].why.empty()) {
      if (why != nullptr) (*why)[wanted[i].group] = made[i].why;
      continue;
    }
    made[i].shape.first = at;
    out.columns.middleCols(at, made[i].shape.count) = made[i].columns;
    at += made[i].shape.count;
    out.groups[wanted[i].group].shapes.push_back(made[i].shape);
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

Groups makeGroups(const ResidualSpace& space) {
  Groups out;
  const Maker maker(space);
  const Domain& domain = maker.domain();
  const Model& model = maker.problem().model();
  std::map<std::string, std::size_t> byKey;
  std::vector<Wanted> wanted;
  std::vector<std::string> why;
  std::vector<EffectPtr> first;
  for (const EffectType& type : effectRegistry()) {
    if (type.composite || !type.candidates) continue;
    for (const EffectSpec& spec : type.candidates(domain)) {
      const EffectPtr effect = type.create(spec, domain);
      std::vector<std::vector<double>> starts = effect->searchStarts();
      const bool again = inModel(model, effect->spec());
      if (again && starts.empty()) continue;
      const std::string reason = maker.notTried(*effect);
      const std::string key = causeOf(*effect);
      auto [at, fresh] = byKey.try_emplace(key, out.groups.size());
      if (fresh) {
        Group group;
        group.key = key;
        group.dependsOnTime = inputsOf(*effect, domain).dependsOnTime();
        out.groups.push_back(group);
        why.push_back(reason);
        first.push_back(effect);
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
  makeAll(maker, wanted, out, space.length(), &why);
  std::vector<Group> kept;
  for (std::size_t g = 0; g < out.groups.size(); ++g) {
    if (out.groups[g].shapes.empty()) {
      if (!why[g].empty()) out.notShown.push_back({first[g]->spec(), first[g], why[g]});
      continue;
    }
    kept.push_back(std::move(out.groups[g]));
  }
  out.groups = std::move(kept);
  out.causes = static_cast<int>(out.groups.size());
  return out;
}

RowMatrix GroupColumns::operator()(const EffectPtr& effect, const std::vector<double>& nonlinear) const {
  const Made made = Maker(space_).make(effect, nonlinear);
  return made.why.empty() ? made.columns : RowMatrix(space_.length(), 0);
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

namespace {

/// What a profile is of: a direction and one or two variables.
struct ProfileOf {
  std::string direction;
  std::vector<std::string> variables;
};

Groups profilesOf(const ResidualSpace& space, const std::vector<ProfileOf>& profiles) {
  Groups out;
  const Maker maker(space);
  std::vector<Wanted> wanted;
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
    wanted.push_back({out.groups.size(), effect, {}});
    out.groups.push_back(std::move(group));
  }
  makeAll(maker, wanted, out, space.length(), nullptr);
  out.groups.erase(
      std::remove_if(out.groups.begin(), out.groups.end(), [](const Group& g) { return g.shapes.empty(); }),
      out.groups.end());
  return out;
}

/// Names that a formula may use for what varied in this session.
std::vector<std::string> variablesThatVary(const ResidualSpace& space) {
  std::vector<std::string> names;
  for (const Variable& v : variablesOf(space))
    if (!v.category && !v.symbol.empty()) names.push_back(v.symbol);
  return names;
}

}  // namespace

Groups makeProfiles(const ResidualSpace& space) {
  std::vector<ProfileOf> profiles;
  for (const std::string& direction : directionsOf(space).names)
    for (const std::string& variable : variablesThatVary(space)) profiles.push_back({direction, {variable}});
  return profilesOf(space, profiles);
}

Groups makePairProfiles(const ResidualSpace& space) {
  std::vector<ProfileOf> profiles;
  const std::vector<std::string> names = variablesThatVary(space);
  for (const std::string& direction : directionsOf(space).names)
    for (std::size_t a = 0; a < names.size(); ++a)
      for (std::size_t b = a + 1; b < names.size(); ++b)
        profiles.push_back({direction, {names[a], names[b]}});
  return profilesOf(space, profiles);
}

}  // namespace mm
