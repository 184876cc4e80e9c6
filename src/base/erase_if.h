#pragma once
#include <algorithm>
#include <vector>

namespace mm {

/// Takes out of a list what `gone` holds for; the order of the others stays.
template <typename Item, typename Gone>
void eraseIf(std::vector<Item>& items, const Gone& gone) {
  items.erase(std::remove_if(items.begin(), items.end(), gone), items.end());
}

}  // namespace mm
