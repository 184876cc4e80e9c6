#include "diagnosis/search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "diagnosis/shape_maker.h"

namespace mm {
namespace {

constexpr int kMostMembers = 10;
/// A free curve imitates whatever has a name: it must be this much more likely, for each of its variables.
constexpr double kUnnamed = 100.0;
constexpr int kTrials = 3;              // candidates whose noise is fitted again from none
constexpr double kFiner = 1e-3;         // nats that a step of a nonlinear parameter must bring
constexpr double kClearlyBetter = 0.5;  // nats by which another cause must be better to take a place
constexpr double kExchange = 1.0;       // nats that an exchange of one for two must bring

std::string idOf(int group, int shape, const std::vector<double>& nonlinear) {
  std::string id = std::to_string(group) + "/" + std::to_string(shape);
  for (const double v : nonlinear) {
    char text[40];
    std::snprintf(text, sizeof text, "/%.17g", v);
    id += text;
  }
  return id;
}

}  // namespace

double Search::priceOfOne(const Group& g) const {
  const double asked = g.variables == 2 ? q_.asked + q_.profiles + q_.pairs
                       : g.profile      ? q_.asked + q_.profiles
                                        : q_.asked;
  return std::log(std::max(1.0, asked)) + std::log(kPriorOdds) + g.variables * std::log(kUnnamed);
}

double Search::priceOf(const Member& member) const {
  return (member.partner.empty() ? priceOf(member.group) : member.priceAsPartner) +
         q_.groups.groups[member.group].priceOfShape() + member.priceOfSize;
}

std::shared_ptr<const Evidence> Search::evidenceAt(const Explanation& at,
                                                   const std::vector<char>* heldOut) const {
  const auto sameDrift = [](const std::vector<DriftTerm>& a, const std::vector<DriftTerm>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const DriftTerm& s, const DriftTerm& t) {
      return s.direction == t.direction && s.ratio == t.ratio && s.tau == t.tau && s.smooth == t.smooth;
    });
  };
  if (heldOut == nullptr)
    for (const Known& k : known_)
      if (k.scatter == at.scatter && sameDrift(k.noise.drift, at.noise.drift) &&
          k.noise.variance == at.noise.variance)
        return k.evidence;
  std::vector<RandomBlock> blocks;
  for (std::size_t b = 0; b < q_.scatter.size(); ++b)
    if (at.scatter[b] > 0.0) {
      blocks.push_back(q_.scatter[b]);
      blocks.back().ratio = at.scatter[b];
    }
  auto evidence = std::make_shared<const Evidence>(q_.rows, q_.groups, at.noise, std::move(blocks), heldOut);
  if (heldOut != nullptr) return evidence;
  constexpr std::size_t kKept = 3;
  if (known_.size() == kKept) known_.erase(known_.begin());
  known_.push_back({at.noise, at.scatter, evidence});
  return evidence;
}

std::vector<RandomBlock> Search::blocksOf(const std::vector<Member>& members,
                                          const std::vector<double>& scatter, bool all,
                                          std::vector<int>& ofBlock) const {
  std::vector<RandomBlock> blocks;
  for (std::size_t b = 0; b < q_.scatter.size(); ++b)
    if (all || scatter[b] > 0.0) {
      blocks.push_back(q_.scatter[b]);
      if (!blocks.back().fixed) blocks.back().ratio = scatter[b];
      ofBlock.push_back(static_cast<int>(b));
    }
  for (const Member& m : members) blocks.push_back({*m.columns, m.size, 0.0, false});
  return blocks;
}

double Search::whiteStdOf(const Explanation& found) const {
  std::vector<int> ofBlock;
  const NoiseFit fit(q_.rows, blocksOf(found.members, found.scatter, false, ofBlock));
  NoiseFitResult at;
  at.noise = found.noise;
  for (const int b : ofBlock) at.ratios.push_back(found.scatter[static_cast<std::size_t>(b)]);
  for (const Member& m : found.members) at.ratios.push_back(m.size);
  at.white = found.white;
  at.whiteStd = found.whiteStd;
  at.freedoms = std::max<double>(1.0, q_.rows.length() - static_cast<double>(q_.rows.base.cols()));
  return fit.whiteStdOf(at, {});
}

