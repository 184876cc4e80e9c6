#pragma once
#include <cstddef>
#include <vector>

namespace mm {

/// An effect that was there, was gone, and came back.
struct Recurrence {
  double logOdds = 0.0;  // evidence for it against "always alike" and "changed once", whichever is better
  std::size_t gone = 0, back = 0;  // first session without it, first session with it again
};

/// Whether what was found in some sessions and not in others comes back. Three periods, each with a
/// probability of its own to find it (Jeffreys' prior), at unknown times, against one period and
/// against two; the marginal likelihoods are exact. Under either of these the chance that the odds exceed 1/a
/// is at most a (Markov).
/// @param found in the order of time.
Recurrence recurrenceOf(const std::vector<bool>& found);

}  // namespace mm
