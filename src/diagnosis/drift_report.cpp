#include "diagnosis/drift_report.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/wording.h"
#include "machine/units.h"

namespace mm {
namespace {

const double kSaid = std::log(100.0);  // nats: drift that is not there at 100 to 1 is not spoken of
constexpr std::size_t kMostAsked = 2;  // causes from each start
constexpr double kSomeShare = 0.3;  // of a drift's variance: what a cause must take over to be what it may be
constexpr double kHopeless = -3.0;  // nats against drift alone

double varianceAlong(const NoiseModel& noise, int direction, double white) {
  double sum = 0.0;
  for (const DriftTerm& t : noise.drift)
    if (t.direction == direction) sum += t.ratio * t.ratio * white * white;
  return sum;
}

}  // namespace

std::vector<DriftResult> driftOf(const Search& search, const Explanation& found) {
  const Questions& q = search.questions();
  std::vector<DriftResult> results;
  std::vector<int> directions;
  for (int d = 0; d < static_cast<int>(q.directions.size()); ++d) {
    if (!(varianceAlong(found.noise, d, found.white) > 0.0)) continue;
    Explanation without = found;
    auto& drift = without.noise.drift;
    drift.erase(
        std::remove_if(drift.begin(), drift.end(), [&](const DriftTerm& t) { return t.direction == d; }),
        drift.end());
    without = search.refitted(found.members, without, false);
    if (found.logEvidence - without.logEvidence < kSaid) continue;
    DriftResult r;
    r.direction = q.directions[d];
    r.std = std::sqrt(varianceAlong(found.noise, d, found.white)) * q.directionScale[d];
    double largest = 0.0;
    for (const DriftTerm& t : found.noise.drift)
      if (t.direction == d && t.ratio > largest) largest = t.ratio, r.timeConstant = t.tau;
    results.push_back(std::move(r));
    directions.push_back(d);
  }
  if (results.empty()) return results;

  // which causes take it over? those that show most where there is no drift, and those that show beside it
  Explanation none = found;
  none.noise.drift.clear();
  struct Trial {
    int group;
    double delta;
    Explanation with;
  };
  std::vector<Trial> trials;
  for (const Explanation* start : {static_cast<const Explanation*>(&none), &found}) {
    const auto evidence = search.evidenceAt(*start);
    std::size_t count = 0;
    for (const Gain& g : evidence->gains(evidence->given(found.members))) {
      const Group& group = q.groups.groups[g.group];
      if (!group.dependsOnTime || group.profile || !(g.value > 0.0)) continue;
      const auto known = [&](const auto& other) { return other.group == g.group; };
      if (std::any_of(found.members.begin(), found.members.end(), known) ||
          std::any_of(trials.begin(), trials.end(), known))
        continue;
      if (++count > kMostAsked) break;
      std::vector<Member> members = found.members;
      members.push_back(search.refined(*evidence, found.members, search.memberOf(g)));
      Trial trial{g.group, -1e300, {}};
      const double price = std::log(static_cast<double>(group.shapes.size()));
      // at the size that it has without drift, which must then earn its place again
      trial.with = search.refitted(members, found, false);
      trial.delta = trial.with.logEvidence - found.logEvidence - price;
      trials.push_back(std::move(trial));
    }
  }
  for (std::size_t r = 0; r < results.size(); ++r) {
    const double before = varianceAlong(found.noise, directions[r], found.white);
    double total = 1.0;  // drift alone
    std::vector<const Trial*> fit;
    for (const Trial& t : trials) {
      const double share = 1.0 - varianceAlong(t.with.noise, directions[r], t.with.white) / before;
      if (t.delta < kHopeless || share < kSomeShare) continue;
      fit.push_back(&t);
      total += std::exp(std::min(50.0, t.delta));
    }
    for (const Trial* t : fit) {
      const Member& m = t->with.members.back();
      const Shape& shape = q.groups.groups[m.group].shapes[m.shape];
      results[r].perhaps.push_back(
          {shape.effect->shapedAs(m.nonlinear), std::exp(std::min(50.0, t->delta)) / total,
           std::min(1.0, 1.0 - varianceAlong(t->with.noise, directions[r], t->with.white) / before)});
    }
    std::stable_sort(results[r].perhaps.begin(), results[r].perhaps.end(),
                     [](const auto& a, const auto& b) { return a.odds > b.odds; });
  }
  return results;
}

}  // namespace mm