Explanation Search::refitted(const std::vector<Member>& members, const Explanation& start, bool add,
                             int along) const {
  CancelScope::check();
  Explanation out;
  out.members = members;
  std::vector<int> ofBlock;
  std::vector<RandomBlock> blocks = blocksOf(members, start.scatter, add, ofBlock);
  const std::size_t scatter = ofBlock.size();
  NoiseFitOptions options;
  options.addDrift = add;
  options.addAlong = along;
  if (!add || along >= 0) options.rounds = 2;
  const auto approach = std::find(q_.directions.begin(), q_.directions.end(), "approach");
  if (approach != q_.directions.end())
    options.constantIsACause = static_cast<int>(approach - q_.directions.begin());
  const NoiseFitResult fit = q_.many ? fitManyRows(q_.rows, std::move(blocks), start.noise, options)
                                     : NoiseFit(q_.rows, std::move(blocks)).run(start.noise, options);
  out.noise = fit.noise;
  out.scatter.assign(q_.scatter.size(), 0.0);
  for (std::size_t k = 0; k < scatter; ++k) out.scatter[ofBlock[k]] = fit.ratios[k];
  for (std::size_t k = 0; k < members.size(); ++k)
    out.members[k].size = std::max(kSmallestSize, fit.ratios[scatter + k]);
  out.logEvidence = fit.logEvidence;
  out.white = fit.white;
  out.whiteStd = fit.whiteStd;
  out.worth = out.logEvidence;
  payInFullAlone(out.members);
  for (const Member& m : out.members) out.worth -= priceOf(m);
  return out;
}

void Search::payInFullAlone(std::vector<Member>& members) const {
  for (Member& m : members) {
    const bool alone = std::none_of(members.begin(), members.end(), [&](const Member& other) {
      return &other != &m && q_.groups.groups[other.group].key == m.partner;
    });
    if (alone) m.partner.clear();
  }
}

Member Search::memberOf(const Gain& gain) const {
  const Shape& shape = q_.groups.groups[gain.group].shapes[gain.shape];
  Member m;
  m.group = gain.group;
  m.shape = gain.shape;
  m.nonlinear = shape.nonlinear;
  takeSize(m, gain);
  m.columns = std::make_shared<RowMatrix>(q_.groups.columns.middleCols(shape.first, shape.count));
  m.id = idOf(m.group, m.shape, {});
  return m;
}

void Search::takeSize(Member& member, const Gain& gain) const {
  member.size = std::max(kSmallestSize, gain.size);
  member.priceOfSize = q_.groups.groups[member.group].shapes[member.shape].priceOfSize(gain.coefficient);
}

Member Search::moved(Member member, int group) const {
  member.group = group;
  member.id = idOf(group, member.shape, member.nonlinear);
  return member;
}

bool Search::isThere(const std::vector<Member>& members, const Gain& gain) const {
  if (gain.group < 0) return false;
  const Shape& shape = q_.groups.groups[gain.group].shapes[gain.shape];
  const bool curve = q_.groups.groups[gain.group].profile;  // one of a variable is enough
  const bool saidByAKey =
      !curve && (shape.nonlinear.empty() || !(shape.effect->shapedAs(shape.nonlinear) == shape.spec));
  return std::any_of(members.begin(), members.end(), [&](const Member& m) {
    return m.group == gain.group && (m.shape == gain.shape || !saidByAKey);
  });
}

Member Search::refined(const Evidence& evidence, const std::vector<Member>& others,
                       const Member& member) const {
  Member best = member;
  const Shape& shape = q_.groups.groups[member.group].shapes[member.shape];
  const Evidence::Given given = evidence.given(others);
  if (member.nonlinear.empty()) {
    takeSize(best, evidence.gainOf(given, others, *member.columns));
    return best;
  }
  const GroupColumns make(*q_.space);
  const std::vector<int> parameters = shape.effect->nonlinearParameters();
  double most = evidence.gainOf(given, others, *member.columns).value;
  std::vector<double> steps = {0.03, 0.01, 0.003, 0.001, 0.0003};
  if (!shape.effect->fineWaves().lengths.empty()) steps.insert(steps.end(), {1e-4, 3e-5});  // of many waves
  for (std::size_t k = 0; k < best.nonlinear.size(); ++k)
    for (const double step : steps)
      for (const double sign : {1.0, -1.0})
        for (int again = 0; again < 6; ++again) {
          std::vector<double> at = best.nonlinear;
          at[k] *= 1.0 + sign * step;
          const Parameter& limits = shape.effect->parameters()[static_cast<std::size_t>(parameters[k])];
          if (at[k] < limits.minimum || at[k] > limits.maximum || !shape.effect->mayBeClaimed(at)) break;
          RowMatrix columns = make(shape.effect, at);
          if (columns.cols() == 0) break;
          const Gain gain = evidence.gainOf(given, others, columns);
          if (!(gain.value > most + kFiner)) break;
          most = gain.value;
          best.nonlinear = at;
          takeSize(best, gain);
          best.columns = std::make_shared<RowMatrix>(std::move(columns));
          best.id = idOf(best.group, best.shape, best.nonlinear);
        }
  return best;
}

