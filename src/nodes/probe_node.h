#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/Artifact.h>
#include <measuring_machine/AxisStatus.h>
#include <measuring_machine/ProbeContact.h>
#include <measuring_machine/ProbeLatch.h>
#include <ros/ros.h>

#include <deque>
#include <optional>

#include "drivers/probe_debounce.h"
#include "ros_bridge/axis_messages.h"
#include "session/session.h"

namespace mm {

/// Makes `/probe/contact` of what the motion controller latched: debounced, only with the position of the
/// trip, and with the ball that was meant (or, for a move that names none, the one that is there).
/// Where several drivers move the joints, a contact is made of the latches of all: the first of `drivers` has
/// the probe's switch, and each joint of the others must be latched at the same trip, or rest by its joint
/// states, or there is no contact; that is waited for.
/// Subscribes to `<driver>/latch` and `<driver>/status` of each, `artifact`, and for several drivers
/// `joint_states`. Parameters: `drivers`
/// (names, with blanks between), `latch_tolerance` (m) and `rotary_latch_tolerance` (rad) by which a joint
/// may move between two latches, `settle`, `longest`, `stuck` (s, as in ProbeDebounce), `silent_moves`
/// (probing moves without a trip until it is said). One thread.
class ProbeNode {
 public:
  ProbeNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine);

 private:
  void takeLatch(const measuring_machine::ProbeLatch& latch);
  void takeStatus(const measuring_machine::AxisStatus& status);
  void poll(const ros::TimerEvent& event);
  void listenTo(ros::NodeHandle& node, const std::string& other);
  void confirmed(const measuring_machine::ProbeLatch& latch);
  bool isKnown(const measuring_machine::ProbeLatch& latch) const;
  void publishKnown();
  void publish(const measuring_machine::ProbeLatch& latch);
  std::string featureAt(const measuring_machine::ProbeContact& contact) const;
  std::string complaint() const;
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  Machine machine_;
  ProbeDebounce debounce_;
  std::deque<measuring_machine::ProbeLatch> closings_;  // not yet confirmed
  std::deque<measuring_machine::ProbeLatch> others_;    // of the other drivers, of the last while
  std::deque<measuring_machine::ProbeLatch> waiting_;   // confirmed, for the joints of the other drivers
  RestingJoints resting_;
  LatchTolerance tolerance_;
  std::vector<ros::Subscriber> othersIn_;
  measuring_machine::AxisStatus status_;
  std::optional<Artifact> artifact_;
  std::string said_, refusal_;
  ros::Time last_;
  std::uint64_t contacts_ = 0;
  int silentMoves_;
  ros::Publisher contactsOut_;
  ros::Subscriber latchIn_, statusIn_, artifactIn_;
  ros::Timer timer_;
  diagnostic_updater::Updater updater_;
};

}  // namespace mm
