#include "base/two_threads.h"

#include <exception>
#include <thread>

namespace mm {

void inTwo(const std::function<void(std::size_t half)>& work) {
  std::exception_ptr first, second;
  std::thread other([&] {
    try {
      work(1);
    } catch (...) {
      second = std::current_exception();
    }
  });
  try {
    work(0);
  } catch (...) {
    first = std::current_exception();
  }
  other.join();
  if (first) std::rethrow_exception(first);
  if (second) std::rethrow_exception(second);
}

}  // namespace mm
