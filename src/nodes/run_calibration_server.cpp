#include <ros/console.h>

#include "nodes/calibration_server.h"
#include "nodes/run.h"
#include "ros_bridge/effect_plugins.h"
#include "ros_bridge/node_support.h"

int mm::runCalibrationServer(int argc, char** argv) {
  return mm::runNode(argc, argv, "calibration_server", [] {
    ros::NodeHandle node, own("~");
    mm::loadEffectPlugins([](const std::string& line) { ROS_WARN("%s", line.c_str()); });
    // Threads for the topics, a long call, and everybody who asks meanwhile.
    ros::AsyncSpinner spinner(6);
    const mm::CalibrationServer server(node, own, mm::machineFromParameter(node));
    spinner.start();
    ros::waitForShutdown();
  });
}
