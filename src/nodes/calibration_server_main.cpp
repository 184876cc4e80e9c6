#include <ros/console.h>

#include "nodes/calibration_server.h"
#include "ros_bridge/effect_plugins.h"
#include "ros_bridge/node_support.h"

int main(int argc, char** argv) {
  return mm::runNode(argc, argv, "calibration_server", [](ros::NodeHandle node, ros::NodeHandle own) {
    mm::loadEffectPlugins([](const std::string& line) { ROS_WARN("%s", line.c_str()); });
    // Threads for the topics, a long call, and everybody who asks meanwhile.
    ros::AsyncSpinner spinner(6);
    const mm::CalibrationServer server(node, own, mm::machineFromParameter(node));
    spinner.start();
    ros::waitForShutdown();
  });
}
