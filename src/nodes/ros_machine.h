#pragma once
#include <measuring_machine/Artifact.h>
#include <measuring_machine/CompensationStatus.h>
#include <measuring_machine/HomeAction.h>
#include <measuring_machine/MeasureAction.h>
#include <measuring_machine/ProbeContact.h>
#include <measuring_machine/TakeMotion.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/transform_listener.h>

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "nodes/action_call.h"
#include "nodes/persistent_call.h"
#include "ros_bridge/live_session.h"
#include "workbench/live_machine.h"

namespace mm {

/// The machine behind the other nodes, as the workbench sees it: joint states, corrected frames and the live
/// session by their topics; everything that changes something by the services and actions that are there for
/// everybody. What moves lives by this object, homing and a plan by its renewals. The
/// connection to the driver's stop is open all the time, so that no stop needs the master. Needs several
/// threads.
class RosMachine : public LiveMachine {
 public:
  /// @param prefix of the frames' names.
  RosMachine(ros::NodeHandle node, const Machine& machine, std::string prefix);
  ~RosMachine() override;

  const Machine& machine() const override { return machine_; }
  State state() override;
  Session session() override { return live_.session(machine_); }
  std::vector<Eigen::Vector3d> contacts() override;
  std::string space() const override;
  std::string promote(const std::string& id) override;
  std::string rollback(const std::string& id) override;
  std::string home() override;
  std::string run(const std::string& yaml, const std::function<bool()>& cancelled) override;
  std::string pause(bool yes) override;
  std::string deaf() override;
  void stop() override;

 private:
  /// Where a frame was published last, and when.
  struct Frame {
    Eigen::Vector3d position = Eigen::Vector3d::Constant(kNotMeasured);
    ros::Time stamp;
    ros::WallTime heard;
  };

  void takeJoints(const sensor_msgs::JointStateConstPtr& message);
  /// Looks for a frame of another stamp. @return where it is; not a number: none came for a while.
  Eigen::Vector3d look(const std::string& child, Frame& frame) const;
  void takeContact(const measuring_machine::ProbeContactConstPtr& message);
  void takeArtifact(const measuring_machine::ArtifactConstPtr& message);
  void serveStops();
  void sendStop();

  ros::NodeHandle node_;
  Machine machine_;
  std::string prefix_;
  LiveSession live_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};  // has a thread of its own
  std::mutex mutex_;                              // everything to the next blank line
  std::vector<double> readings_;
  ros::WallTime moved_;  // when a joint was last seen to move
  Frame corrected_, candidate_;
  measuring_machine::CompensationStatus compensation_;
  std::vector<Eigen::Vector3d> contacts_;
  ros::Time artifact_;
  std::string measuring_;
  double share_ = 0.0;
  bool stopAsked_ = false, ending_ = false;
  std::condition_variable wake_;

  std::vector<ros::Subscriber> subscribers_;
  ActionCall<measuring_machine::MeasureAction> measure_;
  ActionCall<measuring_machine::HomeAction> home_;
  PersistentCall<std_srvs::Trigger> stop_, renew_;
  PersistentCall<measuring_machine::TakeMotion> take_;
  std::thread stopper_;  // a call of a service takes time, and a stop must not wait for the page
};

}  // namespace mm
