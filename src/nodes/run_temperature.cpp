#include "nodes/run.h"
#include "nodes/temperature_node.h"
#include "ros_bridge/node_support.h"

int mm::runTemperature(int argc, char** argv) {
  return mm::runNode(argc, argv, "temperature", [] {
    ros::NodeHandle node, own("~");
    const mm::TemperatureNode temperature(node, own);
    ros::spin();
  });
}
