#include "diagnosis/posterior_search.h"

#include <algorithm>
#include <cmath>

#include "effects/registry.h"

namespace mm {
namespace {

constexpr double kDeclaredFreedoms = 8.0;  // of a repeatability that somebody stated: good to a quarter
constexpr double kExpected = 1.0;          // causes that act in a session, before it is seen
constexpr double kCurve = 0.05;            // how often a curve without a name is met, of a cause with one
constexpr double kAlone = 0.97;            // share of its slot from which a leader has no rivals
constexpr double kPerhaps = 0.1;           // probability from which a cause is told beside drift

/// How often such a cause is met, a common one being 1.
double metOf(const Group& group) { return group.profile ? std::pow(kCurve, group.variables) : 1.0; }

}  // namespace

double logPriorOddsOf(const Questions& q, const Group& group) {
  return std::log(kExpected * metOf(group) / std::max(1, q.asked));
}

PosteriorProblem problemOf(const Questions& q, const Groups& groups, double statedFreedoms) {
  PosteriorProblem p;
  p.rows = q.rows;
  p.scatter = q.scatter;
  p.statedFreedoms = statedFreedoms;
  // shapes of one cause side by side
  RowMatrix columns(q.rows.length(), groups.columns.cols());
  int at = 0;
  for (const Group& g : groups.groups) {
    Cause cause;
    cause.logPriorOdds = logPriorOddsOf(q, g);
    cause.first = static_cast<int>(p.shapes.size());
    for (const Shape& s : g.shapes) {
      CauseShape shape;
      shape.cause = static_cast<int>(p.causes.size());
      shape.first = at;
      shape.count = s.count;
      columns.middleCols(at, s.count) = groups.columns.middleCols(s.first, s.count);
      at += s.count;
      for (int k = 0; k < kSizes; ++k)
        shape.logPrior[k] = -g.priceOfShape() - std::log(double(kSizes)) - s.priceOfSize(sizeGrid()[k]);
      p.shapes.push_back(shape);
    }
    cause.end = static_cast<int>(p.shapes.size());
    p.causes.push_back(cause);
  }
  p.columns = columns.leftCols(at);
  return p;
}

double statedFreedomsOf(const CalibrationResult& fitted) {
  if (fitted.repeatabilityFrom == "estimated") return 1.0;
  if (fitted.repeatabilityFrom == "repeated" && fitted.repeated.dof > 0.0)
    return std::min(kDeclaredFreedoms, fitted.repeated.dof);
  return kDeclaredFreedoms;
}

PosteriorAnswer explainByPosterior(const Questions& q, const Eigen::VectorXd& variance, double statedFreedoms,
                                   const std::vector<PosteriorStart>& starts, std::uint64_t seed) {
  const PosteriorProblem problem = problemOf(q, q.groups, statedFreedoms);
  SampleOptions options;
  options.seed = seed;
  options.starts = starts;
  PosteriorAnswer out;
  out.sample = samplePosterior(problem, variance, options);
  out.slots = slotsOf(out.sample);
  for (std::size_t c = 0; c < problem.causes.size(); ++c) {
    const Acting a = shapeOf(out.sample, problem, static_cast<int>(c));
    out.likeliest.push_back(a.shape < 0 ? -1 : a.shape - problem.causes[c].first);
  }
  const Search search(q);
  const NoiseState& noise = out.sample.pool[static_cast<std::size_t>(likeliestNoise(out.sample))]->state();
  Explanation start;
  start.noise.drift = noise.drift;
  start.noise.variance = noise.variance;
  start.scatter = noise.scatter;
  std::vector<Member> members;
  const auto evidence = search.evidenceAt(start);
  for (const Slot& slot : out.slots) {
    if (!slot.named) continue;
    const Acting a = shapeOf(out.sample, problem, slot.causes.front());
    if (a.shape < 0) continue;
    Gain gain;
    gain.group = slot.causes.front();
    gain.shape = a.shape - problem.causes[static_cast<std::size_t>(gain.group)].first;
    gain.size = sizeGrid()[a.size];
    members.push_back(search.memberOf(gain));
  }
  for (int round = 0; round < 2; ++round)
    for (std::size_t j = 0; j < members.size(); ++j) {
      std::vector<Member> others = members;
      others.erase(others.begin() + static_cast<long>(j));
      members[j] = search.refined(*evidence, others, members[j]);
    }
  out.found = search.refitted(members, start, false);
  return out;
}

namespace {

/// The shape of a cause that has most of its probability, as it would be added.
EffectSpec specOf(const Questions& q, const PosteriorAnswer& answer, int cause) {
  const Group& g = q.groups.groups[static_cast<std::size_t>(cause)];
  const int shape = std::max(0, answer.likeliest[static_cast<std::size_t>(cause)]);
  const Shape& s = g.shapes[static_cast<std::size_t>(shape)];
  return s.mixed.empty() ? s.effect->shapedAs(s.nonlinear) : s.spec;
}

void takeRivals(const Questions& q, const PosteriorAnswer& answer, const Slot& slot, CandidateResult& to) {
  double all = 0.0;
  for (const double share : slot.shares) all += share;
  if (slot.shares.front() >= kAlone * all) return;
  for (std::size_t k = 1; k < slot.causes.size(); ++k) {
    const Group& g = q.groups.groups[static_cast<std::size_t>(slot.causes[k])];
    if (g.profile) continue;
    Confusable c;
    c.effect = specOf(q, answer, slot.causes[k]);
    c.odds = slot.shares[k] / all;
    c.delta = std::log(std::max(1.0, slot.shares.front() / slot.shares[k]));
    for (const std::string& input : g.notRecorded)
      c.notRecorded += (c.notRecorded.empty() ? "" : ", ") + input;
    to.confusableWith.push_back(std::move(c));
  }
}

}  // namespace

void takeOdds(const Questions& q, const PosteriorAnswer& answer, Diagnosis& out) {
  const Domain& domain = q.space->problem().model().domain();
  for (const Slot& slot : answer.slots) {
    const Group& group = q.groups.groups[static_cast<std::size_t>(slot.causes.front())];
    if (slot.named) {
      bool first = true;
      for (CandidateResult& r : out.missing) {
        if (causeOf(*createEffect(r.effect, domain)) != group.key) continue;
        r.odds = odds(answer.sample, slot.shares.front());
        r.confusableWith.clear();
        if (first) takeRivals(q, answer, slot, r);
        first = false;
      }
      continue;
    }
    for (std::size_t k = 0; k < slot.causes.size(); ++k) {
      const Group& g = q.groups.groups[static_cast<std::size_t>(slot.causes[k])];
      if (g.dependsOnTime && !g.profile && slot.shares[k] > kPerhaps && !out.drift.empty())
        out.drift.front().perhaps.push_back({specOf(q, answer, slot.causes[k]), slot.shares[k], 1.0});
    }
  }
  for (CandidateResult& r : out.candidates) {
    const std::string key = causeOf(*createEffect(r.effect, domain));
    for (std::size_t g = 0; g < answer.sample.inclusion.size(); ++g)
      if (q.groups.groups[g].key == key) r.odds = odds(answer.sample, answer.sample.inclusion[g]);
  }
}

}  // namespace mm
