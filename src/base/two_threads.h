#pragma once
#include <cstddef>
#include <functional>

namespace mm {

/// Runs `work(0)` here and `work(1)` on a second thread, and waits for both. What one of them throws is
/// thrown here once both have ended, the first's before the second's.
void inTwo(const std::function<void(std::size_t half)>& work);

}  // namespace mm
