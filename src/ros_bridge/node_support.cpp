#include "ros_bridge/node_support.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <csignal>
#include <cstdlib>

#include "base/nearest_name.h"
#include "base/number_text.h"
#include "calibration_file/calibration_fit.h"
#include "calibration_file/calibration_store.h"
#include "machine/machine_fit.h"
#include "ros_bridge/master_watch.h"

namespace mm {
namespace {

[[noreturn]] void wrongType(const ros::NodeHandle& node, const std::string& name, const std::string& needed) {
  throw InputError("parameter '" + node.resolveName(name) + "' is not " + needed);
}

constexpr double kBetweenTries = 30.0;  // s

std::atomic<bool> endAsked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "it is set by a signal");

void askForEnd(int /*signal*/) { endAsked = true; }

/// Whether roslaunch starts the node again when it ends, as the launch file says.
bool comesUpAgain() {
  const char* const respawn = std::getenv("MM_RESPAWN");
  return respawn != nullptr && std::string(respawn) == "true";
}

/// What the node was started with: its own parameters and the machine.
std::string parametersNow(const ros::NodeHandle& own) {
  std::string text, key;
  XmlRpc::XmlRpcValue value;
  if (own.getParam(own.getNamespace(), value)) text = value.toXml();
  for (const char* const name : {"robot_description", "serial", "frame_prefix"})
    if (own.searchParam(name, key) && own.getParam(key, value)) text += value.toXml();
  return text;
}

/// Started again at once with the same parameters the node would fail again, for ever: it stays, in error on
/// /diagnostics, until they change or it is ended, or until it is time to look whether something else that
/// was in its way, a port or a file, no longer is.
void waitForOtherParameters(const std::string& wrong) {
  const ros::WallDuration kBetween(1.0);  // between looks
  ros::NodeHandle node, own("~");
  ROS_FATAL("%s; the node tries again in %.0f s, or when its parameters change (rosparam set)", wrong.c_str(),
            kBetweenTries);
  diagnostic_updater::Updater updater(node, own, ros::this_node::getName());
  updater.setHardwareID(ros::this_node::getName());
  updater.add("parameters", [&](diagnostic_updater::DiagnosticStatusWrapper& status) {
    status.summary(diagnostic_msgs::DiagnosticStatus::ERROR, wrong);
  });
  const std::string before = parametersNow(own);
  const ros::SteadyTime end = ros::SteadyTime::now() + ros::WallDuration(kBetweenTries);
  while (ros::ok() && !endAsked && ros::SteadyTime::now() < end && parametersNow(own) == before) {
    updater.force_update();
    kBetween.sleep();
  }
}

}  // namespace

Machine machineFromParameter(const ros::NodeHandle& node) {
  std::string key, urdf;
  if (!node.searchParam("robot_description", key) || !node.getParam(key, urdf))
    throw InputError(
        "parameter 'robot_description' is missing; launch the node with instrument.launch, or "
        "load the machine's URDF there");
  std::string serialKey;
  const std::string serial =
      node.searchParam("serial", serialKey) ? textParameter(node, serialKey, "") : std::string();
  if (serial.empty()) return Machine(urdf, "robot_description");
  const Machine machine(urdf, "robot_description");
  if (!serialOf(machine).empty() && serialOf(machine) != serial)
    throw InputError("parameter '" + serialKey + "' is '" + serial + "', but the URDF says '" +
                     serialOf(machine) + "'; remove one of them");
  const bool plain = std::all_of(serial.begin(), serial.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.' || c == ' ' || c == '/';
  });
  if (!plain)
    throw InputError("parameter '" + serialKey + "' is '" + serial +
                     "'; a serial consists of letters, digits and -_./");
  const std::size_t end = urdf.rfind("</robot>");
  if (serialOf(machine).empty() && end != std::string::npos)
    urdf.insert(end, "<serial>" + serial + "</serial>\n");
  return Machine(urdf, "robot_description");
}

std::string framePrefix(const ros::NodeHandle& own) {
  std::string name;
  return own.searchParam("frame_prefix", name) ? textParameter(own, name, "") : "";
}

