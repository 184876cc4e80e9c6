#include "nodes/temperature_node.h"

#include <sensor_msgs/Temperature.h>

#include <chrono>

#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

/// The parameter `sensors`: a list of mappings. @throw InputError.
std::vector<TemperatureSetup> sensorsParameter(const ros::NodeHandle& own) {
  std::vector<TemperatureSetup> sensors;
  XmlRpc::XmlRpcValue list;
  if (!own.getParam("sensors", list)) return sensors;
  const std::string where = "parameter '" + own.resolveName("sensors") + "'";
  if (list.getType() != XmlRpc::XmlRpcValue::TypeArray)
    throw InputError(where + " must be a list of sensors, as in config/sensors.yaml");
  for (int i = 0; i < list.size(); ++i) {
    if (list[i].getType() != XmlRpc::XmlRpcValue::TypeStruct)
      throw InputError(where + ", item " + std::to_string(i + 1) +
                       ": must be a mapping, as {name: bed, hwmon: …}");
    TemperatureSetup setup;
    for (auto& [key, value] : list[i]) {
      const std::optional<std::string> text = textOf(value);
      if (!text)
        throw InputError(where + ", item " + std::to_string(i + 1) + ", '" + key +
                         "': is neither text nor a number");
      (key == "name" ? setup.name : setup.keys[key]) = *text;
    }
    sensors.push_back(std::move(setup));
  }
  return sensors;
}

}  // namespace

TemperatureNode::TemperatureNode(ros::NodeHandle node, ros::NodeHandle own)
    : node_(node), updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(own, {"frozen_after", "timeout", "variance", "fastest", "sensors", "poll_rate",
                                "sysfs", "frame_prefix"});
  trust_.frozenAfter = numberParameter(own, "frozen_after", trust_.frozenAfter, 0.0, 1e9);
  timeout_ = numberParameter(own, "timeout", 10.0, 0.01, 1e6);
  frame_ = framePrefix(own) + "workpiece";  // where on the machine it sits is not known
  variance_ = numberParameter(own, "variance", 0.0, 0.0, 1e6);
  trust_.fastest = numberParameter(own, "fastest", trust_.fastest, 0.0, 1e6);
  const double period = 1.0 / numberParameter(own, "poll_rate", 2.0, 0.001, 100.0);
  for (auto& device : makeTemperatureDevices(sensorsParameter(own), textParameter(own, "sysfs", "/sys"))) {
    for (const std::string& name : device->names()) {
      own_[name] = true;
      if (!topicIsOf(name))
        throw InputError("sensors '" + topics_[topicOf(name)] + "' and '" + name +
                         "' would both be temperature/" + topicOf(name) + "; rename one of them");
    }
    pollers_.push_back(std::make_unique<Poller>());
    pollers_.back()->device = std::move(device);
  }
  in_ = node.subscribe("axis_driver/temperatures", 100, &TemperatureNode::take, this);
  accept_ =
      offer<std_srvs::Trigger>(own, "accept", [this](auto&, auto& response) { response.message = accept(); });
  updater_.setHardwareID("temperature sensors");
  updater_.add("sensors", this, &TemperatureNode::diagnose);
  timer_ =
      node.createWallTimer(ros::WallDuration(0.5), [this](const ros::WallTimerEvent&) { updater_.update(); });
  if (pollers_.empty()) return;
  pollTimer_ = node.createWallTimer(ros::WallDuration(std::min(period, 0.1)),
                                    [this](const ros::WallTimerEvent&) { takePolled(); });
  for (auto& poller : pollers_)
    poller->thread = std::thread([this, one = poller.get(), period] { poll(*one, period); });
}

TemperatureNode::~TemperatureNode() {
  ends_ = true;
  for (auto& poller : pollers_) poller->thread.join();
}

/// Names differ in more than topics can: the first that comes has the topic.
bool TemperatureNode::topicIsOf(const std::string& name) {
  return topics_.emplace(topicOf(name), name).first->second == name;
}

