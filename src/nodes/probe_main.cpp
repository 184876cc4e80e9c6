#include "nodes/probe_node.h"
#include "ros_bridge/node_support.h"

int main(int argc, char** argv) {
  return mm::runNode(argc, argv, "probe", [](ros::NodeHandle node, ros::NodeHandle own) {
    const mm::ProbeNode probe(node, own, mm::machineFromParameter(node));
    ros::spin();
  });
}
