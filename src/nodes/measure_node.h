#pragma once
#include <actionlib/server/simple_action_server.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/AxisStatus.h>
#include <measuring_machine/MeasureAction.h>
#include <measuring_machine/Measured.h>
#include <measuring_machine/MotionStatus.h>
#include <measuring_machine/MoveAction.h>
#include <measuring_machine/ProbeContact.h>
#include <measuring_machine/TakeMotion.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "base/error.h"
#include "machine/controller_compensation.h"
#include "machine/machine.h"
#include "nodes/action_call.h"
#include "nodes/persistent_call.h"
#include "session/plan.h"

namespace mm {

/// Runs a measurement plan on the axis and probe nodes. Action `~run`; services `~pause`, `~renew`. Publishes
/// the plan's `artifact` and `robot_description`, latched: with them a session begins; `~measured`, its
/// contacts so far. Owns the axes while it runs, by a lease that it renews on a connection of its own: a stop
/// takes it away, and so ends the plan wherever it is; what ends this node, or the one whose lease the plan
/// is, stops the axes. A touch that brings no contact is tried again, and set aside when none comes; how
/// often is said at the end. Where the plan turns the artifact or changes the stylus it pauses, says what it
/// asks for (feedback `asks`), and goes on when `~pause` is called with false. Parameters: `retries` of a
/// touch, `give_up` (misses in a row that end the plan), `contact_timeout` (s between a trip and its
/// contact), `release_timeout` (s for the probe to open after it was backed off), `compensation` (what the
/// controller compensates: none, or a folder as of `mm import
/// --compensation`), which is published as `controller_compensation`, latched.
class MeasureNode {
 public:
  MeasureNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine);
  ~MeasureNode();
  MeasureNode(const MeasureNode&) = delete;
  MeasureNode& operator=(const MeasureNode&) = delete;

 private:
  using Wall = std::chrono::steady_clock;
  using Server = actionlib::SimpleActionServer<measuring_machine::MeasureAction>;
  /// The probe closed where it had to be open, but not for long: a switch that chatters.
  class UnsettledProbe : public Error {
   public:
    using Error::Error;
  };

  /// Takes each message of a topic, with `mutex_` held, and tells who waits.
  template <typename Message, typename Take>
  ros::Subscriber hear(ros::NodeHandle& node, const std::string& topic, std::uint32_t queue, Take take);
  void tellWaiting();
  void execute(const measuring_machine::MeasureGoalConstPtr& goal);
  Plan loadPlan(const std::string& plan) const;
  void sayBlockedWays(const Plan& plan);
  /// Machine and artifact, for whoever begins to record now. @param again the session began before.
  void announce(const Plan& plan, bool again);
  void runFrom(const Plan& plan, std::size_t first);
  bool measure(const Plan& plan, const PlanMove& move);
  bool touch(const Plan& plan, const PlanMove& move);
  void leave(const Plan& plan, const PlanMove& move);
  std::string retriesInWords() const;
  bool unsettled(std::uint8_t kind, const measuring_machine::MoveResult& result) const;
  /// @return the action's `tripped`. @throw UnsettledProbe, Error when the goal was not reached, Cancelled.
  bool drive(const Plan& plan, std::uint8_t kind, const std::vector<double>& position, double speed,
             const std::string& feature);
  bool lostController(std::uint8_t outcome);
  bool answersAgain(const std::string& why);
  bool waitForArrival(double wallSeconds);
  void takeAxes(const std::string& plan);
  void renewAll();  // the thread of the lease
  void renew(std::uint64_t ticket);
  std::uint32_t takeTicket();
  void keepLease();
  bool left() const;
  void requireLease();
  void giveAxes();
  /// Ends the plan when it was cancelled, or the axes were stopped. @throw Cancelled, Error
  void goOn();
  bool cancelAsked();
  /// @param reason why the driver ended the motion before; empty: it did not. @throw Error
  void requireOpenProbe(const std::string& when, const std::string& reason = {});
  /// Whether the tip rests on something: the switch is closed, or what the driver says of it is still on the
  /// way.
  bool touches();
  void pauseFor(double seconds);
  void holdWhilePaused();
  /// Asks for the placement and stylus of a move, and waits until the operator says that they are there.
  void askFor(const Plan& plan, const PlanMove& move);
  void tell(const Plan& plan, std::size_t move);
  bool waitForContact(std::uint64_t before);
  std::uint64_t contactsSeen();
  void countContact();
  void tellMeasured();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  Machine machine_;
  std::string prefix_;  // of the frames' names
  ControllerCompensation compensation_;
  int retries_, giveUp_;
  int lost_ = 0;  // motions in a row that were lost with their controller
  double contactTimeout_, releaseTimeout_;
  std::atomic<int> retried_{0};  // measurements that were tried again
  int left_ = 0;                 // ways back from a surface that the probe ended
  measuring_machine::MeasureFeedback feedback_;
  std::atomic<bool> paused_{false};
  std::uint32_t measured_ = 0;              // contacts in the session
  std::string stand_, placement_, stylus_;  // of the move under way
  bool leaving_ = false;                    // the way back from a touch
  std::atomic<bool> cancel_{false};         // of the goal under way, or another goal has come
  ros::Time announced_;                     // the stamp of the session
  std::string announcedPlan_;               // its text
  std::mutex mutex_;
  std::condition_variable contact_;            // or arrival
  std::uint64_t contacts_ = 0;                 // seen on /probe/contact
  std::uint64_t ticket_ = 0;                   // of the axes; 0: none
  std::atomic<std::uint32_t> stopsBefore_{0};  // when the ticket was taken
  std::string owner_;                          // this node and its plan, for people
  std::string lostTicket_;    // why the ticket was taken away, or the plan left alone: the plan ends
  std::string lapse_;         // why the ticket was not renewed: another may be taken
  double lease_ = 0.0;        // s within which whoever began the plan renews it; 0: he need not
  Wall::time_point renewed_;  // by him
  Wall::time_point leased_;   // when the driver last granted the lease
  measuring_machine::AxisStatus status_;
  std::optional<measuring_machine::MotionStatus> motion_;
  ros::Publisher artifactOut_, compensationOut_, descriptionOut_, measuredOut_;
  ros::Subscriber contactIn_, statusIn_, motionIn_;
  PersistentCall<measuring_machine::TakeMotion> take_;
  ros::ServiceServer pause_, renewIn_;
  std::mutex saidMutex_;
  std::string said_;         // how the last plan ended
  std::string blockedWays_;  // of the plan under way: ways through a ball
  bool failed_ = false, running_ = false;
  std::uint32_t move_ = 0, moves_ = 0;  // of the plan under way
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
  ActionCall<measuring_machine::MoveAction> axes_;
  Server server_;
  std::atomic<bool> ending_{false}, over_{false};
  std::thread renewer_;
};

}  // namespace mm
