#include "diagnosis/answers.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/dense.h"
#include "base/units.h"
#include "design/next_measurement.h"
#include "diagnosis/wording.h"
#include "effects/inputs.h"
#include "effects/linearity.h"
#include "effects/profile.h"
#include "effects/registry.h"
#include "posterior/slots.h"

namespace mm {
namespace {

constexpr double kCounts = 4.5;  // standard deviations: a further shape of a family is told as well
constexpr double kPriorCause =
    0.5;  // that any cause acts, before a session is seen: that is why it is diagnosed
constexpr std::size_t kMostHeldOut = 12;  // candidates whose held-out figure is worked out: the best

const Shape& shapeOf(const Questions& q, const Member& m) { return q.groups.groups[m.group].shapes[m.shape]; }

/// Weight of a cause against none, by its gain.
double weightOf(const Questions& q, double gain) {
  return std::exp(std::min(kMostNats, gain)) * kPriorCause / std::max(1, q.asked);
}

/// The first shape of a group that would be added as `spec`; null: none.
const Shape* shapeWith(const Questions& q, const EffectSpec& spec) {
  for (const Group& g : q.groups.groups)
    for (const Shape& s : g.shapes)
      if (s.spec == spec) return &s;
  return nullptr;
}

/// The effects that a member stands for: itself, a profile of the size found, or the members of a family.
/// @param values, covariance of its coefficients. @param size of a profile, m or rad. @param taken what is in
/// the model already.
std::vector<EffectSpec> specsOf(const Questions& q, const Member& m, const Eigen::VectorXd& values,
                                const Eigen::MatrixXd& covariance, double size,
                                const std::vector<EffectSpec>& taken) {
  const Shape& shape = shapeOf(q, m);
  if (q.groups.groups[m.group].profile)
    return {sizedProfile(shape.spec, size, q.space->problem().model().domain())};
  if (shape.mixed.empty()) {
    const bool there =
        std::any_of(taken.begin(), taken.end(), [&](const EffectSpec& s) { return s == shape.spec; });
    return {there ? shape.effect->shapedAs(m.nonlinear) : shape.spec};
  }
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < shape.mixed.size(); ++k)
    order.emplace_back(-m.columns->col(static_cast<int>(k)).norm() * std::abs(values[static_cast<int>(k)]),
                       k);
  std::sort(order.begin(), order.end());
  std::vector<EffectSpec> specs;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const int at = static_cast<int>(order[k].second);
    if (k == 0 || std::abs(values[at]) > kCounts * std::sqrt(covariance(at, at)))
      specs.push_back(shape.mixed[order[k].second]);
  }
  return specs;
}

}  // namespace

double unitOf(const ResidualSpace& space) {
  double sum = 0.0;
  for (const int row : space.used()) sum += space.fitted().sigma[row];
  return space.rows() > 0 ? sum / space.rows() : 1.0;
}

double projectedRms(const ResidualSpace& space, const RowMatrix& columns, const Eigen::VectorXd& values) {
  Eigen::MatrixXd one = columns * values;
  space.project(one);
  return std::sqrt(one.topRows(space.rows()).squaredNorm() / std::max(1, space.rows()));
}

std::vector<Answer> answersOf(const Search& search, const Explanation& found) {
  const Questions& q = search.questions();
  std::vector<Answer> answers;
  if (found.members.empty()) return answers;
  const Domain& domain = q.space->problem().model().domain();
  const auto evidence = search.evidenceAt(found);
  const Evidence::Fit fit = evidence->fit(found.members);
  std::vector<EffectSpec> taken;
  for (const EffectPtr& e : q.space->problem().model().effects()) taken.push_back(e->spec());
  for (std::size_t j = 0; j < found.members.size(); ++j) {
    const Member& m = found.members[j];
    // one with a curve for what it leaves is as it would be without: how both share it says nothing
    std::vector<Member> alone = search.beside(*evidence, found.members, j);
    const bool hasCurve = alone.size() + 1 < found.members.size();
    if (hasCurve) alone.push_back(m);
    const Evidence::Fit own = hasCurve ? evidence->fit(alone) : Evidence::Fit();
    const Eigen::VectorXd& values = hasCurve ? own.values.back() : fit.values[j];
    const Eigen::MatrixXd& covariance = hasCurve ? own.covariance.back() : fit.covariance[j];
    for (const EffectSpec& spec :
         specsOf(q, m, values, covariance, m.size * found.white * unitOf(*q.space), taken)) {
      Answer a;
      a.effect = createEffect(spec, domain);
      a.member = static_cast<int>(j);
      a.start.resize(a.effect->parameterCount());
      for (int k = 0; k < a.effect->parameterCount(); ++k) a.start[k] = a.effect->parameters()[k].start;
      const std::vector<int> nonlinear = a.effect->nature().nonlinear;
      for (std::size_t k = 0; k < nonlinear.size() && k < m.nonlinear.size(); ++k)
        a.start[nonlinear[k]] = m.nonlinear[k];
      taken.push_back(spec);
      answers.push_back(std::move(a));
    }
  }
  // the linear parameters together
  Eigen::MatrixXd all(q.space->length(), 0);
  for (const Answer& a : answers) {
    const std::vector<double> p(a.start.data(), a.start.data() + a.start.size());
    const Eigen::MatrixXd columns = q.space->columns(*a.effect, p);
    for (const int k : linearParameters(*a.effect)) {
      all.conservativeResize(Eigen::NoChange, all.cols() + 1);
      all.rightCols<1>() = columns.col(k);
    }
  }
  if (all.cols() > 0) {
    q.space->project(all);
    // a trace of a prior: what a profile leaves undetermined stays small
    Eigen::MatrixXd products = all.transpose() * all;
    products.diagonal().array() += kRidge * products.diagonal().maxCoeff();
    const Eigen::VectorXd values = solveSymmetric(products, all.transpose() * q.space->target());
    int at = 0;
    for (Answer& a : answers)
      for (const int k : linearParameters(*a.effect)) {
        const Parameter& p = a.effect->parameters()[static_cast<std::size_t>(k)];
        // what states a place or a direction itself adds nothing at its start, which is the nominal one
        a.start[k] = (a.effect->nature().startTells ? p.start : 0.0) + values[at++] * p.scale;
      }
  }
  return answers;
}

