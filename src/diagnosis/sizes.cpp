// How large what was found is, by the fit of everything together.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/answers.h"
#include "diagnosis/held_out.h"
#include "diagnosis/shape_maker.h"
#include "diagnosis/wording.h"
#include "effects/linearity.h"
#include "effects/profile.h"

namespace mm {

namespace {

/// Values of an effect's nonlinear parameters, SI. @param first of its parameters in x.
std::vector<double> nonlinearOf(const Effect& effect, const Eigen::VectorXd& x, int first) {
  std::vector<double> values;
  for (const int k : effect.nature().nonlinear) values.push_back(x[first + k]);
  return values;
}

/// A constant of a material that none has: what the effect reads is not what acts.
std::string beyondUsual(const Parameter& p, double value, double std) {
  constexpr double kSeldom = 3.2;  // half-t of three degrees of freedom: one in twenty is met beyond it
  if (!(std::abs(value) - 2.0 * std > kSeldom * p.usual)) return {};
  return capitalized(p.name) + " of " + expanded(value * p.toUnit, std * std::abs(p.toUnit), p.unit) +
         " (k = 2) is more than parts have (" + shortNumber(p.usual * std::abs(p.toUnit)) + " " + p.unit +
         " is usual): another cause with the same course looks the same, or the sensor does not have the "
         "temperature of the part.";
}

/// The size of a member of one linear parameter, by a fit of members. @return none: it is no such member.
std::optional<NamedValue> sizeOf(const Questions& q, const Member& m, const Eigen::VectorXd& values,
                                 const Eigen::MatrixXd& covariance) {
  const Group& group = q.groups.groups[m.group];
  const Shape& shape = group.shapes[m.shape];
  const std::vector<int> linear = linearParameters(*shape.effect);
  if (group.profile || shape.main != 1 || !shape.mixed.empty() || linear.size() != 1) return std::nullopt;
  const Eigen::VectorXd raw =
      q.space->columns(*shape.effect, startsAt(*shape.effect, m.nonlinear)).col(linear[0]);
  if (!(raw.norm() > 0.0)) return std::nullopt;
  const Parameter& p = shape.effect->parameters()[static_cast<std::size_t>(linear[0])];
  // the member's first column is the effect's own, in another unit
  const double unit = m.columns->col(0).dot(raw) / raw.squaredNorm() * p.scale * p.toUnit;
  return NamedValue{p.name, p.unit, values[0] * unit, std::sqrt(covariance(0, 0)) * std::abs(unit)};
}

}  // namespace

void takeParameters(const CalibrationResult& full, int first, const std::vector<EffectPtr>& effects,
                    const std::vector<char>& undetermined, Diagnosis& out) {
  int at = first;
  for (std::size_t e = 0; e < effects.size(); ++e) {
    const EffectPtr& effect = effects[e];
    const auto found = std::find_if(out.missing.begin(), out.missing.end(),
                                    [&](const CandidateResult& m) { return m.effect == effect->spec(); });
    if (found != out.missing.end() && undetermined[e]) {
      for (NamedValue& p : found->parameters) p.std = 0.0;
      at += effect->parameterCount();
      continue;
    }
    if (found != out.missing.end()) found->parameters.clear();
    for (ProfileResult& p : out.profiles) {
      if (!(p.effect == effect->spec())) continue;
      constexpr int kPoints = 41, kPointsOfTwo = 9;
      const int n = effect->parameterCount();
      const ProfileCurve curve =
          profileCurve(effect->spec(), full.problem->model().domain(), full.x.segment(at, n),
                       full.covariance.block(at, at, n, n), p.variables.size() == 2 ? kPointsOfTwo : kPoints);
      p.units.clear();
      for (const auto& v : curve.variables) p.units.push_back(v.unit);
      p.curve.clear();
      for (const auto& point : curve.points) {
        std::vector<double> row = {point.at[0]};
        if (p.variables.size() == 2) row.push_back(point.at[1]);
        row.push_back(point.value);
        row.push_back(point.std);
        p.curve.push_back(std::move(row));
      }
    }
    if (found != out.missing.end())
      found->looksTheSame = effect->looksTheSame(nonlinearOf(*effect, full.x, at));
    for (const Parameter& p : effect->parameters()) {
      if (found != out.missing.end()) {
        found->parameters.push_back(
            {p.name, p.unit, full.x[at] * p.toUnit, full.std(at) * std::abs(p.toUnit)});
        const std::string beyond = beyondUsual(p, full.x[at], full.std(at));
        if (!beyond.empty()) found->looksTheSame += (found->looksTheSame.empty() ? "" : " ") + beyond;
      }
      ++at;
    }
  }
}

std::vector<char> whatRanOff(const ResidualSpace& space, const std::vector<Answer>& answers,
                             const CalibrationResult& full, int first, std::size_t members) {
  constexpr double kFarther = 1.3;  // times what is asked: a fit may end a little beyond it
  constexpr double kLarger = 10.0;  // times the size that was found: two of its parts cancel
  std::vector<char> ranOff(members, 0);
  int at = first;
  for (const Answer& a : answers) {
    const std::vector<double> nonlinear = nonlinearOf(*a.effect, full.x, at);
    const auto allowedAt = [&](double times) {
      std::vector<double> values = nonlinear;
      for (double& value : values) value *= times;
      return a.effect->mayBeClaimed(values);
    };
    Eigen::VectorXd size = full.x.segment(at, a.effect->parameterCount()), sizeBefore = a.start;
    for (const int k : a.effect->nature().nonlinear) size[k] = sizeBefore[k] = 0.0;
    at += a.effect->parameterCount();
    if (nonlinear.empty()) continue;
    const bool allowed = (allowedAt(1.0) || allowedAt(kFarther) || allowedAt(1.0 / kFarther)) &&
                         GroupColumns(space)(a.effect, nonlinear).cols() > 0;
    if (!allowed || size.norm() > kLarger * sizeBefore.norm()) ranOff[static_cast<std::size_t>(a.member)] = 1;
  }
  return ranOff;
}

std::vector<char> curvesForTheRest(const Search& search, const Explanation& found) {
  const auto evidence = search.evidenceAt(found);
  const std::vector<Member>& members = found.members;
  std::vector<char> curves(members.size(), 0);
  for (std::size_t j = 0; j < members.size(); ++j) {
    if (!search.hasCurve(*evidence, members, j)) continue;
    const std::vector<Member> beside = search.beside(*evidence, members, j);
    for (std::size_t k = 0; k < members.size(); ++k)
      if (k != j && std::none_of(beside.begin(), beside.end(),
                                 [&](const Member& m) { return m.columns == members[k].columns; }))
        curves[k] = 1;
  }
  return curves;
}

void takeRegularised(const Search& search, const Explanation& found, std::size_t named, Diagnosis& out) {
  const Questions& q = search.questions();
  bool form = false;
  for (std::size_t b = 0; b < q.scatter.size(); ++b)
    form = form || (q.scatterNames[b] == "form" && found.scatter[b] > 0.0);
  const auto& groups = q.groups.groups;
  const std::vector<Member>& members = found.members;
  if (members.empty() || (!form && members.size() == named)) return;
  const Evidence::Fit fit = search.evidenceAt(found)->fit(members);
  const auto shapeOf = [&](const Member& m) -> const Shape& { return groups[m.group].shapes[m.shape]; };
  const auto sizeOfMember = [&](std::size_t j) {
    return sizeOf(q, members[j], fit.values[j], fit.covariance[j]);
  };
  for (std::size_t j = 0; j < named; ++j) {
    const Shape& shape = shapeOf(members[j]);
    const auto result = std::find_if(out.missing.begin(), out.missing.end(), [&](const CandidateResult& r) {
      return r.effect == shape.spec || r.effect == shape.effect->shapedAs(members[j].nonlinear);
    });
    const std::optional<NamedValue> size = sizeOfMember(j);
    if (!size || result == out.missing.end() ||
        result->parameters.size() != static_cast<std::size_t>(shape.effect->parameterCount()))
      continue;
    result->parameters[static_cast<std::size_t>(linearParameters(*shape.effect)[0])] = *size;
    for (std::size_t k = named; k < members.size(); ++k) {
      if (groups[members[j].group].parts.count(groups[members[k].group].key) == 0) continue;
      const Shape& part = shapeOf(members[k]);
      const EffectSpec spec =
          part.mixed.empty() ? part.effect->shapedAs(members[k].nonlinear) : part.mixed[0];
      const std::optional<NamedValue> of = sizeOfMember(k);
      result->looksTheSame +=
          (result->looksTheSame.empty() ? "" : " ") + ("Its size is that beside " + inWords(spec)) +
          (of ? " (" + expanded(of->value, of->std, of->unit) + ", k = 2)" : std::string()) +
          ", which comes with it (with both, held-out RMS " +
          errorInWords(HeldOut(search, found).all() * unitOf(*q.space), out.angular) +
          "): add the cause, then diagnose again.";
    }
  }
}

}  // namespace mm
