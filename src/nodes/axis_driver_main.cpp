#include <pluginlib/class_loader.hpp>

#include "nodes/axis_driver.h"
#include "ros_bridge/node_support.h"

namespace {

/// What `~controller/…` holds, for the controller.
mm::AxisController::Parameters controllerParameters(const ros::NodeHandle& own) {
  mm::AxisController::Parameters parameters;
  const std::string prefix = own.resolveName("controller") + "/";
  std::vector<std::string> names;
  ros::param::getParamNames(names);
  for (const std::string& name : names)
    if (name.rfind(prefix, 0) == 0) parameters[name.substr(prefix.size())] = mm::textParameter(own, name, "");
  return parameters;
}

}  // namespace

int main(int argc, char** argv) {
  return mm::runNode(argc, argv, "axis_driver", [](ros::NodeHandle node, ros::NodeHandle own) {
    const mm::Machine machine = mm::machineFromParameter(node);
    pluginlib::ClassLoader<mm::AxisController> loader("measuring_machine", "mm::AxisController");
    const std::string hardware = mm::textParameter(own, "hardware", "simulated");
    if (!loader.isClassAvailable(hardware))
      throw mm::InputError("no controller is called '" + hardware + "' (parameter ~hardware)");
    const boost::shared_ptr<mm::AxisController> plugin = loader.createInstance(hardware);
    std::shared_ptr<mm::AxisController> controller(plugin.get(), [plugin](mm::AxisController*) {});
    if (controller->interface() != mm::kControllerInterface)
      throw mm::InputError("controller '" + hardware + "' was built with version " +
                           std::to_string(controller->interface()) + " of axis_controller.h, this is " +
                           std::to_string(mm::kControllerInterface) + "; build it again");
    controller->open(mm::controllerSetup(machine, controllerParameters(own)));
    ros::AsyncSpinner spinner(4);
    mm::AxisDriver driver(node, own, controller, machine);
    mm::endWhileRosLives();
    spinner.start();
    mm::waitForEnd();
  });
}
