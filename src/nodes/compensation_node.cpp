#include "nodes/compensation_node.h"

#include <measuring_machine/Artifact.h>
#include <measuring_machine/CorrectedContact.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/names_of.h"
#include "drivers/device_link.h"
#include "ros_bridge/correction_messages.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

constexpr double kAwaited = 5.0;  // s for the first status of a driver that the master knows
constexpr int kSensorWait = 100;  // times 20 ms, for the first readings of a new calibration's sensors

LiveInputs::Settings settingsFrom(const ros::NodeHandle& own) {
  LiveInputs::Settings settings;
  settings.jointAge = numberParameter(own, "joint_timeout", settings.jointAge, 1e-6, 1e3);
  settings.sensorAge = numberParameter(own, "sensor_timeout", settings.sensorAge, 1e-3, 1e6);
  settings.deadband = numberParameter(own, "travel_deadband", settings.deadband, 0.0, 1e-3);
  settings.rotaryDeadband =
      numberParameter(own, "travel_deadband_rotary", settings.rotaryDeadband, 0.0, 1e-2);
  return settings;
}

void setAside(const std::string& what, const ros::Time& stamp) {
  ROS_WARN_THROTTLE(10.0, "%s set aside: %s", what.c_str(),
                    stamp.isZero()
                        ? "it has no stamp"
                        : "its stamp is earlier than that of the last one; check the publisher's clock");
}

template <typename Event>
JointOwners::Sender senderOf(const Event& event) {
  return {event.getPublisherName(), event.getConnectionHeaderPtr()};
}

}  // namespace

CompensationNode::CompensationNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine)
    : node_(node),
      machine_(machine),
      prefix_(framePrefix(own)),
      margin_(numberParameter(own, "margin", 0.1, 0.0, 10.0)),
      watch_(CalibrationStore(storeFolder(own, machine)), machine, machineSpace(), margin_),
      inputs_(machine, settingsFrom(own)),
      owners_(allNames(machine.joints())),
      updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(own, {"store", "margin", "frame_prefix", "drivers", "joint_timeout",
                                "sensor_timeout", "travel_deadband", "travel_deadband_rotary"});
  contactsOut_ = node.advertise<measuring_machine::CorrectedContact>("probe/contact_corrected", 1000);
  markersOut_ = own.advertise<visualization_msgs::MarkerArray>("correction", 10);
  statusOut_ = own.advertise<measuring_machine::CompensationStatus>("status", 100, true);
  if (const auto pair = watch_.refresh()) install(pair);
  updater_.setHardwareID("compensation");
  updater_.add("correction", this, &CompensationNode::diagnose);

  ros::NodeHandle slowNode(node), slowOwn(own);
  slowNode.setCallbackQueue(&slow_);
  slowOwn.setCallbackQueue(&slow_);
  for (const ros::NodeHandle& space : {slowOwn, slowNode})
    correctTarget_.push_back(offer<measuring_machine::CorrectTarget>(
        space, "correct_target",
        [this](auto& request, auto& response) { correctTarget(request, response); }));
  timer_ = slowNode.createWallTimer(ros::WallDuration(0.05), &CompensationNode::look, this);
  spinner_ = std::make_unique<ros::AsyncSpinner>(1, &slow_);

  reconfigured_ =
      std::make_unique<dynamic_reconfigure::Server<measuring_machine::CompensationConfig>>(slowOwn);
  reconfigured_->setCallback(
      [this](measuring_machine::CompensationConfig& config, std::uint32_t) { reconfigure(config); });

  const ros::TransportHints fast = ros::TransportHints().tcpNoDelay();
  contactsIn_ = node.subscribe("probe/contact", 1000, &CompensationNode::takeContact, this, fast);
  subscribeDrivers(own);
  artifactIn_ = node.subscribe<measuring_machine::Artifact>(
      "artifact", 10, [this](const measuring_machine::ArtifactConstPtr& message) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (owners_.zero() == 0)
          inputs_.setTimeZero(nanoseconds(message->header.stamp));  // a session replayed
      });
  jointsIn_ = node.subscribe("joint_states", 5000, &CompensationNode::takeJoints, this, fast);
  spinner_->start();
}

