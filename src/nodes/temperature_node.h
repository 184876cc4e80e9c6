#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/SensorReadings.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/temperature_device.h"
#include "drivers/temperature_trust.h"

namespace mm {

/// Makes `/temperature/<sensor>` of the sensors at the motion controller, and of those of its own: behind
/// drivers of the kernel (hwmon, IIO) or on lines of Modbus RTU, each line in a thread of its own. A reading
/// that cannot be believed (`TemperatureTrust`) is not passed on; log and diagnostics say which sensor and
/// why. Service `~accept`: somebody says that the sensors which jumped are right as they are. Parameters:
/// `frozen_after` (s without any change; 0: never), `timeout` (s without a message), `variance` (K^2 of a
/// reading; 0: not stated), `fastest` (K/s; 0: any), `sensors` (see docs/sensors.md), `poll_rate` (Hz),
/// `sysfs` (where the kernel shows its devices).
class TemperatureNode {
 public:
  /// @throw InputError naming the parameter or the sensor.
  TemperatureNode(ros::NodeHandle node, ros::NodeHandle own);
  ~TemperatureNode();

 private:
  struct Sensor {
    ros::Publisher out;
    TemperatureTrust trust;
    ros::Time seen;
  };
  struct Polled {  // what one device said at one time
    ros::Time stamp;
    std::vector<TemperatureReading> readings;
  };
  /// One device and the thread that asks it.
  struct Poller {
    std::unique_ptr<TemperatureDevice> device;
    std::thread thread;
    std::mutex mutex;
    std::vector<Polled> waiting;
  };
  void take(const measuring_machine::SensorReadings& readings);
  void takePolled();
  void takeOne(const std::string& name, const TemperatureReading& reading, const ros::Time& now);
  std::string accept();
  void poll(Poller& poller, double period) const;
  bool topicIsOf(const std::string& name);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle node_;
  double timeout_, variance_;
  std::string frame_;
  TemperatureTrust::Settings trust_;
  std::map<std::string, Sensor> sensors_;
  std::map<std::string, std::string> topics_;  // the sensor of each
  std::map<std::string, bool> own_;            // names that the node reads itself
  std::atomic<bool> ends_{false};
  std::vector<std::unique_ptr<Poller>> pollers_;
  ros::Subscriber in_;
  ros::ServiceServer accept_;
  ros::WallTimer timer_, pollTimer_;
  diagnostic_updater::Updater updater_;
};

}  // namespace mm
