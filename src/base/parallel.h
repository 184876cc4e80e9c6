#pragma once
#include <cstddef>
#include <functional>
#include <memory>

namespace mm {

/// Runs work(0) … work(count - 1), each once, on the threads of this arena (all cores, unless Threads
/// says otherwise), and returns when all have ended. Which thread runs which is left to oneTBB, so that the
/// bits of a result do not depend on their number as long as each call writes what is its own.
///
/// The CancelScope of the caller is that of every call. What one of them throws is thrown here; those that
/// have not begun are then left out.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& work);

/// How many threads a parallelFor may take.
class Threads {
 public:
  /// @param most 0: one a core.
  explicit Threads(unsigned most);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  /// Runs work() so that every parallelFor within it takes at most so many, this thread included.
  void run(const std::function<void()>& work);

 private:
  struct Arena;
  std::unique_ptr<Arena> arena_;  // null: that of the caller has as many
};

/// One of the parts of `size` into which `count` things are cut; the last may be shorter. Parts belong to the
/// data, never to the threads.
struct Part {
  std::size_t first = 0, end = 0;
};
Part partOf(std::size_t count, std::size_t size, std::size_t part);  ///< items of one part
inline std::size_t partsOf(std::size_t count, std::size_t size) {
  return (count + size - 1) / size;
}  ///< how many

}  // namespace mm
