#pragma once
#include <ros/callback_queue_interface.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
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
  bool listens(const std::string& node) const;
  /// Waits until the node listens, at most that long, or until it is over. A node that speaks may not be
  /// heard to listen yet: its connections are made one after the other, those to a driver that was started
  /// again as well. @param over asked without a lock of ours.
  bool listensWithin(const std::string& node, std::chrono::milliseconds longest,
                     const std::function<bool()>& over) const;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable news_;
  std::map<std::string, int> connections_;
};

/// Calls back at once, in the thread of roscpp that reads the connections: whoever sends something was told
/// of before what it sent is read.
class AtOnce : public ros::CallbackQueueInterface {
 public:
  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t) override { callback->call(); }
  void removeByID(std::uint64_t) override {}
};

}  // namespace mm
