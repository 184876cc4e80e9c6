#include "base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "base/cancel_scope.h"

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace mm {
namespace {

// What oneTBB promises: all before a loop comes before each call in it, and each call before all after it.
// The thread sanitizer must be told, for Debian's oneTBB is compiled without it. In one place for all loops,
// for a call must not read anything before it is in order; so a race between two loops may go unseen.
#if defined(__SANITIZE_THREAD__)
char loopBegin, loopEnd;
struct OfLoop {
  OfLoop() { __tsan_release(&loopBegin); }
  ~OfLoop() { __tsan_acquire(&loopEnd); }
};
struct OfCall {
  OfCall() { __tsan_acquire(&loopBegin); }
  ~OfCall() { __tsan_release(&loopEnd); }
};
#else
struct OfLoop {
  ~OfLoop() {}
};
struct OfCall {
  ~OfCall() {}
};
#endif

}  // namespace

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& work) {
  if (count == 1) return work(0);
  const CancelScope* scope = CancelScope::current();
  const auto run = [&](std::size_t i) {
    const OfCall order;
    const CancelScope::Lent lent(scope);
    work(i);
  };
  const OfLoop order;
  tbb::parallel_for(std::size_t{0}, count, run, tbb::simple_partitioner());
}

struct Threads::Arena {
  explicit Arena(int most) : arena(most) {
    // more than there are cores: oneTBB has no workers for them unless it is told so
    if (most > tbb::info::default_concurrency())
      more = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                   static_cast<std::size_t>(most));
  }
  std::unique_ptr<tbb::global_control> more;
  tbb::task_arena arena;
};

Threads::Threads(unsigned most) {
  const int wanted = most == 0 ? tbb::info::default_concurrency() : static_cast<int>(most);
  if (tbb::this_task_arena::max_concurrency() != wanted) arena_ = std::make_unique<Arena>(wanted);
}

Threads::~Threads() = default;

void Threads::run(const std::function<void()>& work) {
  if (!arena_) return work();
  const CancelScope* scope = CancelScope::current();
  const OfLoop order;
  arena_->arena.execute([&] {
    const OfCall orderOfCall;
    const CancelScope::Lent lent(scope);
    work();
  });
}

Part partOf(std::size_t count, std::size_t size, std::size_t part) {
  return {std::min(count, part * size), std::min(count, (part + 1) * size)};
}

}  // namespace mm
