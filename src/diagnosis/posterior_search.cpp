#include "diagnosis/posterior_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "effects/registry.h"
#include "posterior/part_of_first.h"

namespace mm {
namespace {

constexpr double kDeclaredFreedoms = 8.0;  // of a repeatability that somebody stated: good to a quarter
constexpr double kExpected = 1.0;          // causes that act in a session, before it is seen
constexpr double kPossibleSize = -4.6;     // log probability, one in a hundred, that a size obeys its law
constexpr double kLikelierThanNot = 0.5;   // share of what a curve may be, from which it has a name
constexpr double kAlone = 0.97;            // share of its slot from which a leader has no rivals

/// Whether the size of a law beside others is one that it can have.
bool isPossible(const Evidence& evidence, const Shape& shape, std::vector<Member> members,
                const Member& law) {
  if (!shape.effect->nature().secondPartOfFirst) return true;
  members.push_back(law);
  const Evidence::Fit fit = evidence.fit(members);
  return logPartOfFirst(Eigen::Vector2d(fit.values.back().head<2>()),
                        Eigen::Matrix2d(fit.covariance.back().topLeftCorner<2, 2>())) > kPossibleSize;
}

/// The cause that is likeliest in the place of a curve is told where its law explains nearly all that the
/// curve does, and the curve is for its rest. @param acting of the members, in their order.
std::vector<CurveName> nameCurves(const Search& search, const Evidence& evidence, const NoiseView& noise,
                                  const ActingSet& acting, std::vector<Member>& members) {
  const std::vector<Group>& groups = search.questions().groups.groups;
  const std::vector<Member> found = members;
  std::vector<CurveName> names;
  for (std::size_t j = 0; j < found.size(); ++j) {
    if (!groups[static_cast<std::size_t>(found[j].group)].profile) continue;
    std::vector<Member> others = found;
    ActingSet beside = acting;
    others.erase(others.begin() + static_cast<long>(j));
    beside.erase(beside.begin() + static_cast<long>(j));
    std::vector<double> logOdds = noise.look(beside)->logOdds;
    for (std::size_t g = 0; g < groups.size(); ++g)
      if (groups[g].profile) logOdds[g] = -std::numeric_limits<double>::infinity();
    for (const Member& m : members)
      logOdds[static_cast<std::size_t>(m.group)] = -std::numeric_limits<double>::infinity();
    const auto best = std::max_element(logOdds.begin(), logOdds.end());
    if (!std::isfinite(*best)) continue;
    const Evidence::Given given = evidence.given(others);
    const auto explained = [&](double gain) { return -std::expm1(-2.0 * gain / given.freedoms); };
    const Gain gain = evidence.gainOf(given, static_cast<int>(best - logOdds.begin()));
    if (gain.group < 0) continue;
    const Member name = search.memberOf(gain);
    const Shape& shape =
        groups[static_cast<std::size_t>(gain.group)].shapes[static_cast<std::size_t>(gain.shape)];
    Member law = name;  // what it has beside its law may be anything
    law.columns = std::make_shared<RowMatrix>(name.columns->leftCols(shape.main));
    if (!isPossible(evidence, shape, others, law) ||
        !(explained(evidence.gainOf(given, *law.columns).value) >
          kMostOfIt * explained(evidence.gainOf(given, *found[j].columns).value)))
      continue;
    const Eigen::Map<const Eigen::ArrayXd> all(logOdds.data(), static_cast<Eigen::Index>(logOdds.size()));
    const double share = std::exp(*best - logSumExp(all));
    if (share < kLikelierThanNot) continue;
    members.push_back(name);
    names.push_back({found[j].group, gain.group, share});
  }
  return names;
}

}  // namespace

double logPriorOddsOf(const Questions& q, const Group& group) {
  return std::log(kExpected * group.met / std::max(1, q.asked));
}

PosteriorProblem problemOf(const Questions& q, const Groups& groups, double statedFreedoms) {
  PosteriorProblem p;
  p.rows = q.rows;
  p.scatter = q.scatter;
  p.statedFreedoms = statedFreedoms;
  // shapes of one cause side by side; two may have columns in common
  int count = 0;
  for (const Group& g : groups.groups)
    for (const Shape& s : g.shapes) count += s.count;
  RowMatrix columns(q.rows.length(), count);
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
      shape.secondPartOfFirst = s.effect->nature().secondPartOfFirst && s.mixed.empty();
      columns.middleCols(at, s.count) = groups.columns.middleCols(s.first, s.count);
      at += s.count;
      for (int k = 0; k < kSizes; ++k)
        shape.logPrior[k] = -s.price - std::log(double(kSizes)) - s.priceOfSize(sizeGrid()[k]);
      p.shapes.push_back(shape);
    }
    cause.end = static_cast<int>(p.shapes.size());
    p.causes.push_back(cause);
  }
  p.columns = std::move(columns);
  std::map<std::string, int> ofKey;
  for (const Group& g : groups.groups) ofKey.emplace(g.key, static_cast<int>(ofKey.size()));
  for (std::size_t whole = 0; whole < groups.groups.size(); ++whole)
    for (const auto& [key, share] : groups.groups[whole].parts)
      if (const auto part = ofKey.find(key); part != ofKey.end())
        p.causes[static_cast<std::size_t>(part->second)].partOf.emplace_back(static_cast<int>(whole), share);
  return p;
}

