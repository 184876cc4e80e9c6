// Causes that only two together show.
#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/search.h"

namespace mm {
namespace {

constexpr std::size_t kMostSeeds = 8;   // in the place of a member
constexpr std::size_t kMostTrials = 2;  // pairs whose noise is fitted again, at each model of the noise
/// What the larger of two that cancel may be, over what they leave together.
constexpr double kCancels = 10.0;

/// What a further cause must outweigh beside the number of those asked, once one acts: it is even odds.
constexpr double kOneMore = 2.0;

/// The joints of whose position a cause is a law.
std::vector<int> jointsOf(const Group& group) {
  return group.shapes.empty() ? std::vector<int>{} : group.shapes.front().effect->mustMove();
}

/// Which members go, that two others may come: each, and each two of few.
std::vector<std::vector<std::size_t>> leavingSets(std::size_t members, bool many) {
  constexpr std::size_t kFew = 4;
  std::vector<std::vector<std::size_t>> sets;
  for (std::size_t j = 0; j < members; ++j) sets.push_back({j});
  for (std::size_t j = 0; j < members && members <= kFew && !many; ++j)
    for (std::size_t k = j + 1; k < members; ++k) sets.push_back({j, k});
  return sets;
}

}  // namespace

std::vector<Search::Pair> Search::likelyPairs(const Evidence& evidence,
                                              const std::vector<Member>& members) const {
  std::vector<Pair> pairs;
  const auto groupOf = [&](const Gain& g) -> const Group& {
    return q_.groups.groups[static_cast<std::size_t>(g.group)];
  };
  const auto priceOfAll = [&](const std::vector<Member>& of) {
    double sum = 0.0;
    for (const Member& m : of) sum += priceOf(m);
    return sum;
  };
  const double now = evidence.given(members).logEvidence - priceOfAll(members);
  // What `seed` and the best beside it are worth. @param barred causes that neither may be. @param same null:
  // all others may come; else these groups. @param price of the second, of which the first says that
  // something acts.
  const auto tryWith = [&](const std::vector<Member>& others, const Member& seed,
                           const std::vector<int>& barred, const std::vector<int>* same, double price,
                           const std::vector<std::size_t>& leaving) {
    tick();
    Pair pair;
    pair.members = others;
    pair.members.push_back(seed);
    const Evidence::Given given = evidence.given(pair.members);
    Gain second;
    double most = -1e300;
    const auto consider = [&](const Gain& g) {
      if (g.group < 0 || groupOf(g).profile || isThere(pair.members, g) ||
          std::count(barred.begin(), barred.end(), g.group) > 0)
        return;
      if (g.value - price > most) most = g.value - price, second = g;
    };
    if (same == nullptr) {
      for (const Gain& g : evidence.gains(given)) consider(g);
    } else {
      for (const int group : *same) consider(evidence.gainOf(given, group));
    }
    if (!(most > 0.0)) return;
    pair.worth = given.logEvidence + most - priceOfAll(pair.members) - now;
    if (!(pair.worth > -kWorthTrying)) return;
    // each must earn its place beside the other: else one of them is another name of what went
    std::vector<Member> secondAlone = others;
    secondAlone.push_back(memberOf(second));
    if (!(given.logEvidence + second.value - evidence.given(secondAlone).logEvidence > priceOf(seed))) return;
    pair.members.push_back(memberOf(second));
    pair.members.back().partner = q_.groups.groups[static_cast<std::size_t>(seed.group)].key;
    pair.members.back().priceAsPartner = price;
    pair.leaving = leaving;
    pairs.push_back(std::move(pair));
  };
  const double ofAny = std::log(std::max(1.0, static_cast<double>(q_.asked))) + std::log(kOneMore);
  for (const std::vector<std::size_t>& leaving : leavingSets(members.size(), q_.many)) {
    // asked beside the curve for its rest, any two would do as well as a cause that has a name
    if (std::any_of(leaving.begin(), leaving.end(),
                    [&](std::size_t j) { return hasCurve(evidence, members, j); }))
      continue;
    std::vector<Member> others;
    std::vector<int> barred;
    for (std::size_t j = 0; j < members.size(); ++j)
      if (std::find(leaving.begin(), leaving.end(), j) == leaving.end())
        others.push_back(members[j]);
      else
        barred.push_back(members[j].group);
    std::vector<Gain> seeds;
    for (const Gain& g : evidence.gains(evidence.given(others)))
      if (g.group >= 0 && std::count(barred.begin(), barred.end(), g.group) == 0 && !groupOf(g).profile &&
          !isThere(others, g))
        seeds.push_back(g);
    std::stable_sort(seeds.begin(), seeds.end(), [&](const Gain& a, const Gain& b) {
      return a.value - priceOf(a.group) > b.value - priceOf(b.group);
    });
    seeds.resize(std::min(seeds.size(), q_.many ? kMostSeeds / 2 : kMostSeeds));
    for (const Gain& g : seeds) tryWith(others, memberOf(g), barred, nullptr, ofAny, leaving);
  }
  std::map<std::vector<int>, std::vector<int>> ofJoints;  // joints: the causes that are laws of these
  for (std::size_t g = 0; g < q_.groups.groups.size(); ++g)
    if (!q_.groups.groups[g].profile) ofJoints[jointsOf(q_.groups.groups[g])].push_back(static_cast<int>(g));
  const Evidence::Given given = evidence.given(members);
  for (const auto& [joints, alike] : ofJoints)
    for (const int group : joints.empty() ? std::vector<int>{} : alike) {
      const Gain g = evidence.gainOf(given, group);
      if (g.group < 0 || isThere(members, g)) continue;
      Member seed = memberOf(g);
      seed.size = std::max(seed.size, kCancels * std::sqrt(given.rest / std::max(1.0, given.freedoms)));
      tryWith(members, seed, {}, &alike, std::log(static_cast<double>(alike.size())) + std::log(kOneMore),
              {});
    }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.worth > b.worth; });
  pairs.resize(std::min(pairs.size(), kMostTrials));
  return pairs;
}

Explanation Search::paired(const Explanation& best) const {
  std::vector<Explanation> starts = {best};
  if (driftsOrScatters(best)) starts.push_back(withoutDriftAndScatter(best));
  Explanation next;
  next.worth = -1e300;
  for (const Explanation& start : starts)
    for (const Pair& pair : likelyPairs(*evidenceAt(start), best.members)) {
      if (starts.size() == 1 && !(pair.worth > 0.0)) break;
      Explanation trial = refitted(pair.members, best, false);
      if (trial.worth > next.worth) next = std::move(trial);
    }
  if (!(next.worth > best.worth)) return best;
  return exchanged(refitted(next.members, next, true));
}

void Search::addPairsToRivals(Explanation& found) const {
  for (const Pair& pair : likelyPairs(*evidenceAt(found), found.members)) {
    const Explanation trial = refitted(pair.members, found, true);
    const double behind = found.worth - trial.worth;
    if (behind > kIndistinct) continue;
    for (const std::size_t member : pair.leaving)
      for (std::size_t k = pair.members.size() - 2; k < pair.members.size(); ++k)
        found.rivals.push_back({member, pair.members[k].group, pair.members[k].shape, behind});
  }
}

}  // namespace mm
