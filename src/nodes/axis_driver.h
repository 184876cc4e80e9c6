#pragma once
#include <actionlib/server/action_server.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PointStamped.h>
#include <measuring_machine/AxisStatus.h>
#include <measuring_machine/BreakDevice.h>
#include <measuring_machine/HomeAction.h>
#include <measuring_machine/HomeAxes.h>
#include <measuring_machine/MotionStatus.h>
#include <measuring_machine/MoveAction.h>
#include <measuring_machine/ProbeLatch.h>
#include <measuring_machine/SensorReadings.h>
#include <measuring_machine/SetOverride.h>
#include <measuring_machine/TakeMotion.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/JointState.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "drivers/motion_control.h"
#include "nodes/listeners.h"
#include "nodes/time_watch.h"
#include "ros_bridge/axis_messages.h"
#include "ros_bridge/direct_server.h"
#include "session/travel_tracker.h"

namespace mm {

/// One motion controller under ROS: publishes its state, takes goals, keeps the limits of the URDF.
/// Topics: `joint_states`, `~status`, `~motion`, `~latch`, `~temperatures`, of a simulation also `~truth`
/// (and `/clock` with the parameter `clock`). Actions `~move`, `~home`; services `~home`, `~home_axes`,
/// `~stop`, `~emergency_stop`, `~hold`, `~resume`, `~override`, `~clear_alarm`, `~move_off_limit`, `~take`,
/// `~break_device`. Stop and emergency stop have a port and threads of their own that nothing else may
/// occupy. A motion ends when whoever asked for it no longer listens to `~move/status`, or does not renew its
/// ticket (`~take`). Ends by stopping the axes.
/// Parameters: `rate` (Hz), `linear_speed` (m/s), `rotary_speed` (rad/s), `temperature_rate` (Hz), `clock`
/// (the simulation makes the time), `time_factor` (simulated seconds a second, with `clock`), `tolerance` (m)
/// and `rotary_tolerance` (rad) of an arrival, `silence` (s until a controller without a new state is lost),
/// `rest_timeout` (s within which the axes must rest after a stop), `hold_limit` (s of feed hold),
/// `homing_order` (`z; x y`: stages, one after the other), `probe_settle`, `probe_longest`, `probe_stuck` (s,
/// as in ProbeDebounce), `silent_moves` (probing moves without a trip until it is said). Sets `clock_next`:
/// there its next life goes on with the same time.
class AxisDriver {
 public:
  /// @param controller opened; belongs to this node from here on.
  AxisDriver(ros::NodeHandle node, ros::NodeHandle own, std::shared_ptr<AxisController> controller,
             const Machine& machine);
  ~AxisDriver();

 private:
  using MoveServer = actionlib::ActionServer<measuring_machine::MoveAction>;
  using Goal = MoveServer::GoalHandle;
  using HomeServer = actionlib::ActionServer<measuring_machine::HomeAction>;
  using TriggerCall = ros::ServiceEvent<std_srvs::TriggerRequest, std_srvs::TriggerResponse>;
  using HomeCall = ros::ServiceEvent<measuring_machine::HomeAxesRequest, measuring_machine::HomeAxesResponse>;
  using Take = measuring_machine::TakeMotion;
  struct Asked {  // a goal, and the stops there had been when it came
    Goal goal;
    std::uint32_t stops = 0;
    std::string sender;
  };

  void advertise(ros::NodeHandle own);
  void watchListeners(ros::NodeHandle own);

  // The loop's thread.
  void run();
  void cycle(double elapsed);
  void publishJoints(const MotionControl::Observation& seen, const ros::Time& stamp);
  void publishStatus(const MotionControl::View& view, const ros::Time& stamp);
  void publishMotion(const MotionControl::View& view, const ros::Time& stamp);
  Meant probed();
  void publishLatch(const ProbeEdge& edge, const Meant& meant);
  void publishTemperatures(const ros::Time& stamp);
  ros::Time stampOf(double controllerTime, double host) const;

  // The thread that moves.
  void moveAll();
  void execute(const Asked& asked);
  void forgetGoal();
  AxesMotion motionOf(const measuring_machine::MoveGoal& goal) const;
  bool latchLaser(const Meant& meant);

  // Threads of actions and services.
  void takeGoal(Goal goal);
  void cancelGoal(Goal goal);
  void takeHoming(HomeServer::GoalHandle goal);
  void homeAll();
  void executeHoming(HomeServer::GoalHandle goal);
  Mover callerOf(const std::string& node);
  Mover moverOf(const std::string& sender, std::uint64_t ticket);
  bool home(TriggerCall& call);
  bool homeAxes(HomeCall& call);
  void stop(const std::string& caller, std_srvs::TriggerResponse& response);
  void emergencyStop(const std::string& caller, bool on, std_srvs::SetBoolResponse& response);
  void take(const Take::Request& request, Take::Response& response);
  void tellNextLife();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);
  void diagnoseProbe(diagnostic_updater::DiagnosticStatusWrapper& status);

  Machine machine_;
  std::string prefix_;  // of the frames' names
  double rate_, linearSpeed_, rotarySpeed_, temperatureRate_, timeFactor_;
  bool clock_;
  ros::Time clockStart_;
  std::atomic<double> clockSaid_{0.0};  // s, last on /clock
  std::shared_ptr<AxisController> controller_;
  MotionControl control_;

  // Of the loop's thread.
  ros::Time homedAt_, lastStamp_;
  TimeWatch time_;
  std::vector<TravelTracker> trackers_;          // of each axis
  std::vector<bool> axisHomed_;                  // by the last state
  std::vector<std::int8_t> travel_;              // of each axis: direction of its last motion; 0: none yet
  measuring_machine::AxisStatus shown_;          // as last published
  measuring_machine::MotionStatus shownMotion_;  // likewise
  std::string lostSaid_, faultSaid_, probeSaid_;
  ros::Time nextTemperature_;
  ros::WallTime nextDiagnostics_;
  std::atomic<std::uint64_t> cycles_{0}, late_{0};

  std::mutex reset_;
  std::mutex goals_;  // the goals and the feature
  std::condition_variable asked_;
  std::unique_ptr<Asked> next_, now_;
  std::unique_ptr<HomeServer::GoalHandle> nextHoming_;
  bool cancelled_ = false;  // the goal that is under way
  Meant meant_;             // by the last goal that probes

  ros::CallbackQueue holdQueue_, leaseQueue_;  // before whoever calls into them: these outlive it
  AtOnce atOnce_;
  ros::Publisher jointsOut_, statusOut_, motionOut_, latchOut_, temperaturesOut_, truthOut_, clockOut_;
  std::vector<ros::ServiceServer> services_;
  Listeners listeners_;  // to `~move/status` and `~home/status`: every client of the actions
  std::vector<ros::Publisher> listening_;
  ros::AsyncSpinner holdSpinner_, leaseSpinner_;
  diagnostic_updater::Updater updater_;
  std::unique_ptr<MoveServer> moveServer_;
  std::unique_ptr<HomeServer> homeServer_;
  std::atomic<bool> homes_{false}, homingCancelled_{false};
  std::atomic<bool> ending_{false};
  std::thread thread_, mover_, homer_;
  std::unique_ptr<DirectServer> stops_;  // stop and emergency stop
  ros::WallTimer clockTimer_;
};

}  // namespace mm
