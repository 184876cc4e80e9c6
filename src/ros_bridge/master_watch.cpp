#include "ros_bridge/master_watch.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/network.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <ros/publication.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>

#include <chrono>

namespace mm {
namespace {

constexpr auto kTick = std::chrono::milliseconds(100);
constexpr int kLook = 10;  // ticks between two looks at the master
constexpr int kSettle =
    20;  // looks after the first in which services are looked at each time: they come one by one
constexpr int kRemember = 5;  // looks between two of the services later

/// Topics and services of other nodes would be found as well, but only what this one has is its to register.
bool has(const XmlRpc::XmlRpcValue& names, const std::string& node) {
  for (int i = 0; i < names.size(); ++i)
    if (static_cast<std::string>(names[i]) == node) return true;
  return false;
}

/// What a master tells a subscriber when publishers come and go; here told by the node to itself, as the new
/// master answers who publishes already, and tells only who comes later.
void tellPublishers(const std::string& topic, XmlRpc::XmlRpcValue publishers) {
  if (publishers.getType() != XmlRpc::XmlRpcValue::TypeArray || publishers.size() == 0) return;
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  request[1] = topic;
  request[2] = publishers;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(ros::XMLRPCManager::instance()->getServerURI(), host, port)) return;
  XmlRpc::XmlRpcClient self(host.c_str(), static_cast<int>(port), "/");
  self.execute("publisherUpdate", request, response);
}

}  // namespace

MasterWatch::MasterWatch() {
  thread_ = std::thread([this] { run(); });
}

MasterWatch::~MasterWatch() {
  ending_ = true;
  thread_.join();
}

void MasterWatch::run() {
  for (int tick = 0; !ending_ && !ros::isShuttingDown(); ++tick) {
    std::this_thread::sleep_for(kTick);
    if (tick % kLook != 0 || !ros::isStarted()) continue;
    try {
      look();
    } catch (const XmlRpc::XmlRpcException& e) {
      ROS_ERROR("the answer of the ROS master cannot be read: %s", e.getMessage().c_str());
    }
  }
}

bool MasterWatch::call(const std::string& method, const std::vector<std::string>& words,
                       XmlRpc::XmlRpcValue& answer) const {
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  for (const std::string& word : words) request[request.size()] = word;
  return ros::master::execute(method, request, response, answer, false);
}

void MasterWatch::look() {
  const std::string self = ros::this_node::getName(), uri = ros::master::getURI();
  XmlRpc::XmlRpcValue answer;
  // A new master knows the node as soon as this asks it for a parameter (every line of the log does), though
  // no topic of it: so the master itself is told from the one before, and one of the services must be found.
  if (!call("getPid", {}, answer)) {
    if (!known_) return;
    if (!away_)
      ROS_ERROR(
          "the ROS master at %s does not answer: existing connections continue, new ones are impossible; "
          "restart it, and this node will register again by itself",
          uri.c_str());
    away_ = true;
    return;
  }
  const int pid = static_cast<int>(answer);
  if (!known_) {
    if (!call("lookupNode", {self}, answer)) return;  // not registered yet
    master_ = pid;
  }
  const bool same = pid == master_ && call("lookupNode", {self}, answer) &&
                    (services_.empty() || call("lookupService", {services_.begin()->first}, answer));
  if (!same) {
    away_ = false;
    if (registerAgain()) master_ = pid;
    return;
  }
  if (away_) ROS_WARN("the ROS master at %s answers again", uri.c_str());
  away_ = false;
  if (turns_ < kSettle || turns_ % kRemember == 0) remember();
  ++turns_;
  known_ = true;
}

/// What must be told again: services (roscpp does not list them) and parameters.
void MasterWatch::remember() {
  const std::string self = ros::this_node::getName();
  XmlRpc::XmlRpcValue state;
  if (call("getSystemState", {}, state) && state.size() == 3) {
    for (int i = 0; i < state[2].size(); ++i) {
      const std::string service = state[2][i][0];
      XmlRpc::XmlRpcValue uri;
      if (has(state[2][i][1], self) && services_.count(service) == 0 && call("lookupService", {service}, uri))
        services_[service] = static_cast<std::string>(uri);
    }
  }
  ros::NodeHandle node;
  std::vector<std::string> names;
  ros::param::getParamNames(names);
  std::set<std::string> shared{"/use_sim_time"};
  for (const char* of : {"robot_description", "serial", "frame_prefix", "tf_prefix"})
    if (std::string found; node.searchParam(of, found)) shared.insert(found);
  for (const std::string& name : names)
    if (name.rfind(self + "/", 0) == 0 || shared.count(name) != 0) ros::param::get(name, parameters_[name]);
}

bool MasterWatch::registerAgain() {
  const std::string node = ros::XMLRPCManager::instance()->getServerURI();
  XmlRpc::XmlRpcValue answer;
  bool done = true;
  for (const auto& [name, value] : parameters_)
    if (!ros::param::has(name)) ros::param::set(name, value);
  ros::V_string topics;
  ros::TopicManager::instance()->getSubscribedTopics(topics);
  for (const std::string& topic : topics) {
    done = call("registerSubscriber", {topic, "*", node}, answer) && done;
    tellPublishers(topic, answer);
  }
  ros::TopicManager::instance()->getAdvertisedTopics(topics);
  for (const std::string& topic : topics)
    if (const ros::PublicationPtr publication = ros::TopicManager::instance()->lookupPublication(topic))
      done = call("registerPublisher", {topic, publication->getDataType(), node}, answer) && done;
  for (const auto& [service, uri] : services_)
    done = call("registerService", {service, uri, node}, answer) && done;
  if (done)
    ROS_WARN(
        "the ROS master at %s was restarted: this node is registered again, with %zu topics and %zu services",
        ros::master::getURI().c_str(), topics.size(), services_.size());
  return done;
}

}  // namespace mm
