#pragma once
#include <algorithm>
#include <cmath>
#include <string>

namespace mm {

/// Orders of the states of a blind trial are words of A and B, a letter a block. They are drawn evenly from
/// the balanced ones that correlate with the number of the block by no more than this, so that a drift takes
/// little of what they show; a randomisation test runs over the same ones.
inline constexpr double kMostWithTime = 0.5;

/// Correlation of an order with the number of the block; 0 where all states are the same.
double correlationWithTime(const std::string& order);

/// Calls with each order that may have been drawn instead of one: as many A and B, and no more correlated
/// with time (or as much as that one is, where blocks are missing in it).
template <class Called>
void forEachOrder(std::string order, const Called& called) {
  constexpr double kRounding = 1e-9;
  const double most = std::max(kMostWithTime, std::abs(correlationWithTime(order))) + kRounding;
  std::sort(order.begin(), order.end());
  do {
    if (std::abs(correlationWithTime(order)) <= most) called(order);
  } while (std::next_permutation(order.begin(), order.end()));
}

/// The smallest p of a two-sided randomisation test with that order. As many A as B: an order and its mirror
/// are equally extreme; else the mirror has another number of A and is none that may have been drawn.
double smallestP(const std::string& order);

}  // namespace mm
