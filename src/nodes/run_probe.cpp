#include "nodes/probe_node.h"
#include "nodes/run.h"
#include "ros_bridge/node_support.h"

int mm::runProbe(int argc, char** argv) {
  return mm::runNode(argc, argv, "probe", [] {
    ros::NodeHandle node, own("~");
    const mm::ProbeNode probe(node, own, mm::machineFromParameter(node));
    ros::spin();
  });
}
