#pragma once
#include <ros/ros.h>

#include <chrono>
#include <functional>
#include <future>
#include <mutex>
#include <string>

namespace mm {

/// A service on a connection that is opened once, before it is needed: a call then needs no master, and that
/// the connection has gone is known. From any thread.
template <typename Service, typename Client = ros::ServiceClient>
class PersistentCall {
 public:
  using Open = std::function<Client()>;
  PersistentCall(const ros::NodeHandle& node, const std::string& name)
      : PersistentCall([node, name] { return ros::NodeHandle(node).serviceClient<Service>(name, true); }) {}
  /// @param open makes a connection, as it is after that.
  explicit PersistentCall(Open open) : open_(std::move(open)) {}
  /// A call that waits for its answer ends without one.
  ~PersistentCall() {
    const std::lock_guard<std::mutex> lock(mutex_);
    client_.shutdown();
  }
  PersistentCall(const PersistentCall&) = delete;
  PersistentCall& operator=(const PersistentCall&) = delete;

  /// Opens the connection where there is none; asks the master for the way. @return whether there is one.
  bool connect() {
    if (connected()) return true;
    const Client fresh = open_();
    const std::lock_guard<std::mutex> lock(mutex_);
    client_ = fresh;
    return client_.isValid();
  }
  /// Whether the connection that was opened still holds, as far as its end was heard: roscpp does not hear of
  /// one that ends while it is opened.
  bool connected() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return client_.isValid();
  }
  /// Calls on the open connection. One that does not answer, or not within `seconds`, is closed: a late
  /// answer is none, and what holds only by its own word does not stay.
  /// @return whether it was answered.
  bool call(Service& service, double seconds) {
    Client client;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      client = client_;
    }
    if (!client.isValid()) return false;
    auto asked = service;
    auto answer = std::async(std::launch::async, [&] { return client.call(asked); });
    if (answer.wait_for(std::chrono::duration<double>(seconds)) != std::future_status::ready)
      client.shutdown();
    if (!answer.get()) {
      client.shutdown();
      return false;
    }
    service = asked;
    return true;
  }
  /// Calls on the open connection, and where that does not answer on a new one.
  bool callAnew(Service& service, double seconds) {
    return call(service, seconds) || (connect() && call(service, seconds));
  }

 private:
  mutable std::mutex mutex_;
  Open open_;
  Client client_;
};

}  // namespace mm