/// By dynamic_reconfigure, in the slow thread; at the start with the parameters as they are.
void CompensationNode::reconfigure(const measuring_machine::CompensationConfig& config) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    inputs_.setTimeouts(config.joint_timeout, config.sensor_timeout);
  }
  if (config.margin == margin_) return;
  margin_ = config.margin;
  install(watch_.setMargin(margin_));
}

void CompensationNode::apply(Applied& applied, const std::shared_ptr<const LoadedCalibration>& loaded) {
  if (applied.loaded == loaded) return;
  applied = Applied();
  applied.loaded = loaded;
  if (!loaded) return;
  applied.view = inputs_.watch(loaded->frames.model().domain());
  applied.state = loaded->frames.blankState();
}

void CompensationNode::install(const std::shared_ptr<const CalibrationPair>& pair) {
  bool swap = false;
  LiveInputs::View next;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    swap = active_.loaded && pair->active && pair->active != active_.loaded;
    if (pair->candidate) inputs_.watch(pair->candidate->frames.model().domain());
    if (pair->active) next = inputs_.watch(pair->active->frames.model().domain());
  }
  subscribeSensors();
  // One that works now gives way only when the sensors of the next have been heard: no gap.
  for (int i = 0; swap && i < kSensorWait; ++i) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (inputs_.heard(next)) break;
    }
    ros::WallDuration(0.02).sleep();
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    pair_ = pair;
    apply(active_, pair->active);
    apply(candidate_, pair->candidate);
  }
  if (!pair->warning.empty()) ROS_ERROR("active calibration: %s", pair->warning.c_str());
  if (!pair->candidateWarning.empty()) ROS_ERROR("candidate calibration: %s", pair->candidateWarning.c_str());
}

void CompensationNode::subscribeSensors() {
  for (const std::string& name : inputs_.sensors())
    if (temperaturesIn_.count(name) == 0)
      temperaturesIn_[name] = node_.subscribe<sensor_msgs::Temperature>(
          "temperature/" + topicOf(name), 100, [this, name](const sensor_msgs::TemperatureConstPtr& m) {
            const std::string sensor = sensorOf(topicOf(name), m->header.frame_id);
            if (sensor != topicOf(name) && sensor != name) return;  // another one on the same topic
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!inputs_.takeTemperature(name, nanoseconds(m->header.stamp), m->temperature))
              setAside("temperature '" + name + "'", m->header.stamp);
          });
  for (const std::string& name : inputs_.covariates())
    if (covariatesIn_.count(name) == 0)
      covariatesIn_[name] = node_.subscribe<measuring_machine::Covariate>(
          "covariate/" + topicOf(name), 100, [this, name](const measuring_machine::CovariateConstPtr& m) {
            if (m->name != name) return;
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!inputs_.takeCovariate(name, nanoseconds(m->header.stamp), m->value))
              setAside("covariate '" + name + "'", m->header.stamp);
          });
}

void CompensationNode::withhold(const std::string& reason, bool beyond) {
  active_.reason = reason;
  status_.extrapolating = beyond;
  ++status_.withheld;
  withheldSince_ = reason;
}

void CompensationNode::subscribeDrivers(const ros::NodeHandle& own) {
  std::set<std::string> topics;
  std::istringstream drivers(textParameter(own, "drivers", "axis_driver"));
  for (std::string driver; drivers >> driver;) {
    axesIn_.push_back(node_.subscribe(driver + "/status", 10, &CompensationNode::takeStatus, this));
    topics.insert(axesIn_.back().getTopic());
  }
  ros::master::V_TopicInfo published;
  ros::master::getTopics(published);
  for (const ros::master::TopicInfo& topic : published)
    if (topics.count(topic.name) != 0) owners_.awaitStatus(steadySeconds() + kAwaited);
}

