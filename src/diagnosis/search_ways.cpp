// The ways in which the search goes: as it is, with pairs, and as if nothing drifted or scattered.
#include <algorithm>

#include "diagnosis/search.h"

namespace mm {
namespace {

constexpr int kMostPairs = 3;  // of causes that come together
/// Drift or scatter, in units of the white noise, that may be several causes together: what hides in less is
/// no larger than the noise when it is shared among several, and the search costs as much again.
constexpr double kHidesSeveral = 1.0;
constexpr double kAsQuiet =
    1.5;  // white noise that causes alone may leave, over that beside drift and scatter

}  // namespace

bool Search::couldHideSeveral(const Explanation& found) const {
  double most = 0.0;
  for (std::size_t b = 0; b < q_.scatter.size(); ++b)
    if (!q_.scatter[b].fixed) most = std::max(most, found.scatter[b]);
  for (const DriftTerm& term : found.noise.drift) most = std::max(most, term.ratio);
  return most > kHidesSeveral;
}

Explanation Search::bare(const Explanation& found) const {
  return refitted({}, withoutDriftAndScatter(found), false);
}

Explanation Search::causesAlone(Explanation start) const { return grown(std::move(start), true); }

Explanation Search::ofGreaterWorth(Explanation found, const Explanation& causes) const {
  if (causes.white > kAsQuiet * found.white) return found;  // something drifts or scatters whatever acts
  Explanation other = improved(causes);
  return other.worth > found.worth ? std::move(other) : std::move(found);
}

Explanation Search::whole(Explanation start) const {
  Explanation found = pruned(grown(std::move(start)));
  for (int again = 0; again < kMostPairs; ++again) {
    Explanation more = paired(found);
    if (!(more.worth > found.worth)) break;
    found = pruned(grown(std::move(more)));
  }
  return found;
}

Explanation Search::run(const Eigen::VectorXd& variance) const {
  Explanation found = whole(none(variance));
  if (!couldHideSeveral(found)) return found;
  const Explanation causes = causesAlone(bare(found));
  return ofGreaterWorth(std::move(found), causes);
}

Explanation Search::improved(const Explanation& start) const {
  return whole(refitted(start.members, start, true));
}

double Search::worthAt(const Evidence& evidence, const std::vector<Member>& members) const {
  double worth = evidence.given(members).logEvidence;
  for (const Member& m : members) worth -= priceOf(m);
  return worth;
}

std::vector<Member> Search::runHeld(const Explanation& found, const Evidence& evidence) const {
  std::vector<Member> anew = grownHeld(evidence, {});
  if (found.members.empty()) return anew;
  // one at a time, several causes may not come past one that imitates them all on fewer rows
  std::vector<Member> kept = found.members;
  double most = worthAt(evidence, kept);
  for (bool again = true; again;) {
    again = false;
    std::vector<Member> fewer;
    for (std::size_t j = 0; j < kept.size(); ++j) {
      std::vector<Member> others = kept;
      others.erase(others.begin() + static_cast<long>(j));
      payInFullAlone(others);
      const double without = worthAt(evidence, others);
      if (without >= most) most = without, fewer = std::move(others), again = true;
    }
    if (again) kept = std::move(fewer);
  }
  kept = grownHeld(evidence, std::move(kept));
  return worthAt(evidence, kept) > worthAt(evidence, anew) ? kept : anew;
}

}  // namespace mm
