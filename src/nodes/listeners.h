#pragma once
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>

namespace mm {

/// Which nodes listen to a topic now, by name. A node that was killed listens no more as soon as its
/// connection has ended, without the master. From any thread.
class Listeners {
 public:
  /// A connection of this node was made.
  void came(const std::string& node);
  /// A connection of this node has ended.
  void left(const std::string& node);
  /// Waits until it listens, `seconds` at most.
  void await(const std::string& node, double seconds) const;
  bool listens(const std::string& node) const;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::map<std::string, int> connections_;
};

}  // namespace mm
