// Causes that only two together show.
#include <algorithm>
#include <cmath>
#include <map>

#include "base/cancel_scope.h"
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

/// Looks for pairs at one model of the noise.
class PairSeeker {
 public:
  PairSeeker(const Search& search, const Evidence& evidence, const std::vector<Member>& members)
      : search_(search),
        q_(search.questions()),
        evidence_(evidence),
        members_(members),
        now_(evidence.given(members).logEvidence - priceOfAll(members)),
        besideAll_(q_.groups.groups.size(), -1e300) {
    for (const Gain& g : evidence.gains(evidence.given(members)))
      if (g.group >= 0) besideAll_[static_cast<std::size_t>(g.group)] = g.value;
  }

  /// In the place of a member, or of two.
  void inPlaces() {
    const double price = std::log(std::max(1.0, static_cast<double>(q_.asked))) + std::log(kOneMore);
    for (const std::vector<std::size_t>& leaving : leavingSets(members_.size(), q_.many)) {
      // asked beside the curve for its rest, any two would do as well as a cause that has a name
      if (std::any_of(leaving.begin(), leaving.end(),
                      [&](std::size_t j) { return search_.hasCurve(evidence_, members_, j); }))
        continue;
      others_.clear();
      barred_.clear();
      leaving_ = leaving;
      for (std::size_t j = 0; j < members_.size(); ++j)
        if (std::find(leaving.begin(), leaving.end(), j) == leaving.end())
          others_.push_back(members_[j]);
        else
          barred_.push_back(members_[j].group);
      for (const Gain& g : seeds()) tryWith(search_.memberOf(g), nullptr, price);
    }
  }

  /// Beside all members: two laws of the same joints, of which the first may be much larger than what the two
  /// leave together.
  void ofJoints() {
    std::map<std::vector<int>, std::vector<int>> groups;  // joints: the causes that are laws of these
    for (std::size_t g = 0; g < q_.groups.groups.size(); ++g)
      if (!q_.groups.groups[g].profile) groups[jointsOf(q_.groups.groups[g])].push_back(static_cast<int>(g));
    groups.erase(std::vector<int>{});
    others_ = members_;
    barred_.clear();
    leaving_.clear();
    const Evidence::Given given = evidence_.given(members_);
    const double large = kCancels * std::sqrt(given.rest / std::max(1.0, given.freedoms));
    for (const auto& [joints, alike] : groups)
      for (const int group : alike) {
        const Gain g = evidence_.gainOf(given, group);
        if (g.group < 0 || search_.isThere(members_, g)) continue;
        Member seed = search_.memberOf(g);
        seed.size = std::max(seed.size, large);
        tryWith(seed, &alike, std::log(static_cast<double>(alike.size())) + std::log(kOneMore));
      }
  }

  /// The best, at most `kMostTrials`.
  std::vector<Search::Pair> best() {
    std::stable_sort(pairs_.begin(), pairs_.end(),
                     [](const Search::Pair& a, const Search::Pair& b) { return a.worth > b.worth; });
    pairs_.resize(std::min(pairs_.size(), kMostTrials));
    return std::move(pairs_);
  }

 private:
  double priceOfAll(const std::vector<Member>& of) const {
    double sum = 0.0;
    for (const Member& m : of) sum += search_.priceOf(m);
    return sum;
  }

  /// Whether a cause may come beside these.
  bool mayCome(const Gain& g, const std::vector<Member>& beside) const {
    return g.group >= 0 && !q_.groups.groups[static_cast<std::size_t>(g.group)].profile &&
           std::count(barred_.begin(), barred_.end(), g.group) == 0 && !search_.isThere(beside, g);
  }

  /// What gains most beside the others, less its price.
  std::vector<Gain> seeds() const {
    std::vector<Gain> seeds;
    for (const Gain& g : evidence_.gains(evidence_.given(others_)))
      if (mayCome(g, others_)) seeds.push_back(g);
    std::stable_sort(seeds.begin(), seeds.end(), [&](const Gain& a, const Gain& b) {
      return a.value - search_.priceOf(a.group) > b.value - search_.priceOf(b.group);
    });
    seeds.resize(std::min(seeds.size(), q_.many ? kMostSeeds / 2 : kMostSeeds));
    return seeds;
  }

  /// What `seed` and the best beside it are worth. @param from groups that the second may be of; null: all.
  /// @param price of the second, of which the first says that something acts.
  void tryWith(const Member& seed, const std::vector<int>* from, double price) {
    CancelScope::check();
    Search::Pair pair;
    pair.members = others_;
    pair.members.push_back(seed);
    const Evidence::Given given = evidence_.given(pair.members);
    Gain second;
    double most = 0.0;
    // what shows as well beside what would go is no partner: else another name of that would let anything in
    const auto alone = [&](const Gain& g) {
      return !leaving_.empty() && besideAll_[static_cast<std::size_t>(g.group)] > g.value - kIndistinct;
    };
    const auto consider = [&](const Gain& g) {
      if (g.value - price > most && mayCome(g, pair.members) && !alone(g)) most = g.value - price, second = g;
    };
    if (from == nullptr)
      for (const Gain& g : evidence_.gains(given)) consider(g);
    else
      for (const int group : *from) consider(evidence_.gainOf(given, group));
    if (second.group < 0) return;
    pair.worth = given.logEvidence + most - priceOfAll(pair.members) - now_;
    if (!(pair.worth > -kWorthTrying)) return;
    // each must earn its place beside the other, whichever came first: else one is another name of what went
    const Evidence::Given without = evidence_.given(others_);
    const double withSecond = without.logEvidence + evidence_.gainOf(without, second.group).value;
    if (!(given.logEvidence + second.value - withSecond > price)) return;
    pair.members.push_back(search_.memberOf(second));
    pair.members.back().partner = q_.groups.groups[static_cast<std::size_t>(seed.group)].key;
    pair.members.back().priceAsPartner = price;
    pair.leaving = leaving_;
    pairs_.push_back(std::move(pair));
  }

  const Search& search_;
  const Questions& q_;
  const Evidence& evidence_;
  const std::vector<Member>& members_;
  double now_;                        // worth of the members
  std::vector<double> besideAll_;     // a group: what it would gain beside all members
  std::vector<Member> others_;        // those that stay
  std::vector<int> barred_;           // groups of those that go
  std::vector<std::size_t> leaving_;  // those that go
  std::vector<Search::Pair> pairs_;
};

}  // namespace

std::vector<Search::Pair> Search::likelyPairs(const Evidence& evidence,
                                              const std::vector<Member>& members) const {
  PairSeeker seeker(*this, evidence, members);
  seeker.inPlaces();
  seeker.ofJoints();
  return seeker.best();
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

Explanation Search::withPairsAsRivals(Explanation found) const {
  constexpr double kHalf = 0.5;  // two names of one rival share its odds
  Explanation better;
  better.worth = found.worth;
  for (const Pair& pair : likelyPairs(*evidenceAt(found), found.members)) {
    Explanation trial = refitted(pair.members, found, true);
    const double behind = found.worth - trial.worth;
    if (trial.worth > better.worth) better = std::move(trial);
    if (behind > kIndistinct) continue;
    for (const std::size_t member : pair.leaving)
      for (std::size_t k = pair.members.size() - 2; k < pair.members.size(); ++k)
        found.rivals.push_back({member, pair.members[k].group, pair.members[k].shape, behind, kHalf});
  }
  return better.members.empty() ? found : settled(std::move(better));
}

}  // namespace mm
