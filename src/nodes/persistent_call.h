#pragma once
#include <ros/ros.h>

#include <chrono>
#include <future>
#include <mutex>
#include <string>

namespace mm {

/// A service on a connection that is opened once, before it is needed: a call then needs no master, and that
/// the connection has gone is known. From any thread.
template <typename Service>
class PersistentCall {
 public:
  PersistentCall(const ros::NodeHandle& node, std::string name) : node_(node), name_(std::move(name)) {}
  ~PersistentCall() { close(); }
  PersistentCall(const PersistentCall&) = delete;
  PersistentCall& operator=(const PersistentCall&) = delete;

  /// Opens the connection where there is none; asks the master for the way. @return whether there is one.
  bool connect() {
    if (connected()) return true;
    const ros::ServiceClient fresh = ros::NodeHandle(node_).serviceClient<Service>(name_, true);
    const std::lock_guard<std::mutex> lock(mutex_);
    client_ = fresh;
    return client_.isValid();
  }
  /// Whether the connection that was opened still holds.
  bool connected() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return client_.isValid();
  }
  /// Calls on the open connection. One that is not answered within `seconds` is closed: a late answer is
  /// none.
  /// @return whether it was answered.
  bool call(Service& service, double seconds) {
    ros::ServiceClient client;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      client = client_;
    }
    if (!client.isValid()) return false;
    auto asked = service;
    auto answer = std::async(std::launch::async, [&] { return client.call(asked); });
    if (answer.wait_for(std::chrono::duration<double>(seconds)) != std::future_status::ready)
      client.shutdown();
    if (!answer.get()) return false;
    service = asked;
    return true;
  }
  /// A call that waits for its answer ends without one.
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    client_.shutdown();
  }

 private:
  mutable std::mutex mutex_;
  ros::NodeHandle node_;
  std::string name_;
  ros::ServiceClient client_;
};

}  // namespace mm
