#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <dynamic_reconfigure/server.h>
#include <measuring_machine/AxisStatus.h>
#include <measuring_machine/CompensationConfig.h>
#include <measuring_machine/CompensationStatus.h>
#include <measuring_machine/CorrectTarget.h>
#include <measuring_machine/Covariate.h>
#include <measuring_machine/ProbeContact.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Temperature.h>
#include <tf2_ros/transform_broadcaster.h>

#include <map>
#include <memory>
#include <mutex>

#include "nodes/calibration_watch.h"
#include "nodes/joint_owners.h"
#include "nodes/live_inputs.h"
#include "ros_bridge/axis_messages.h"

namespace mm {

/// Applies the active calibration, and the candidate beside it, to every joint state: one TF message each,
/// with the joint state's stamp, made from one immutable CalibrationPair. What cannot be trusted is not
/// published; `~status` and diagnostics say why. Joint states, contacts and sensors come on the node's own
/// queue (one thread); files are read and services answered by another. A calibration of another machine is
/// refused. A joint state is believed only from the publisher that owns its joints (JointOwners); others are
/// named. Parameters: `store`, `margin`, `frame_prefix`, `drivers` (names of the nodes whose status is heard,
/// of several controllers), `joint_timeout` (s), `sensor_timeout` (s), `travel_deadband` (m) and
/// `travel_deadband_rotary` (rad): a shorter way back is no reversal, of a machine whose driver does not tell
/// the direction of travel.
class CompensationNode {
 public:
  CompensationNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine);

 private:
  /// One calibration at work: what it sees of the inputs, and its buffers.
  struct Applied {
    std::shared_ptr<const LoadedCalibration> loaded;
    LiveInputs::View view;
    MovingState state;
    Compensator::Workspace work;
    std::string reason, note;  // why the last frame was withheld; what to know although it was not
  };

  using JointsEvent = ros::MessageEvent<sensor_msgs::JointState const>;
  using StatusEvent = ros::MessageEvent<measuring_machine::AxisStatus const>;
  void subscribeDrivers(const ros::NodeHandle& own);
  void takeJoints(const JointsEvent& event);
  void addFrame(Applied& applied, const ros::Time& stamp, const std::string& child, bool isActive);
  void takeContact(const measuring_machine::ProbeContactConstPtr& message);
  void withhold(const std::string& reason, bool beyond = false);
  bool believes(const JointsEvent& event);
  void takeStatus(const StatusEvent& event);
  void nameStranger(const std::string& why);
  void install(const std::shared_ptr<const CalibrationPair>& pair);
  void apply(Applied& applied, const std::shared_ptr<const LoadedCalibration>& loaded);
  void subscribeSensors();
  void look(const ros::WallTimerEvent& event);
  void reconfigure(const measuring_machine::CompensationConfig& config);
  bool isSilent() const;
  /// Whether the log is to have it. What lies beyond the calibrated range comes and goes with every move of a
  /// plan: once of a calibration; the status goes on saying it. @param saidOf the calibration of the last.
  static bool isNews(bool beyond, const std::string& calibration, std::string& saidOf);
  measuring_machine::CompensationStatus statusNow();
  void correctTarget(const measuring_machine::CorrectTarget::Request& request,
                     measuring_machine::CorrectTarget::Response& response);
  /// @return of each joint of the machine its direction of arrival at the target: -1, 1; 0: not told.
  std::vector<double> arrivalOf(const measuring_machine::CorrectTarget::Request& request) const;
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle node_;
  Machine machine_;
  std::string prefix_;
  double margin_;           // of what is in use
  CalibrationWatch watch_;  // of the slow thread

  std::mutex mutex_;  // everything below
  LiveInputs inputs_;
  std::shared_ptr<const CalibrationPair> pair_;
  Applied active_, candidate_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::vector<geometry_msgs::TransformStamped> frames_;  // of one joint state
  measuring_machine::CompensationStatus status_;
  std::string withheldSince_;  // the reason of a frame withheld since the last status
  ros::WallTime heard_;        // the last joint state
  JointOwners owners_;
  std::string stranger_;  // the last joint state that was not its owner's, and why it was not believed
  ros::WallTime strangerAt_;
  std::vector<int> joints_;  // of the machine in the message at hand
  std::map<std::string, ros::Subscriber> temperaturesIn_, covariatesIn_;

  measuring_machine::CompensationStatus shown_;
  std::string words_;          // of the status as last published
  std::string warned_;         // of the files, as the log has it
  std::string statusBeyond_;   // calibrations of which the log has that something lies beyond their range:
  std::string contactBeyond_;  // a status; a contact (with `mutex_`)
  ros::WallTime nextStatus_, nextMarkers_;
  ros::CallbackQueue slow_;
  ros::Publisher markersOut_, contactsOut_, statusOut_;
  ros::Subscriber jointsIn_, contactsIn_, artifactIn_;
  std::vector<ros::Subscriber> axesIn_;
  std::vector<ros::ServiceServer> correctTarget_;
  ros::WallTimer timer_;
  diagnostic_updater::Updater updater_;
  std::unique_ptr<dynamic_reconfigure::Server<measuring_machine::CompensationConfig>> reconfigured_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;
};

}  // namespace mm
