#include "nodes/temperature_node.h"
#include "ros_bridge/node_support.h"

int main(int argc, char** argv) {
  return mm::runNode(argc, argv, "temperature", [](ros::NodeHandle node, ros::NodeHandle own) {
    const mm::TemperatureNode temperature(node, own);
    ros::spin();
  });
}
