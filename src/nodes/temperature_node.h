#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/SensorReadings.h>
#include <ros/ros.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/temperature_device.h"

namespace mm {

/// Makes `/temperature/<sensor>` of the sensors at the motion controller, and of those of its own: behind
/// drivers of the kernel (hwmon, IIO) or on lines of Modbus RTU, each line in a thread of its own. A reading
/// that is no number, beyond any thermometer, faster than a body of metal can be, or that has not changed by
/// a bit for a long time, is not passed on; diagnostics say which sensor and why. Parameters: `frozen_after`
/// (s without any change; 0: never), `timeout` (s without a message), `variance` (K^2 of a reading; 0: not
/// stated), `fastest` (K/s; 0: any), `sensors` (see docs/sensors.md), `poll_rate` (Hz), `sysfs` (where the
/// kernel shows its devices).
class TemperatureNode {
 public:
  /// @throw InputError naming the parameter or the sensor.
  TemperatureNode(ros::NodeHandle node, ros::NodeHandle own);
  ~TemperatureNode();

 private:
  struct Sensor {
    ros::Publisher out;
    double value = 0.0;   // degC, the last finite one
    double passed = 0.0;  // degC, the last that was published
    ros::Time changed, seen, published;
    std::string wrong;  // why it is not passed on
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
  void takeOne(const std::string& name, const TemperatureReading& reading, const ros::Time& now, bool back);
  std::string doubtOf(const std::string& name, const Sensor& sensor, const TemperatureReading& reading,
                      const ros::Time& now) const;
  void poll(Poller& poller, double period) const;
  bool topicIsOf(const std::string& name);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle node_;
  double frozenAfter_, timeout_, variance_, fastest_;
  std::map<std::string, Sensor> sensors_;
  std::map<std::string, std::string> topics_;  // the sensor of each
  std::map<std::string, bool> own_;            // names that the node reads itself
  ros::Time last_;
  std::atomic<bool> ends_{false};
  std::vector<std::unique_ptr<Poller>> pollers_;
  ros::Subscriber in_;
  ros::WallTimer timer_, pollTimer_;
  diagnostic_updater::Updater updater_;
};

}  // namespace mm
