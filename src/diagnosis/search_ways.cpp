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

}  // namespace mm
