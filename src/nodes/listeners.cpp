#include "nodes/listeners.h"

#include <algorithm>

namespace mm {

void Listeners::came(const std::string& node) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++connections_[node];
  }
  news_.notify_all();
}

// One that comes again may have come before the end of its old connection was seen.
void Listeners::left(const std::string& node) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = connections_.find(node);
  if (found != connections_.end() && --found->second <= 0) connections_.erase(found);
}

bool Listeners::listens(const std::string& node) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return connections_.count(node) > 0;
}

bool Listeners::listensWithin(const std::string& node, std::chrono::milliseconds longest,
                              const std::function<bool()>& over) const {
  constexpr std::chrono::milliseconds kLook(10);
  const auto until = std::chrono::steady_clock::now() + longest;
  do {
    std::unique_lock<std::mutex> lock(mutex_);
    if (news_.wait_for(lock, std::min(kLook, longest), [&] { return connections_.count(node) > 0; }))
      return true;
    lock.unlock();
    if (over()) return false;
  } while (std::chrono::steady_clock::now() < until);
  return false;
}

}  // namespace mm
