#include "nodes/listeners.h"

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

bool Listeners::listensWithin(const std::string& node, std::chrono::milliseconds longest) const {
  std::unique_lock<std::mutex> lock(mutex_);
  return news_.wait_for(lock, longest, [&] { return connections_.count(node) > 0; });
}

}  // namespace mm
