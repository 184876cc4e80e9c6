#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/Artifact.h>
#include <measuring_machine/AxisStatus.h>
#include <measuring_machine/ProbeContact.h>
#include <measuring_machine/ProbeLatch.h>
#include <ros/ros.h>

#include <deque>
#include <optional>

#include "ros_bridge/axis_messages.h"
#include "session/session.h"

namespace mm {

/// Says what a trip is that a motion controller latched, and publishes it as `/probe/contact`: of a probing
/// move, with its approach and the ball that was meant (or, for a move that names none, the one that is
/// there). Where several drivers move the joints, the first of `drivers` has the probe's switch, and each
/// joint of the others must be latched at the same trip, or rest by its joint states, or there is no contact;
/// that is waited for. Subscribes to `<driver>/latch` of each, `artifact`, and for several drivers
/// `<driver>/status` and `joint_states`. Parameters: `drivers` (names, with blanks between),
/// `latch_tolerance` (m) and `rotary_latch_tolerance` (rad) by which a joint may move between two latches.
/// One thread.
class ProbeNode {
 public:
  ProbeNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine);

 private:
  void listenTo(ros::NodeHandle& node, const std::string& other);
  void publishKnown();
  void publish(const measuring_machine::ProbeLatch& trip);
  std::string featureAt(const measuring_machine::ProbeContact& contact) const;
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  Machine machine_;
  std::deque<measuring_machine::ProbeLatch> trips_;    // that wait for the joints of the other drivers
  std::vector<measuring_machine::ProbeLatch> others_;  // of the other drivers, of the last while
  RestingJoints resting_;
  LatchTolerance tolerance_;
  std::optional<Artifact> artifact_;
  std::string refusal_;  // of the last trip; empty: it is a contact
  std::uint64_t contacts_ = 0, refused_ = 0;
  ros::Publisher contactsOut_;
  std::vector<ros::Subscriber> in_;
  ros::Duration wait_{0.0};  // for the other drivers
  ros::Timer timer_;
  diagnostic_updater::Updater updater_;
};

}  // namespace mm