void CompensationNode::takeStatus(const StatusEvent& event) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const measuring_machine::AxisStatus& message = *event.getConstMessage();
  if (message.header.stamp.isZero()) return;  // none was heard yet
  JointOwners::Status status;
  status.stamp = nanoseconds(message.header.stamp);
  status.homed = message.homed != 0;
  status.homedAt = nanoseconds(message.homed_at);
  for (std::size_t i = 0; i < message.name.size(); ++i) {
    const int joint = machine_.findJoint(message.name[i]);
    if (joint < 0) continue;
    status.joints.push_back(joint);
    status.travel.push_back(i < message.travel.size() ? message.travel[i] : 0);
  }
  nameStranger(owners_.take(senderOf(event), status, steadySeconds()));
  inputs_.setTimeZero(owners_.zero());
}

void CompensationNode::nameStranger(const std::string& why) {
  if (why.empty()) return;
  ROS_WARN_THROTTLE(10.0, "%s", why.c_str());
  stranger_ = why;
  strangerAt_ = ros::WallTime::now();
}

/// Whether the joint state is of whom the joints are, and of a machine that is homed. What its driver knows
/// of the motion until then counts from it on.
bool CompensationNode::believes(const JointsEvent& event) {
  const sensor_msgs::JointState& message = *event.getConstMessage();
  joints_.clear();
  for (const std::string& name : message.name)
    if (const int joint = machine_.findJoint(name); joint >= 0) joints_.push_back(joint);
  if (joints_.empty()) return false;  // a gripper's
  const Homing homing = homingOf(message);
  const JointOwners::State state{nanoseconds(message.header.stamp), homing.told, homing.homed,
                                 nanoseconds(homing.at)};
  const JointOwners::Verdict verdict = owners_.take(senderOf(event), state, joints_, steadySeconds());
  if (verdict.foreign) {
    ++status_.withheld;
    nameStranger(verdict.why);
    return false;
  }
  heard_ = ros::WallTime::now();
  if (verdict.forget) {
    for (const int joint : joints_) inputs_.forgetTravel(joint);
    inputs_.setTimeZero(owners_.zero());
  }
  if (!verdict.why.empty()) {
    withhold(verdict.why);
    candidate_.reason = verdict.why;
    return false;
  }
  for (std::size_t i = 0; verdict.status && i < verdict.status->joints.size(); ++i)
    inputs_.takeTravel(verdict.status->joints[i], verdict.status->stamp, verdict.status->travel[i]);
  return true;
}

void CompensationNode::takeJoints(const JointsEvent& event) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!believes(event)) return;
  const sensor_msgs::JointState& message = *event.getConstMessage();
  std::string reason;
  const bool ready = inputs_.takeJoints(nanoseconds(message.header.stamp), message.name, message.position,
                                        message.velocity, reason);
  if (ready && owners_.anyNotHomed()) reason = JointOwners::kUnhomed;
  if (!reason.empty()) {
    withhold(reason);
    candidate_.reason = reason;
  }
  if (!reason.empty() || !ready) return;
  frames_.clear();
  if (active_.loaded) addFrame(active_, message.header.stamp, "probe_tip_corrected", true);
  if (candidate_.loaded) addFrame(candidate_, message.header.stamp, "probe_tip_candidate", false);
  if (!frames_.empty()) broadcaster_.sendTransform(frames_);
}

void CompensationNode::addFrame(Applied& applied, const ros::Time& stamp, const std::string& child,
                                bool isActive) {
  const Model& model = applied.loaded->frames.model();
  const bool laser = model.domain().laser;
  inputs_.fill(applied.view, applied.state);
  if (laser) applied.state.laserReading = 0.0;  // the tip, not the spot
  model.place(applied.state);
  applied.state.approach.setZero();
  if (laser) applied.state.approach = applied.state.orientation.col(2);
  const Correction c = applied.loaded->frames.apply(applied.state, applied.work);
  applied.note = c.note;
  if (isActive) {
    status_.extrapolating = c.extrapolating;
    status_.sensor_lost = c.inputLost;
    status_.too_old = c.tooOld;
  }
  if (!c.valid) {
    if (isActive)
      withhold(c.reason, c.extrapolating);
    else
      applied.reason = c.reason;
    return;
  }
  applied.reason.clear();
  if (isActive) ++status_.frames;
  frames_.push_back(toTransform(c.corrected, stamp, prefix_ + "workpiece", prefix_ + child));
}

