#include <ros/console.h>

#include "nodes/compensation_node.h"
#include "ros_bridge/effect_plugins.h"
#include "ros_bridge/node_support.h"

int main(int argc, char** argv) {
  return mm::runNode(argc, argv, "compensation", [](ros::NodeHandle node, ros::NodeHandle own) {
    mm::loadEffectPlugins([](const std::string& line) { ROS_WARN("%s", line.c_str()); });
    const mm::CompensationNode compensation(node, own, mm::machineFromParameter(node));
    ros::spin();
  });
}