std::string machineSpace() { return ros::this_node::getNamespace(); }

std::optional<std::string> textOf(XmlRpc::XmlRpcValue value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    case XmlRpc::XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return numberText(static_cast<double>(value));
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    default:
      return std::nullopt;
  }
}

std::string textParameter(const ros::NodeHandle& node, const std::string& name, const std::string& standard) {
  XmlRpc::XmlRpcValue value;
  if (!node.getParam(name, value)) return standard;
  const std::optional<std::string> text = textOf(value);
  if (!text) wrongType(node, name, "a text");
  return *text;
}

double numberParameter(const ros::NodeHandle& node, const std::string& name, double standard, double lower,
                       double upper) {
  XmlRpc::XmlRpcValue value;
  if (!node.getParam(name, value)) return standard;
  double number = 0.0;
  if (value.getType() == XmlRpc::XmlRpcValue::TypeInt)
    number = static_cast<int>(value);
  else if (value.getType() == XmlRpc::XmlRpcValue::TypeDouble)
    number = static_cast<double>(value);
  else
    wrongType(node, name, "a number");
  if (!(number >= lower && number <= upper))
    throw InputError("parameter '" + node.resolveName(name) + "' is " + std::to_string(number) +
                     "; it must be from " + std::to_string(lower) + " to " + std::to_string(upper));
  return number;
}

bool flagParameter(const ros::NodeHandle& node, const std::string& name, bool standard) {
  XmlRpc::XmlRpcValue value;
  if (!node.getParam(name, value)) return standard;
  if (value.getType() != XmlRpc::XmlRpcValue::TypeBoolean) wrongType(node, name, "true or false");
  return static_cast<bool>(value);
}

std::filesystem::path storeFolder(const ros::NodeHandle& own, const Machine& machine) {
  const std::string folder = textParameter(own, "store", "");
  if (!folder.empty()) return folder;
  const std::string part = folderOf(machine, machineSpace());
  return part.empty() ? CalibrationStore::defaultFolder() : CalibrationStore::defaultFolder() / part;
}

void refuseUnknownParameters(const ros::NodeHandle& node, const std::vector<std::string>& known) {
  const std::string own = node.getNamespace() + "/";
  std::vector<std::string> names;
  ros::param::getParamNames(names);
  for (const std::string& full : names) {
    if (full.rfind(own, 0) != 0) continue;
    const std::string name = full.substr(own.size());
    if (name.find('/') != std::string::npos || std::count(known.begin(), known.end(), name) > 0) continue;
    throw InputError("parameter '" + full + "' is not known" + didYouMean(name, known));
  }
}

void endWhileRosLives() {
  struct sigaction ours {};
  ours.sa_handler = askForEnd;
  sigemptyset(&ours.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;
    sigaction(signal, &ours, nullptr);
  }
  ros::XMLRPCManager::instance()->unbind("shutdown");
  ros::XMLRPCManager::instance()->bind("shutdown",
                                       [](XmlRpc::XmlRpcValue& /*request*/, XmlRpc::XmlRpcValue& answer) {
                                         endAsked = true;
                                         answer = ros::xmlrpc::responseInt(1, "", 0);
                                       });
}

void waitForEnd() {
  while (!endAsked && ros::ok()) ros::WallDuration(0.02).sleep();
}

int runNode(int argc, char** argv, const std::string& name,
            const std::function<void(ros::NodeHandle, ros::NodeHandle)>& work) {
  ros::init(argc, argv, name);
  ros::start();  // else what went wrong is said after the last handle of `work` has ended, to nobody
  const MasterWatch watch;
  int status = 0;
  try {
    work(ros::NodeHandle(), ros::NodeHandle("~"));
  } catch (const std::exception& e) {
    status = 2;
    const bool input = dynamic_cast<const InputError*>(&e) != nullptr;
    if (input && comesUpAgain())
      waitForOtherParameters(e.what());
    else
      ROS_FATAL("%s", e.what());
  }
  ros::shutdown();
  return status;
}

}  // namespace mm
