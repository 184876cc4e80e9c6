#include "nodes/compensation_node.h"
#include "ros_bridge/node_support.h"

int main(int argc, char** argv) {
  return mm::runNode(argc, argv, "compensation", [] {
    ros::NodeHandle node, own("~");
    const mm::CompensationNode compensation(node, own, mm::machineFromParameter(node));
    ros::spin();
  });
}
