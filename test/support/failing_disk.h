#pragma once
#include <atomic>
#include <cstdint>

namespace mm_test {

/// What of a disk fails, in a file that the program and its test share: written whole by the test, counted in
/// by the program and all that it starts.
struct FailingDiskControl {
  enum class Way : std::int32_t {
    kOnce,     ///< the n-th operation alone
    kLasting,  ///< the n-th and all that follow
    kUneven    ///< every second one is interrupted (EINTR), the others give, or take, half of what was asked
  };
  std::atomic<std::int64_t> reads, writes;  ///< so far
  std::atomic<std::int64_t> at;             ///< n; 0: none
  std::atomic<std::int32_t> what;           ///< 0: nothing fails, 1: reads, 2: writes, 3: both
  std::atomic<Way> way;
  std::atomic<std::int32_t> cause;  ///< errno
};
static_assert(sizeof(FailingDiskControl) == 40);  // tests in other languages write it, too

}  // namespace mm_test