void sortByGain(const Search& search, Explanation& found) {
  const auto evidence = search.evidenceAt(found);
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t j = 0; j < found.members.size(); ++j) {
    const std::vector<Member> others = search.beside(*evidence, found.members, j);
    order.emplace_back(-evidence->gainOf(evidence->given(others), *found.members[j].columns).value, j);
  }
  std::stable_sort(order.begin(), order.end());
  std::vector<Member> sorted;
  for (const auto& [gain, j] : order) sorted.push_back(found.members[j]);
  found.members = std::move(sorted);
}

void fillAnswers(const Search& search, const Explanation& found, const HeldOut& held, double unit,
                 Diagnosis& out) {
  const Questions& q = search.questions();
  const auto evidence = search.evidenceAt(found);
  const std::vector<Answer> answers = answersOf(search, found);
  double before = held.before() * unit;
  for (std::size_t j = 0; j < found.members.size(); ++j) {
    const Member& m = found.members[j];
    const Group& group = q.groups.groups[m.group];
    const std::vector<Member> others = search.beside(*evidence, found.members, j);
    const Evidence::Given given = evidence->given(others);
    const Gain own = evidence->gainOf(given, *m.columns);
    const double gain =
        own.value - group.shapes[m.shape].price - group.shapes[m.shape].priceOfSize(own.coefficient);
    std::vector<Member> alone = others;  // its size is that of the same fit
    alone.push_back(m);
    Search::takeSize(alone.back(), own);
    const Eigen::VectorXd values = evidence->fit(alone).values.back();
    const double after = (j + 1 == found.members.size() ? held.all() : held.with(j + 1)) * unit;
    const double odds = weightOf(q, gain) / (1.0 + weightOf(q, gain));
    bool first = true;
    for (const Answer& a : answers) {
      if (a.member != static_cast<int>(j)) continue;
      if (group.profile) {
        ProfileResult p;
        p.effect = a.effect->spec();
        p.direction = p.effect.text("direction");
        const EffectSpec::Value* two = p.effect.find("variables");
        p.variables = two != nullptr ? two->items : std::vector<std::string>{p.effect.text("variable")};
        p.gain = gain;
        p.odds = odds;
        p.heldOutBefore = before;
        p.heldOutAfter = after;
        out.profiles.push_back(std::move(p));
        continue;
      }
      CandidateResult r;
      r.effect = a.effect->spec();
      r.gain = gain;
      r.odds = odds;
      r.pValue = std::min(1.0, q.asked * std::exp(-std::min(kMostNats, gain)));
      r.heldOutBefore = first ? before : after;
      r.heldOutAfter = after;
      r.size = projectedRms(*q.space, *m.columns, values) * unit;
      r.cause = a.effect->cause();
      r.remedy = a.effect->remedy();
      for (int k = 0; k < a.effect->parameterCount(); ++k) {
        const Parameter& p = a.effect->parameters()[k];
        r.parameters.push_back({p.name, p.unit, a.start[k] * p.toUnit, kNotMeasured});
      }
      out.missing.push_back(std::move(r));
      first = false;
    }
    before = after;
  }
}

