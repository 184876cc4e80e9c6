#pragma once
#include <actionlib/client/simple_action_client.h>
#include <actionlib/server/simple_action_server.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/MeasureAction.h>
#include <measuring_machine/Measured.h>
#include <measuring_machine/MoveAction.h>
#include <measuring_machine/ProbeContact.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "machine/machine.h"
#include "session/plan.h"

namespace mm {

/// Runs a measurement plan on the axis and probe nodes. Action `~run`; service `~pause`. Publishes the plan's
/// `artifact` and `robot_description`, latched: with them a session begins; `~measured`, its contacts so far.
/// Parameters: `retries` of a touch, `give_up` (misses in a row that end the plan), `contact_timeout` (s
/// between a trip and its contact).
class MeasureNode {
 public:
  MeasureNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine);

 private:
  using Server = actionlib::SimpleActionServer<measuring_machine::MeasureAction>;
  using Client = actionlib::SimpleActionClient<measuring_machine::MoveAction>;

  void execute(const measuring_machine::MeasureGoalConstPtr& goal);
  Plan loadPlan(const std::string& plan) const;
  /// Machine and artifact, for whoever begins to record now. @param again the session began before.
  void announce(const Plan& plan, bool again);
  void runFrom(const Plan& plan, std::size_t first);
  bool measure(const Plan& plan, const PlanMove& move);
  bool touch(const Plan& plan, const PlanMove& move);
  /// @return the action's `tripped`. @throw Error when the goal was not reached, Cancelled.
  bool drive(const Plan& plan, std::uint8_t kind, const std::vector<double>& position, double speed,
             const std::string& feature);
  bool waitForArrival(double wallSeconds);
  void pauseFor(double seconds);
  void holdWhilePaused();
  void tell(const Plan& plan, std::size_t move);
  bool waitForContact(std::uint64_t before);
  std::uint64_t contactsSeen();
  void tellMeasured();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  Machine machine_;
  int retries_, giveUp_;
  double contactTimeout_;
  measuring_machine::MeasureFeedback feedback_;
  std::atomic<bool> paused_{false};
  std::uint32_t measured_ = 0;  // contacts in the session
  ros::Time announced_;         // the stamp of the session
  std::string announcedPlan_;   // its text
  std::mutex mutex_;
  std::condition_variable contact_;  // or arrival
  bool arrived_ = false;             // the move under way has ended
  std::uint64_t contacts_ = 0;       // seen on /probe/contact
  ros::Publisher artifactOut_, descriptionOut_, measuredOut_;
  ros::Subscriber contactIn_;
  ros::ServiceServer pause_;
  std::mutex saidMutex_;
  std::string said_;  // how the last plan ended
  bool failed_ = false, running_ = false;
  std::uint32_t move_ = 0, moves_ = 0;  // of the plan under way
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
  Client axes_;
  Server server_;
};

}  // namespace mm
