#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/SensorReadings.h>
#include <ros/ros.h>

#include <map>
#include <string>

namespace mm {

/// Makes `/temperature/<sensor>` of the sensors at the motion controller. A reading that is no number, or
/// that has not changed by a bit for a long time, is not passed on; diagnostics say which sensor and why.
/// Parameters: `frozen_after` (s without any change; 0: never), `timeout` (s without a message), `variance`
/// (K^2 of a reading; 0: not stated).
class TemperatureNode {
 public:
  TemperatureNode(ros::NodeHandle node, ros::NodeHandle own);

 private:
  struct Sensor {
    ros::Publisher out;
    double value = 0.0;  // degC, the last finite one
    ros::Time changed, seen;
    std::string wrong;  // why it is not passed on
  };
  void take(const measuring_machine::SensorReadings& readings);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle node_;
  double frozenAfter_, timeout_, variance_;
  std::map<std::string, Sensor> sensors_;
  ros::Time last_;
  ros::Subscriber in_;
  ros::WallTimer timer_;
  diagnostic_updater::Updater updater_;
};

}  // namespace mm