/// In a thread of its own: a line that waits for its timeout keeps nothing else from being read.
void TemperatureNode::poll(Poller& poller, double period) const {
  using Clock = std::chrono::steady_clock;
  const auto step = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period));
  for (auto next = Clock::now(); !ends_;) {
    const ros::Time before = ros::Time::now();
    std::vector<TemperatureReading> readings = poller.device->read();
    const ros::Time after = ros::Time::now();
    {
      const std::lock_guard<std::mutex> lock(poller.mutex);
      poller.waiting.push_back(
          {after > before ? before + (after - before) * 0.5 : after, std::move(readings)});
    }
    next = std::max(next + step, Clock::now());
    while (!ends_ && Clock::now() < next)
      std::this_thread::sleep_for(
          std::min<Clock::duration>(next - Clock::now(), std::chrono::milliseconds(50)));
  }
}

void TemperatureNode::takePolled() {
  for (auto& poller : pollers_) {
    std::vector<Polled> waiting;
    {
      const std::lock_guard<std::mutex> lock(poller->mutex);
      waiting.swap(poller->waiting);
    }
    for (const Polled& polled : waiting) {
      if (polled.stamp.isZero()) continue;  // before the first word of /clock
      for (std::size_t i = 0; i < polled.readings.size(); ++i)
        takeOne(poller->device->names()[i], polled.readings[i], polled.stamp);
    }
  }
}

void TemperatureNode::take(const measuring_machine::SensorReadings& readings) {
  const ros::Time now = readings.header.stamp;
  for (std::size_t i = 0; i < std::min(readings.name.size(), readings.temperature.size()); ++i) {
    if (own_.count(readings.name[i]) > 0) {
      ROS_ERROR_ONCE(
          "sensor '%s' is defined at the controller and in the parameter 'sensors'; the parameter is used",
          readings.name[i].c_str());
      continue;
    }
    if (!topicIsOf(readings.name[i])) {
      ROS_ERROR_ONCE("the controller's sensor '%s' has the topic of '%s'; it is ignored, rename one of them",
                     readings.name[i].c_str(), topics_[topicOf(readings.name[i])].c_str());
      continue;
    }
    takeOne(readings.name[i], {readings.temperature[i], {}}, now);
  }
}

void TemperatureNode::takeOne(const std::string& name, const TemperatureReading& reading,
                              const ros::Time& now) {
  auto found = sensors_.find(name);
  if (found == sensors_.end()) {
    const ros::Publisher out = node_.advertise<sensor_msgs::Temperature>("temperature/" + topicOf(name), 100);
    found = sensors_.emplace(name, Sensor{out, TemperatureTrust(name, trust_), now}).first;
  }
  Sensor& sensor = found->second;
  const TemperatureTrust::Doubt before = sensor.trust.doubt();
  const bool believed = sensor.trust.take(reading, now.toSec());
  sensor.seen = now;
  if (!believed && sensor.trust.doubt() != before)
    ROS_WARN("%s; it is not published", sensor.trust.why().c_str());
  if (!sensor.trust.remark().empty()) ROS_WARN("%s", sensor.trust.remark().c_str());
  if (sensor.trust.doubt() != before || !sensor.trust.remark().empty()) updater_.force_update();
  if (!believed) return;
  sensor_msgs::Temperature message;
  message.header.stamp = now;
  message.header.frame_id = frame_;
  message.temperature = reading.value;
  message.variance = variance_;
  sensor.out.publish(message);
}

/// @return what that changes, for people.
std::string TemperatureNode::accept() {
  std::string all;
  for (auto& entry : sensors_) {
    const std::string changes = entry.second.trust.accept();
    if (changes.empty()) continue;
    ROS_WARN("%s, because ~accept was called", changes.c_str());
    addWords(all, changes);
  }
  if (all.empty()) throw InputError("no sensor has jumped: there is nothing to accept");
  return all;
}

void TemperatureNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, std::to_string(sensors_.size()) + " sensors");
  if (sensors_.empty()) status.summary(DiagnosticStatus::WARN, "no sensor value has been received yet");
  const ros::Time now = ros::Time::now();
  for (const auto& [name, sensor] : sensors_) {
    status.add(name, sensor.trust.value());
    if (!sensor.trust.toLookAt().empty())
      status.mergeSummary(DiagnosticStatus::WARN, sensor.trust.toLookAt());
    if (!sensor.trust.why().empty())
      status.mergeSummary(DiagnosticStatus::ERROR, sensor.trust.why());
    else if (now > sensor.seen && (now - sensor.seen).toSec() > timeout_)
      status.mergeSummary(DiagnosticStatus::ERROR,
                          "sensor '" + name + "' has been silent for " +
                              std::to_string(static_cast<int>((now - sensor.seen).toSec())) + " s");
  }
}

}  // namespace mm
