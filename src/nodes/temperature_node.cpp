#include "nodes/temperature_node.h"

#include <sensor_msgs/Temperature.h>

#include <cmath>

#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"

namespace mm {

TemperatureNode::TemperatureNode(ros::NodeHandle node, ros::NodeHandle own)
    : node_(node), updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(own, {"frozen_after", "timeout", "variance"});
  frozenAfter_ = numberParameter(own, "frozen_after", 1800.0, 0.0, 1e9);
  timeout_ = numberParameter(own, "timeout", 10.0, 0.01, 1e6);
  variance_ = numberParameter(own, "variance", 0.0, 0.0, 1e6);
  in_ = node.subscribe("axis_driver/temperatures", 100, &TemperatureNode::take, this);
  updater_.setHardwareID("temperature sensors");
  updater_.add("sensors", this, &TemperatureNode::diagnose);
  timer_ =
      node.createWallTimer(ros::WallDuration(0.5), [this](const ros::WallTimerEvent&) { updater_.update(); });
}

void TemperatureNode::take(const measuring_machine::SensorReadings& readings) {
  const ros::Time now = readings.header.stamp;
  const bool back = now < last_;  // the clock went back: nothing is known about how long a value has stood
  last_ = now;
  for (std::size_t i = 0; i < std::min(readings.name.size(), readings.temperature.size()); ++i) {
    const std::string& name = readings.name[i];
    const double value = readings.temperature[i];
    Sensor& sensor = sensors_[name];
    if (!sensor.out)
      sensor.out = node_.advertise<sensor_msgs::Temperature>("temperature/" + topicOf(name), 100);
    const std::string before = sensor.wrong;
    sensor.wrong.clear();
    if (sensor.seen.isZero() || back || value != sensor.value) sensor.changed = now;
    sensor.seen = now;
    sensor.value = value;
    if (!std::isfinite(value))
      sensor.wrong = "sensor '" + name + "' does not answer";
    else if (frozenAfter_ > 0.0 && now - sensor.changed >= ros::Duration(frozenAfter_))
      sensor.wrong = "sensor '" + name + "' is frozen: its value has not changed for " +
                     std::to_string(static_cast<int>((now - sensor.changed).toSec())) + " s";
    if (before.empty() && !sensor.wrong.empty()) {
      ROS_WARN("%s; it is not published", sensor.wrong.c_str());
      updater_.force_update();
    }
    if (!sensor.wrong.empty()) continue;
    sensor_msgs::Temperature message;
    message.header.stamp = now;
    message.header.frame_id = name;
    message.temperature = value;
    message.variance = variance_;
    sensor.out.publish(message);
  }
}

void TemperatureNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, std::to_string(sensors_.size()) + " sensors");
  if (sensors_.empty()) status.summary(DiagnosticStatus::WARN, "no sensor has been heard yet");
  const ros::Time now = ros::Time::now();
  for (const auto& [name, sensor] : sensors_) {
    status.add(name, sensor.value);
    if (!sensor.wrong.empty())
      status.mergeSummary(DiagnosticStatus::ERROR, sensor.wrong);
    else if (now > sensor.seen && (now - sensor.seen).toSec() > timeout_)
      status.mergeSummary(DiagnosticStatus::ERROR,
                          "sensor '" + name + "' has been silent for " +
                              std::to_string(static_cast<int>((now - sensor.seen).toSec())) + " s");
  }
}

}  // namespace mm
