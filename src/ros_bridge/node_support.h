#pragma once
#include <ros/node_handle.h>
#include <ros/param.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "machine/machine.h"

namespace mm {

/// The URDF on the parameter server (`robot_description`, looked for upwards from the node's namespace) as a
/// machine, with the serial that the parameter `serial` states beside it, if any: it is then part of the URDF
/// that is recorded. @throw InputError when it is missing, no machine, or has another serial already.
Machine machineFromParameter(const ros::NodeHandle& node);

/// A value that is a text, a number or a flag, as one writes it; empty: it is none of these.
std::optional<std::string> textOf(XmlRpc::XmlRpcValue value);
/// A private parameter, or `standard` where it is not set. @throw InputError when it has another type.
std::string textParameter(const ros::NodeHandle& node, const std::string& name, const std::string& standard);
/// @throw InputError when it has another type or is outside `lower` … `upper`.
double numberParameter(const ros::NodeHandle& node, const std::string& name, double standard, double lower,
                       double upper);
bool flagParameter(const ros::NodeHandle& node, const std::string& name, bool standard);
/// Folder of the calibrations: parameter `store`, else in the one that `mm` uses the folder of this machine
/// (by its serial, else by its namespace; the only machine has the whole).
/// @param own the node's private handle.
std::filesystem::path storeFolder(const ros::NodeHandle& own, const Machine& machine);
/// What stands before the names of the machine's frames: parameter `frame_prefix`, looked for upwards from
/// the node's private namespace. @throw InputError when it has another type.
std::string framePrefix(const ros::NodeHandle& own);
/// Namespace that the node stands in, "/" or "/m1".
std::string machineSpace();
/// @throw InputError naming a private parameter that the node does not know. Those with a `/` belong to
/// others.
void refuseUnknownParameters(const ros::NodeHandle& node, const std::vector<std::string>& known);

/// The boundary of a service: `work` fills the response; what it throws becomes `success: false` and a
/// message.
template <typename Response, typename Work>
void answer(Response& response, Work&& work) {
  try {
    response.success = true;
    work();
  } catch (const std::exception& e) {
    response.success = false;
    response.message = e.what();
  }
}

/// Offers a service: `work` gets the request and fills the response, within `answer`.
template <typename Service, typename Work>
ros::ServiceServer offer(ros::NodeHandle node, const std::string& name, Work work) {
  using Request = typename Service::Request;
  using Response = typename Service::Response;
  return node.advertiseService<Request, Response>(name, [work](Request& request, Response& response) {
    answer(response, [&] { work(request, response); });
    return true;
  });
}

/// The boundary of a node: initialises ROS, runs `work` with its handles (the private one second) and says
/// what it throws. With MM_RESPAWN=true in the environment (roslaunch starts the node again) wrong parameters
/// do not end it before they change, or half a minute is over.
/// @return exit status: 0, or 2 for bad parameters.
int runNode(int argc, char** argv, const std::string& name,
            const std::function<void(ros::NodeHandle, ros::NodeHandle)>& work);

/// From here on SIGINT, SIGTERM, SIGHUP and `rosnode kill` only ask for the end: whoever moves a machine
/// stops it first, and for that ROS must still live. SIGHUP stays ignored where it was (nohup). Call it after
/// `ros::start`, once, in a node that then waits with `waitForEnd`.
void endWhileRosLives();
/// Until the end is asked for, or ROS has been shut down.
void waitForEnd();

}  // namespace mm