void listCandidates(const Search& search, const Explanation& found, const HeldOut& held, double unit,
                    Diagnosis& out) {
  const Questions& q = search.questions();
  const auto evidence = search.evidenceAt(found);
  const Evidence::Given nothing = evidence->given({});
  const double before = held.before() * unit;
  std::size_t count = 0;
  for (const Gain& g : evidence->gains(nothing)) {
    if (g.group < 0 || q.groups.groups[g.group].profile) continue;
    const Member m = search.memberOf(g);
    const Shape& shape = shapeOf(q, m);
    CandidateResult r;
    r.effect = shape.spec;
    r.gain = g.value;
    r.pValue = std::min(1.0, q.asked * std::exp(-std::min(kMostNats, g.value)));
    r.heldOutBefore = before;
    r.heldOutAfter = count++ < kMostHeldOut && g.size > 0.0 ? held.withGroup(g.group) * unit : before;
    r.cause = shape.effect->cause();
    r.remedy = shape.effect->remedy();
    if (g.size > 0.0) {
      const Evidence::Fit fit = evidence->fit({m});
      r.size = projectedRms(*q.space, *m.columns, fit.values[0]) * unit;
    }
    out.candidates.push_back(std::move(r));
  }
}

void listCannotShow(const Questions& q, const Explanation&, Diagnosis& out) {
  for (const NotShown& n : q.groups.notShown) out.cannotShow.push_back({n.spec, n.why, n.effect->shownBy()});
}

void fillMissingInputs(const Questions& q, Diagnosis& out) {
  const Session& session = q.space->problem().session();
  const Domain& domain = q.space->problem().model().domain();
  std::vector<EffectSpec> named;
  for (const CandidateResult& m : out.missing) {
    named.push_back(m.effect);
    for (const Confusable& c : m.confusableWith) named.push_back(c.effect);
  }
  for (const AssumedInput& a : session.assumed) {
    MissingInput input{"direction of travel of " + a.joint, a.how, {}};
    const int joint = domain.findJoint(a.joint);
    for (const EffectSpec& spec : named) {
      const Inputs inputs = inputsOf(*createEffect(spec, domain), domain);
      const auto needs = [&](const std::vector<int>& joints) {
        return std::find(joints.begin(), joints.end(), joint) != joints.end();
      };
      if (needs(inputs.travels) || needs(inputs.velocities)) input.effects.push_back(spec);
    }
    out.missingInputs.push_back(std::move(input));
  }
  // what could not be asked for want of a speed or a direction
  const auto recorded = [&](auto value) {
    return std::any_of(session.observations.begin(), session.observations.end(), value);
  };
  for (const NotShown& n : q.groups.notShown) {
    const Inputs inputs = inputsOf(*n.effect, domain);
    for (const int joint : inputs.velocities)
      if (!recorded([&](const Observation& o) { return std::isfinite(o.velocity[joint]); })) {
        const std::string name = "speed of " + domain.joints[joint].name;
        const auto known = std::find_if(out.missingInputs.begin(), out.missingInputs.end(),
                                        [&](const MissingInput& m) { return m.input == name; });
        if (known == out.missingInputs.end())
          out.missingInputs.push_back({name, "", {n.spec}});
        else
          known->effects.push_back(n.spec);
      }
  }
}

void separate(const Search& search, const Explanation& found, Diagnosis& out) {
  const Questions& q = search.questions();
  for (CandidateResult& missing : out.missing) {
    if (missing.confusableWith.empty()) continue;
    const auto causeOfSpec = [&](const EffectSpec& spec) {
      return causeOf(*createEffect(spec, q.space->problem().model().domain()));
    };
    const std::string cause = causeOfSpec(missing.effect);
    for (std::size_t j = 0; j < found.members.size(); ++j) {
      const Shape& shape = shapeOf(q, found.members[j]);
      if (!(shape.spec == missing.effect) && shape.mixed.empty()) continue;
      std::vector<Hypothesis> rivals;
      std::vector<Confusable*> asked;
      for (Confusable& c : missing.confusableWith) {
        if (!c.notRecorded.empty()) continue;
        const Shape* rival = shapeWith(q, c.effect);
        if (rival == nullptr) continue;
        rivals.push_back({rival->effect, rival->nonlinear});
        asked.push_back(&c);
      }
      const NextMeasurement next =
          nextMeasurement(*q.space, {shape.effect, found.members[j].nonlinear}, rivals);
      for (std::size_t r = 0; r < asked.size() && r < next.rivals.size(); ++r) {
        asked[r]->same = next.rivals[r].same;
        if (asked[r]->same)
          missing.odds = std::min(kOfThisWorld, missing.odds + asked[r]->odds);  // one error, two names
        if (asked[r]->same) continue;
        asked[r]->moves = movesInWords(next.rivals[r].deviations, next.moves.size()) +
                          (next.change.empty() ? "" : ", with " + next.change);
        if (out.nextMeasurement.empty())
          asked[r]->repeats = repeatsOfMoves(next.rivals[r].deviations, next.moves.size());
      }
      if (std::any_of(asked.begin(), asked.end(), [](const Confusable* c) { return c->repeats > 0; })) {
        out.nextMeasurement = next.moves;
        out.moveChange = next.change;
      }
      break;
    }
    for (CandidateResult& c : out.candidates)
      if (causeOfSpec(c.effect) == cause) c.odds = missing.odds;
  }
}

}  // namespace mm