std::vector<Member> Search::exchangedAt(const Evidence& evidence, std::vector<Member> members,
                                        bool* changed) const {
  *changed = false;
  for (std::size_t j = 0; j < members.size(); ++j) {
    CancelScope::check();
    std::vector<Member> others = members;
    others.erase(others.begin() + static_cast<long>(j));
    const Evidence::Given given = evidence.given(others);
    const Gain own = evidence.gainOf(given, others, *members[j].columns);
    takeSize(members[j], own);
    const double now = own.value - priceOf(members[j]);
    Gain best;
    double most = -1e300;
    const std::vector<Gain> gains = evidence.gains(given);
    for (const Gain& g : gains) {
      if (isThere(others, g)) continue;
      if (g.value - priceOf(g.group) > most) most = g.value - priceOf(g.group), best = g;
    }
    if (best.group >= 0) best = commoner(best, gains, others);
    const bool nameForCurve = q_.groups.groups[members[j].group].profile && best.group >= 0 &&
                              !q_.groups.groups[best.group].profile;
    // another one must be better, and a profile clearly better than a cause with a name
    const bool named = !q_.groups.groups[members[j].group].profile;
    double margin = kClearlyBetter;
    if (best.group >= 0 && q_.groups.groups[best.group].profile && named) {
      const auto explained = [&](double gain) { return -std::expm1(-2.0 * gain / given.freedoms); };
      margin = explained(own.value) > kMostOfIt * explained(best.value) ? 1e300 : kIndistinct;
    }
    if (best.group >= 0 && (best.group != members[j].group || best.shape != members[j].shape) &&
        (most > now + margin || (nameForCurve && best.value > priceOf(best.group)))) {
      members[j] = refined(evidence, others, memberOf(best));
      *changed = true;
    }
  }
  return members;
}

Explanation Search::exchanged(Explanation best) const {
  for (int round = 0; round < 3 && !best.members.empty(); ++round) {
    const auto evidence = evidenceAt(best);
    bool changed = false;
    std::vector<Member> members = exchangedAt(*evidence, best.members, &changed);
    // one goes, and what is best beside the rest comes, perhaps two in its place
    if (!changed && members.size() > 1 && round == 0) {
      double mostGain = 0.0;
      std::vector<Member> mostMembers;
      const double now = worthAt(*evidence, members);
      for (std::size_t j = 0; j < members.size(); ++j) {
        CancelScope::check();
        std::vector<Member> others = members;
        others.erase(others.begin() + static_cast<long>(j));
        for (int more = 0; more < 2; ++more) {
          const std::vector<Gain> gains = evidence->gains(evidence->given(others));
          Gain pick;
          double most = 0.0;
          for (const Gain& g : gains)
            if (g.group != members[j].group && !isThere(others, g) && g.value - priceOf(g.group) > most)
              most = g.value - priceOf(g.group), pick = g;
          if (pick.group < 0) break;
          others.push_back(refined(*evidence, others, memberOf(commoner(pick, gains, others))));
          bool again = false;
          const std::vector<Member> settled = exchangedAt(*evidence, others, &again);
          const double gain = worthAt(*evidence, settled) - now;
          if (gain > std::max(kExchange, mostGain)) mostGain = gain, mostMembers = settled;
        }
      }
      if (!mostMembers.empty()) members = mostMembers, changed = true;
    }
    if (!changed) {
      best.members = members;
      break;
    }
    Explanation next = refitted(members, best, false);
    if (next.worth <= best.worth) break;
    best = std::move(next);
  }
  return best;
}

