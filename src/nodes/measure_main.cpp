#include "nodes/measure_node.h"
#include "ros_bridge/node_support.h"

int main(int argc, char** argv) {
  return mm::runNode(argc, argv, "measure", [](ros::NodeHandle node, ros::NodeHandle own) {
    ros::AsyncSpinner spinner(3);
    const mm::MeasureNode measure(node, own, mm::machineFromParameter(node));
    mm::endWhileRosLives();
    spinner.start();
    mm::waitForEnd();
  });
}
