#pragma once
#include "ros_bridge/session_collector.h"

namespace mm::test {

constexpr double kStart = 5000.0;  // s

inline ros::Time at(double t) { return ros::Time(kStart + t); }

/// One ball at a known place.
inline measuring_machine::Artifact artifact(const ros::Time& stamp) {
  measuring_machine::Artifact message;
  message.header.stamp = stamp;
  message.name = "ball";
  message.pose_known = true;
  message.tip_radius = 1e-3;
  message.repeatability = 1e-6;
  message.features.resize(1);
  message.features[0].name = "b0";
  message.features[0].position_known = true;
  message.features[0].radius = 4e-3;
  return message;
}

/// @param x m.
inline measuring_machine::ProbeContact contact(double t, double x = 5e-3) {
  measuring_machine::ProbeContact message;
  message.header.stamp = at(t);
  message.name = {"x", "y", "z"};
  message.position = {x, 0.0, 0.0};
  message.velocity = {1e-3, 0.0, 0.0};
  message.laser_reading = kNotMeasured;
  message.feature = "b0";
  return message;
}

/// @param value degC.
inline sensor_msgs::Temperature bed(double t, double value = 20.0) {
  sensor_msgs::Temperature message;
  message.header.stamp = at(t);
  message.temperature = value;
  return message;
}

}  // namespace mm::test