double statedFreedomsOf(const CalibrationResult& fitted) {
  if (fitted.repeatabilityFrom == "estimated") return 1.0;
  if (fitted.repeatabilityFrom == "repeated" && fitted.repeated.dof > 0.0)
    return std::min(kDeclaredFreedoms, fitted.repeated.dof);
  return kDeclaredFreedoms;
}

Explanation noiseOnly(const NoiseState& noise) {
  Explanation at;
  at.noise.drift = noise.drift;
  at.noise.variance = noise.variance;
  at.scatter = noise.scatter;
  return at;
}

std::vector<Member> membersOf(const Search& search, const Evidence& evidence, const PosteriorProblem& problem,
                              const ActingSet& acting) {
  std::vector<Member> members;
  for (const Acting& a : acting) {
    Gain gain;
    gain.group = problem.shapes[static_cast<std::size_t>(a.shape)].cause;
    gain.shape = a.shape - problem.causes[static_cast<std::size_t>(gain.group)].first;
    gain.size = sizeGrid()[a.size];
    members.push_back(search.memberOf(gain));
  }
  for (int round = 0; round < 2; ++round)
    for (std::size_t j = 0; j < members.size(); ++j) {
      std::vector<Member> others = members;
      others.erase(others.begin() + static_cast<long>(j));
      members[j] = search.refined(evidence, others, members[j]);
    }
  return members;
}

Explanation explanationOf(const Questions& q, const PosteriorProblem& problem, const ActingSet& acting,
                          const NoiseState& noise, std::vector<CurveName>* names) {
  const Search search(q);
  const Explanation start = noiseOnly(noise);
  const auto evidence = search.evidenceAt(start);
  std::vector<Member> members = membersOf(search, *evidence, problem, acting);
  std::vector<CurveName> named = nameCurves(search, *evidence, NoiseView(problem, noise), acting, members);
  if (names != nullptr) *names = std::move(named);
  return search.refitted(members, start);
}

namespace {

/// What acts, likelier than not, as a part of a cause that is named.
ActingSet partsOfNamed(const PosteriorProblem& problem, const PosteriorAnswer& answer) {
  std::set<int> named;
  for (const Slot& slot : answer.slots)
    if (slot.named) named.insert(slot.causes.begin(), slot.causes.end());
  ActingSet parts;
  for (std::size_t c = 0; c < problem.causes.size(); ++c) {
    const int cause = static_cast<int>(c);
    const auto& partOf = problem.causes[c].partOf;
    const bool ofNamed =
        std::any_of(partOf.begin(), partOf.end(), [&](const auto& of) { return named.count(of.first) > 0; });
    if (!ofNamed || named.count(cause) > 0) continue;
    double acts = 0.0;
    for (std::size_t i = 0; i < answer.sample.visits.size(); ++i)
      for (const Acting& a : answer.sample.visits[i].set)
        if (problem.shapes[static_cast<std::size_t>(a.shape)].cause == cause)
          acts += answer.sample.weights[i];
    if (acts > kLikelierThanNot) parts.push_back(shapeOf(answer.sample, problem, cause));
  }
  return parts;
}

}  // namespace

void findNamed(const Questions& q, const PosteriorProblem& problem, PosteriorAnswer& out) {
  ActingSet named;
  for (const Slot& slot : out.slots) {
    const Acting a = slot.named ? shapeOf(out.sample, problem, slot.causes.front()) : Acting{-1, 0};
    if (a.shape >= 0) named.push_back(a);
  }
  const auto firstPart = static_cast<long>(named.size());
  const ActingSet parts = partsOfNamed(problem, out);
  named.insert(named.end(), parts.begin(), parts.end());
  // the noise beside what is named, and what comes with it: what else may act has to be told as noise
  const NoiseState* densest = nullptr;
  double most = 0.0;
  for (const auto& view : out.sample.pool) {  // made again: that of the sample may have outlived its problem
    const double density = NoiseView(problem, view->state()).logDensity(named);
    if (densest == nullptr || density > most) densest = &view->state(), most = density;
  }
  out.curveNames.clear();
  out.found = explanationOf(q, problem, named, *densest, &out.curveNames);
  std::vector<Member>& members = out.found.members;
  const auto part = members.begin() + firstPart, end = part + static_cast<long>(parts.size());
  out.parts.assign(part, end);
  members.erase(part, end);
  for (CurveName& name : out.curveNames)
    name.probability *= out.sample.inclusion[static_cast<std::size_t>(name.curve)];
}