Explanation Search::grown(Explanation best, bool bare) const {
  while (static_cast<int>(best.members.size()) < kMostMembers) {
    // drift and scatter that were fitted without a cause have absorbed it: ask from none of them, too
    std::vector<Explanation> starts = {best};
    if (driftsOrScatters(best)) starts.push_back(withoutDriftAndScatter(best));
    Explanation next;
    next.worth = -1e300;
    for (std::size_t s = 0; s < starts.size(); ++s) {
      const auto evidence = evidenceAt(starts[s]);
      std::vector<Gain> gains = evidence->gains(evidence->given(best.members));
      for (Gain& g : gains) g.value -= priceOf(g.group);
      std::stable_sort(gains.begin(), gains.end(),
                       [](const Gain& a, const Gain& b) { return a.value > b.value; });
      int tried = 0;
      for (const Gain& g : gains) {
        if (tried == (s == 0 ? 1 : kTrials) || g.value < (starts.size() == 1 ? 0.0 : -kWorthTrying)) break;
        if (isThere(best.members, g)) continue;
        ++tried;
        std::vector<Member> members = best.members;
        members.push_back(refined(*evidence, best.members, memberOf(commoner(g, gains, best.members))));
        // with the cause in at the size that it has without them, drift and scatter must earn their place
        // again
        Explanation trial = refitted(members, best, false);
        if (trial.worth > next.worth) next = std::move(trial);
      }
    }
    if (!(next.worth > best.worth)) break;
    next = refitted(next.members, next, !bare);
    next = exchanged(std::move(next));
    if (!(next.worth > best.worth)) break;
    best = std::move(next);
  }
  return best;
}

bool Search::driftsOrScatters(const Explanation& found) const {
  bool scatters = false;
  for (std::size_t b = 0; b < q_.scatter.size(); ++b)
    scatters = scatters || (!q_.scatter[b].fixed && found.scatter[b] > 0.0);
  return scatters || !found.noise.drift.empty();
}

Explanation Search::withoutDriftAndScatter(Explanation found) const {
  found.noise.drift.clear();
  for (std::size_t b = 0; b < q_.scatter.size(); ++b)
    if (!q_.scatter[b].fixed) found.scatter[b] = 0.0;
  return found;
}

Explanation Search::pruned(Explanation best) const {
  for (bool again = true; again && !best.members.empty();) {
    again = false;
    Explanation most;
    most.worth = -1e300;
    const auto evidence = evidenceAt(best);
    for (std::size_t j = 0; j < best.members.size(); ++j) {
      const std::vector<Member> named = beside(*evidence, best.members, j);
      if (named.size() + 1 < best.members.size() &&
          evidence->gainOf(evidence->given(named), named, *best.members[j].columns).value >
              priceOf(best.members[j]))
        continue;  // the curve is for the rest
      std::vector<Member> others = best.members;
      others.erase(others.begin() + static_cast<long>(j));
      // without it, drift may take its place
      const bool time = q_.groups.groups[best.members[j].group].dependsOnTime || !best.noise.drift.empty();
      Explanation without = refitted(others, best, time);
      if (without.worth > most.worth) most = std::move(without);
    }
    if (most.worth >= best.worth) {
      best = std::move(most);
      again = true;
    }
  }
  return best;
}

Explanation Search::none(const Eigen::VectorXd& variance) const {
  Explanation start;
  start.noise.variance = variance;
  start.scatter.assign(q_.scatter.size(), 0.0);
  for (std::size_t b = 0; b < q_.scatter.size(); ++b)
    if (q_.scatter[b].fixed) start.scatter[b] = q_.scatter[b].ratio;
  return refitted({}, start, true);
}

std::vector<Member> Search::grownHeld(const Evidence& evidence, std::vector<Member> members) const {
  while (static_cast<int>(members.size()) < kMostMembers) {
    const Evidence::Given given = evidence.given(members);
    Gain pick;
    pick.value = 0.0;
    const std::vector<Gain> gains = evidence.gains(given);
    for (const Gain& g : gains) {
      if (isThere(members, g)) continue;
      const double gain = g.value - priceOf(g.group);
      if (gain > pick.value) pick = g, pick.value = gain;
    }
    if (pick.group < 0) break;
    Gain whole = pick;
    whole.value += priceOf(pick.group);
    pick = commoner(whole, gains, members);
    members.push_back(refined(evidence, members, memberOf(pick)));
    for (int round = 0; round < 2; ++round) {
      bool changed = false;
      members = exchangedAt(evidence, members, &changed);
      if (!changed) break;
    }
  }
  return members;
}

}  // namespace mm
