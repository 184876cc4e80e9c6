#pragma once
#include <measuring_machine/Measured.h>
#include <measuring_machine/ProbeContact.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/timer.h>
#include <ros/wall_timer.h>

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "ros_bridge/session_collector.h"

namespace mm {

/// Collects the live session from the topics that a session is recorded from. /artifact with a new stamp
/// begins a new session; so does a clock that goes back, as two contacts in a row say. What is told of an
/// imported file counts for the session of its publisher. Temperatures and covariates are found by their
/// topics' names, drivers by the type of their status. Thread-safe.
class LiveSession {
 public:
  explicit LiveSession(ros::NodeHandle node);  ///< subscribes

  /// What was collected so far. @param fallback the machine unless /robot_description was heard.
  /// Its warning says how many of the contacts that were measured were not heard: this began to listen, or
  /// was started again, in the middle of a plan. @throw InputError when there is nothing, or the machine or
  /// the artifact that was announced cannot be read.
  Session session(const Machine& fallback) const;
  std::size_t observations() const;
  /// Why the live session is not what was measured, so far; empty: nothing is known to be wrong.
  std::string complaint() const;

 private:
  /// @param heard gets each message and the name of its publisher.
  template <typename Message, typename Heard>
  void subscribe(const std::string& topic, Heard heard);
  /// @param add to the collector, with the publisher where it takes one.
  template <typename Message, typename Add>
  void collect(const std::string& topic, Add add);
  /// Texts; those of a file that was imported count for the session of their publisher.
  void collectText(const std::string& topic, bool ofFile, void (SessionCollector::*add)(const std::string&));
  void takeArtifact(const measuring_machine::Artifact& message, const std::string& publisher);
  void take(const std::function<void(SessionCollector&)>& add);
  void beginAgainIfBack(const measuring_machine::ProbeContact& message);
  void takeMeasured(const measuring_machine::Measured& message);
  void findTopics(const ros::WallTimerEvent& event);

  ros::NodeHandle node_;
  mutable std::mutex mutex_;
  SessionCollector collector_;
  std::string wrong_;  // why the machine or the artifact could not be taken
  ros::Time artifact_;
  std::string player_;  // publisher of what was told of an imported file, last
  std::optional<measuring_machine::ProbeContact> behind_;  // the last contact, where its stamp lies behind
  std::map<std::string, ros::Subscriber> subscribers_;
  ros::WallTimer timer_;
};

}  // namespace mm