PosteriorAnswer answerOf(const Questions& q, const PosteriorProblem& problem, PosteriorSample sample) {
  PosteriorAnswer out;
  out.sample = std::move(sample);
  out.slots = slotsOf(out.sample);
  for (std::size_t c = 0; c < problem.causes.size(); ++c) {
    const Acting a = shapeOf(out.sample, problem, static_cast<int>(c));
    out.likeliest.push_back(a.shape < 0 ? -1 : a.shape - problem.causes[c].first);
  }
  findNamed(q, problem, out);
  return out;
}

Explanation withParts(const Questions& q, const PosteriorAnswer& answer, Explanation found) {
  const std::size_t named = found.members.size();
  for (const Member& part : answer.parts) {
    const std::string& key = q.groups.groups[static_cast<std::size_t>(part.group)].key;
    bool comes = false;
    for (std::size_t j = 0; j < named; ++j)
      comes |= q.groups.groups[static_cast<std::size_t>(found.members[j].group)].parts.count(key) > 0;
    if (comes) found.members.push_back(part);
  }
  return found;
}

bool PosteriorAnswer::doubt(int group, double probability) {
  std::set<int> before, after;
  const auto leadersOf = [this](std::set<int>& named) {
    for (const Slot& slot : slots)
      if (slot.named) named.insert(slot.causes.front());
  };
  leadersOf(before);
  doubted.insert(group);
  sample.inclusion[static_cast<std::size_t>(group)] *= probability;
  slots = slotsOf(sample, doubted);
  leadersOf(after);
  return !std::includes(before.begin(), before.end(), after.begin(), after.end());
}

EffectSpec specOf(const Questions& q, const PosteriorAnswer& answer, int cause) {
  const Group& g = q.groups.groups[static_cast<std::size_t>(cause)];
  const int shape = std::max(0, answer.likeliest[static_cast<std::size_t>(cause)]);
  const Shape& s = g.shapes[static_cast<std::size_t>(shape)];
  return s.mixed.empty() ? s.effect->shapedAs(s.nonlinear) : s.spec;
}

namespace {

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

/// Causes that no slot that is named has, and that nothing told stands for.
void takePossible(const Questions& q, const PosteriorAnswer& answer, Diagnosis& out) {
  const Domain& domain = q.space->problem().model().domain();
  std::set<std::string> told;
  for (const CandidateResult& r : out.missing) told.insert(causeOf(*createEffect(r.effect, domain)));
  for (const ProfileResult& p : out.profiles) told.insert(causeOf(*createEffect(p.effect, domain)));
  for (const Slot& slot : answer.slots)
    if (slot.named)
      for (const int c : slot.causes) told.insert(q.groups.groups[static_cast<std::size_t>(c)].key);
  for (std::size_t g = 0; g < answer.sample.inclusion.size(); ++g) {
    const double probability = odds(answer.sample, answer.sample.inclusion[g]);
    if (probability < kPossible || told.count(q.groups.groups[g].key) > 0) continue;
    const EffectSpec spec = specOf(q, answer, static_cast<int>(g));
    out.possible.push_back({spec, probability, createEffect(spec, domain)->shownBy()});
  }
  std::stable_sort(out.possible.begin(), out.possible.end(),
                   [](const PossibleCause& a, const PossibleCause& b) { return a.odds > b.odds; });
}

}  // namespace

void takeOdds(const Questions& q, const PosteriorAnswer& answer, Diagnosis& out) {
  const Domain& domain = q.space->problem().model().domain();
  for (CandidateResult& r : out.missing)
    for (const CurveName& name : answer.curveNames)
      if (causeOf(*createEffect(r.effect, domain)) ==
          q.groups.groups[static_cast<std::size_t>(name.cause)].key)
        r.odds = odds(answer.sample, name.probability);
  for (ProfileResult& p : out.profiles) {
    const std::string key = causeOf(*createEffect(p.effect, domain));
    for (std::size_t g = 0; g < answer.sample.inclusion.size(); ++g)
      if (q.groups.groups[g].key == key) p.odds = odds(answer.sample, answer.sample.inclusion[g]);
  }
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
  }
  takePossible(q, answer, out);
  const std::size_t sampled = answer.sample.inclusion.size();
  for (CandidateResult& r : out.candidates) {
    const std::string key = causeOf(*createEffect(r.effect, domain));
    for (std::size_t g = 0; g < sampled + answer.rest.size(); ++g)
      if (q.groups.groups[g].key == key)
        r.odds = odds(answer.sample, g < sampled ? answer.sample.inclusion[g] : answer.rest[g - sampled]);
  }
  std::stable_sort(out.candidates.begin(), out.candidates.end(),
                   [](const CandidateResult& a, const CandidateResult& b) { return a.odds > b.odds; });
}

}  // namespace mm