void CompensationNode::takeContact(const measuring_machine::ProbeContactConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!active_.loaded) return;
  bool beyond = false;
  try {
    if (owners_.anyNotHomed()) throw InputError(JointOwners::kUnhomed);
    const Observation contact = fromMessage(*message, machine_);
    const Compensator& compensator = active_.loaded->contacts;
    MovingState state = compensator.blankState();
    inputs_.fill(active_.view, nanoseconds(message->header.stamp), contact.position, contact.velocity, state);
    state.laserReading = contact.laserReading;
    compensator.model().place(state);
    const bool laser = std::isfinite(contact.laserReading);
    if (!laser && contact.approach.allFinite()) state.approach = contact.approach;
    state.feature = compensator.model().domain().findFeature(message->feature);
    const Correction c = compensator.apply(state);
    beyond = c.extrapolating;
    if (!c.valid) throw InputError("contact on '" + message->feature + "' is not corrected: " + c.reason);
    contactsOut_.publish(toContactMessage(*message, c, active_.loaded->calibration));
  } catch (const std::exception& e) {
    withheldSince_ = e.what();
    if (isNews(beyond, active_.loaded->id, contactBeyond_)) ROS_WARN_THROTTLE(10.0, "%s", e.what());
  }
}

std::vector<double> CompensationNode::arrivalOf(
    const measuring_machine::CorrectTarget::Request& request) const {
  std::vector<double> arrival(machine_.joints().size(), 0.0);
  const std::size_t named = request.name.empty() ? arrival.size() : request.name.size();
  if (!request.travel.empty() && request.travel.size() != named)
    throw InputError("field 'travel' has " + std::to_string(request.travel.size()) + " directions for " +
                     std::to_string(named) + " joints");
  for (std::size_t i = 0; i < request.travel.size(); ++i) {
    const int joint = request.name.empty() ? static_cast<int>(i) : machine_.findJoint(request.name[i]);
    if (joint >= 0) arrival[joint] = request.travel[i] > 0 ? 1.0 : (request.travel[i] < 0 ? -1.0 : 0.0);
  }
  return arrival;
}

void CompensationNode::correctTarget(const measuring_machine::CorrectTarget::Request& request,
                                     measuring_machine::CorrectTarget::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!active_.loaded) throw InputError("no calibration is active; calibrate and promote one");
  if (owners_.anyNotHomed() && request.name.empty()) throw InputError(JointOwners::kUnhomed);
  MovingState state = active_.state;
  inputs_.fill(active_.view, state);
  const std::vector<double> arrival = arrivalOf(request);
  if (request.name.empty()) {
    if (isSilent())
      throw InputError(
          "no joint states are received, so the present readings are unknown; name joints and positions to "
          "start from");
    if (!inputs_.complete())
      throw InputError("the present readings are unknown; name joints and positions to start from");
  } else {
    measuring_machine::ProbeContact start;  // for its order of the joints and its messages
    start.name = request.name;
    start.position = request.position;
    state.position = fromMessage(start, machine_).position;
    std::fill(state.travel.begin(), state.travel.end(), 0.0);
    state.sinceReversal.clear();
  }
  std::fill(state.velocity.begin(), state.velocity.end(), 0.0);
  const Eigen::Vector3d target(request.target.x, request.target.y, request.target.z);
  const TargetReadings found = active_.loaded->contacts.correctTarget(target, state, arrival);
  response.calibration_id = active_.loaded->id;
  response.name = allNames(machine_.joints());
  response.position = found.position;
  response.sigma = found.sigma;
  if (!found.reached) throw InputError("target not reached: " + found.reason);
  response.message = found.correction.note;
}

}  // namespace mm
