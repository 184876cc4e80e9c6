#pragma once
#include <actionlib/server/simple_action_server.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PointStamped.h>
#include <measuring_machine/AxisStatus.h>
#include <measuring_machine/MoveAction.h>
#include <measuring_machine/SensorReadings.h>
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

#include "drivers/axis_controller.h"
#include "session/travel_tracker.h"

namespace mm {

/// One motion controller under ROS: publishes its state, takes goals, keeps the limits of the URDF.
/// Topics: `joint_states`, `~status`, `~latch`, `~temperatures`, of a simulation also `~truth` (and `/clock`
/// with the parameter `clock`). Action `~move`; services `~home`, `~stop`, `~emergency_stop`.
/// Parameters: `rate` (Hz), `linear_speed` (m/s), `rotary_speed` (rad/s), `temperature_rate` (Hz), `clock`
/// (the simulation makes the time), `time_factor` (simulated seconds a second, with `clock`).
class AxisDriver {
 public:
  /// @param controller opened; belongs to this node from here on.
  AxisDriver(ros::NodeHandle node, ros::NodeHandle own, std::shared_ptr<AxisController> controller,
             const Machine& machine);
  ~AxisDriver();

 private:
  using MoveServer = actionlib::SimpleActionServer<measuring_machine::MoveAction>;
  using Trigger = std_srvs::Trigger;

  // The loop's thread.
  void run();
  void cycle(double elapsed);
  void publishJoints(const AxesState& state, const ros::Time& stamp);
  void publishStatus(const AxesState& state, const ros::Time& stamp);
  void publishEdges(const AxesState& state, const ros::Time& stamp);
  void publishTemperatures(const ros::Time& stamp);

  // Threads of actions and services.
  void executeMove(const measuring_machine::MoveGoalConstPtr& goal);
  AxesMotion motionOf(const measuring_machine::MoveGoal& goal) const;
  bool waitForMove(const AxesMotion& motion, bool probing, measuring_machine::MoveResult& result);
  bool home(Trigger::Request& request, Trigger::Response& response);
  bool stop(Trigger::Request& request, Trigger::Response& response);
  bool emergencyStop(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);
  /// Waits for the next cycles until `done` says so. @return false when the node ends.
  template <typename Done>
  bool waitUntil(std::unique_lock<std::mutex>& lock, Done done);

  std::shared_ptr<AxisController> controller_;
  Machine machine_;
  std::vector<Joint> joints_;  // of the controller's axes
  double rate_, linearSpeed_, rotarySpeed_, temperatureRate_, timeFactor_;
  bool clock_;
  ros::Time clockStart_;

  std::mutex mutex_;  // the controller and everything below
  std::condition_variable cycled_;
  AxesState state_;
  std::string feature_, lost_;  // lost_: why the controller does not answer
  ros::Time homedAt_;
  std::vector<TravelTracker> trackers_;  // of each axis
  std::vector<std::int8_t> travel_;      // of each axis: direction of its last motion; 0: none yet
  bool homing_ = false, probing_ = false, tripped_ = false, stopAsked_ = false;
  std::uint32_t unsuccessful_ = 0;
  std::uint64_t cycles_ = 0, late_ = 0;
  std::string shown_;  // the status as last published
  ros::Time nextStatus_, nextTemperature_;
  ros::WallTime nextDiagnostics_;

  ros::Publisher jointsOut_, statusOut_, latchOut_, temperaturesOut_, truthOut_, clockOut_;
  ros::ServiceServer home_, stop_, emergencyStop_;
  diagnostic_updater::Updater updater_;
  std::unique_ptr<MoveServer> moveServer_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace mm
