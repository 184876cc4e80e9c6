#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mm {

/// Names of series and joints that a bounded collector keeps: anybody may make up more.
inline constexpr std::size_t kMostLoggedNames = 1000;

/// Makes room in a log that is full, before an item is added: what lies before the session goes first, but
/// for the last of it, which still counts; where that is little, the oldest half goes.
/// @param most items that are kept; 0: without bound. @param start stamp of the session, ns.
/// @param stampOf of an item, ns. @return how many items of the session itself had to go.
template <typename Item, typename Stamp>
std::size_t makeRoom(std::vector<Item>& items, std::size_t most, std::int64_t start, Stamp stampOf) {
  if (most == 0 || items.size() < most) return 0;
  const auto before =
      std::count_if(items.begin(), items.end(), [&](const Item& item) { return stampOf(item) < start; });
  const std::ptrdiff_t useless = std::max<std::ptrdiff_t>(before - 1, 0);
  const auto half = std::max<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(most / 2), 1);
  const std::ptrdiff_t going = useless < (half + 1) / 2 ? half : useless;
  items.erase(items.begin(), items.begin() + going);
  return static_cast<std::size_t>(going - std::min<std::ptrdiff_t>(going, before));
}

}  // namespace mm
