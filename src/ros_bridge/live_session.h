#pragma once
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/timer.h>
#include <ros/wall_timer.h>

#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "ros_bridge/session_collector.h"

namespace mm {

/// Collects the live session from the topics that a session is recorded from. /artifact with a new stamp
/// begins a new session; so does a clock that goes back. Temperatures and covariates are found by their
/// topics' names. Thread-safe.
class LiveSession {
 public:
  explicit LiveSession(ros::NodeHandle node);  ///< subscribes

  /// What was collected so far. @param fallback the machine unless /robot_description was heard.
  /// @throw InputError when there is nothing, or a message was wrong (the first such is named).
  Session session(const Machine& fallback) const;
  std::size_t observations() const;

 private:
  template <typename Message>
  void subscribe(const std::string& topic, void (SessionCollector::*add)(const Message&));
  void takeArtifact(const measuring_machine::Artifact& message);
  void take(const std::function<void(SessionCollector&)>& add);
  void beginAgainIfBack(std::int64_t stamp);
  void findTopics(const ros::WallTimerEvent& event);

  ros::NodeHandle node_;
  mutable std::mutex mutex_;
  SessionCollector collector_;
  std::string wrong_;  // the first message that could not be taken
  ros::Time artifact_;
  std::map<std::string, ros::Subscriber> subscribers_;
  ros::WallTimer timer_;
};

}  // namespace mm
