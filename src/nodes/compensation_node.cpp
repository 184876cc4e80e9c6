#include "nodes/compensation_node.h"

#include <measuring_machine/Artifact.h>
#include <measuring_machine/CorrectedContact.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "ros_bridge/correction_messages.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

constexpr double kSilent = 1.0;  // s without a joint state, on the wall clock
const char* const kUnhomed = "the axes are not homed, so their readings have no zero; call axis_driver/home";
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
                        : "its stamp lies before that of the last one; look at its publisher's clock");
}

std::string wordsOf(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c >= '+' && c <= '9'; }),
             text.end());
  return text;
}

}  // namespace

CompensationNode::CompensationNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine)
    : node_(node),
      machine_(machine),
      prefix_(textParameter(own, "frame_prefix", "")),
      watch_(CalibrationStore(storeFolder(own, machine)), machine, machineSpace(),
             numberParameter(own, "margin", 0.1, 0.0, 10.0)),
      inputs_(machine, settingsFrom(own)),
      homing_(machine.joints().size()),
      updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(own, {"store", "margin", "frame_prefix", "joint_timeout", "sensor_timeout",
                                "travel_deadband", "travel_deadband_rotary"});
  framesOut_ = node.advertise<tf2_msgs::TFMessage>("/tf", 5000);
  contactsOut_ = node.advertise<measuring_machine::CorrectedContact>("probe/contact_corrected", 1000);
  statusOut_ = own.advertise<measuring_machine::CompensationStatus>("status", 100, true);
  if (const auto pair = watch_.refresh()) install(pair);
  updater_.setHardwareID("compensation");
  updater_.add("correction", this, &CompensationNode::diagnose);

  ros::NodeHandle slowNode(node), slowOwn(own);
  slowNode.setCallbackQueue(&slow_);
  slowOwn.setCallbackQueue(&slow_);
  correctTarget_ = slowOwn.advertiseService("correct_target", &CompensationNode::correctTarget, this);
  correctTargetShort_ = slowNode.advertiseService("correct_target", &CompensationNode::correctTarget, this);
  timer_ = slowNode.createWallTimer(ros::WallDuration(0.05), &CompensationNode::look, this);
  spinner_ = std::make_unique<ros::AsyncSpinner>(1, &slow_);

  const ros::TransportHints fast = ros::TransportHints().tcpNoDelay();
  contactsIn_ = node.subscribe("probe/contact", 1000, &CompensationNode::takeContact, this, fast);
  axesIn_ = node.subscribe<measuring_machine::AxisStatus>(
      "axis_driver/status", 10, [this](const measuring_machine::AxisStatusConstPtr& message) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!message->name.empty()) axes_[message->name.front()] = *message;
        takeStatus(*message);
      });
  artifactIn_ = node.subscribe<measuring_machine::Artifact>(
      "artifact", 10, [this](const measuring_machine::ArtifactConstPtr& message) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (homing_.zero() == 0)
          inputs_.setTimeZero(nanoseconds(message->header.stamp));  // a session replayed
      });
  jointsIn_ = node.subscribe("joint_states", 5000, &CompensationNode::takeJoints, this, fast);
  spinner_->start();
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
            if (sensorOf(topicOf(name), m->header.frame_id) != name) return;  // another one on the same topic
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

void CompensationNode::withhold(const std::string& reason) {
  active_.reason = reason;
  ++status_.withheld;
  withheldSince_ = reason;
}

/// A homing gives the readings another zero, and another driver does not know how the last one moved.
void CompensationNode::takeHoming(const sensor_msgs::JointState& message) {
  const Homing homing = homingOf(message);
  if (!homing.told) return;
  bool changed = false;
  for (const std::string& name : message.name) {
    const int joint = machine_.findJoint(name);
    if (joint < 0) continue;
    if (!homing_.take(joint, {homing.homed, nanoseconds(homing.at)})) continue;
    inputs_.forgetTravel(joint);
    changed = true;
  }
  if (!changed) return;
  inputs_.setTimeZero(homing_.zero());
  for (const auto& [driver, status] : axes_) takeStatus(status);  // it may have come before
}

void CompensationNode::takeStatus(const measuring_machine::AxisStatus& message) {
  if (message.header.stamp.isZero()) return;  // none was heard yet
  const std::int64_t at = nanoseconds(message.homed_at);
  for (std::size_t i = 0; i < message.name.size(); ++i) {
    const int joint = machine_.findJoint(message.name[i]);
    if (joint < 0) continue;
    homing_.takeStatus(joint, {message.homed != 0, at});
    if (message.homed && homing_.isOf(joint, at) && i < message.travel.size())
      inputs_.takeTravel({message.name[i]}, {message.travel[i]});
  }
  inputs_.setTimeZero(homing_.zero());
}

void CompensationNode::takeJoints(const sensor_msgs::JointStateConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!inputs_.concerns(message->name)) return;  // a gripper's
  heard_ = ros::WallTime::now();
  takeHoming(*message);
  std::string reason;
  const bool ready = inputs_.takeJoints(nanoseconds(message->header.stamp), message->name, message->position,
                                        message->velocity, reason);
  if (ready && homing_.anyNotHomed()) reason = kUnhomed;
  if (!reason.empty() || !ready) {
    if (!reason.empty()) {
      withhold(reason);
      candidate_.reason = reason;
    }
    return;
  }
  frames_.transforms.clear();
  if (active_.loaded) addFrame(active_, message->header.stamp, "probe_tip_corrected", true);
  if (candidate_.loaded) addFrame(candidate_, message->header.stamp, "probe_tip_candidate", false);
  if (!frames_.transforms.empty()) framesOut_.publish(frames_);
}

void CompensationNode::addFrame(Applied& applied, const ros::Time& stamp, const std::string& child,
                                bool isActive) {
  inputs_.fill(applied.view, applied.state);
  if (applied.loaded->frames.model().domain().laser)
    applied.state.laserReading = 0.0;  // the tip, not the spot
  applied.loaded->frames.model().place(applied.state);
  const bool laser = applied.loaded->frames.model().domain().laser;
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
      withhold(c.reason);
    else
      applied.reason = c.reason;
    return;
  }
  applied.reason.clear();
  if (isActive) ++status_.frames;
  frames_.transforms.push_back(toTransform(c.corrected, stamp, prefix_ + "workpiece", prefix_ + child));
}

void CompensationNode::takeContact(const measuring_machine::ProbeContactConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!active_.loaded) return;
  try {
    if (homing_.anyNotHomed()) throw InputError(kUnhomed);
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
    if (!c.valid) throw InputError("contact on '" + message->feature + "' is not corrected: " + c.reason);
    contactsOut_.publish(toContactMessage(*message, c, active_.loaded->calibration));
  } catch (const std::exception& e) {
    withheldSince_ = e.what();
    ROS_WARN_THROTTLE(10.0, "%s", e.what());
  }
}

bool CompensationNode::isSilent() const {
  return heard_.isZero() || ros::WallTime::now() - heard_ > ros::WallDuration(kSilent);
}

measuring_machine::CompensationStatus CompensationNode::statusNow() {
  const std::lock_guard<std::mutex> lock(mutex_);
  measuring_machine::CompensationStatus status = status_;
  const bool silent = isSilent();
  status.calibration_id = active_.loaded ? active_.loaded->id : "";
  status.candidate_id = candidate_.loaded ? candidate_.loaded->id : "";
  const auto add = [](std::string& message, const std::string& more) {
    if (!more.empty()) message += (message.empty() ? "" : "; ") + more;
  };
  if (silent)
    add(status.message, "no joint states are arriving; is the axis driver running?");
  else if (!active_.loaded && pair_->warning.empty())
    add(status.message, "no calibration is active; calibrate and promote one");
  else if (!active_.reason.empty())
    add(status.message, "nothing is published: " + active_.reason);
  else if (!withheldSince_.empty())
    add(status.message, "frames or contacts were withheld: " + withheldSince_);
  add(status.message, pair_->warning);
  add(status.message, active_.note);
  status.publishing = !silent && active_.loaded && inputs_.complete() && active_.reason.empty();
  add(status.candidate_message, candidate_.reason);
  add(status.candidate_message, pair_->candidateWarning);
  if (status.publishing) {
    MovingState state = active_.state;
    const Correction now = active_.loaded->contacts.apply(state);
    status.sigma = now.sigma;
    if (now.pastUnknown)
      add(status.message,
          "the temperatures were not heard for long enough to know what lags behind them; sigma says by how "
          "much");
  }
  withheldSince_.clear();
  return status;
}

void CompensationNode::look(const ros::WallTimerEvent&) {
  if (const auto pair = watch_.refresh()) install(pair);
  measuring_machine::CompensationStatus status = statusNow();
  const ros::WallTime now = ros::WallTime::now();
  // The words without their numbers: a value that moves on is no news.
  const std::string words = wordsOf(status.calibration_id) + "|" + wordsOf(status.candidate_id) + "|" +
                            wordsOf(status.message) + "|" + wordsOf(status.candidate_message);
  const bool ids =
      status.calibration_id == shown_.calibration_id && status.candidate_id == shown_.candidate_id;
  const bool same = words == words_ && ids && status.publishing == shown_.publishing;
  if (same && now < nextStatus_) return;
  if (words != words_ && !status.message.empty() && !status.publishing)
    ROS_WARN("%s", status.message.c_str());
  words_ = words;
  nextStatus_ = now + ros::WallDuration(1.0);
  status.header.stamp = ros::Time::now();
  shown_ = status;
  statusOut_.publish(status);
  updater_.force_update();
}

bool CompensationNode::correctTarget(measuring_machine::CorrectTarget::Request& request,
                                     measuring_machine::CorrectTarget::Response& response) {
  answer(response, [&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!active_.loaded) throw InputError("no calibration is active; calibrate and promote one");
    if (homing_.anyNotHomed() && request.name.empty()) throw InputError(kUnhomed);
    MovingState state = active_.state;
    std::vector<double> arrival(machine_.joints().size(), 0.0);
    const std::size_t named = request.name.empty() ? arrival.size() : request.name.size();
    if (!request.travel.empty() && request.travel.size() != named)
      throw InputError("field 'travel' has " + std::to_string(request.travel.size()) + " directions for " +
                       std::to_string(named) + " joints");
    for (std::size_t i = 0; i < request.travel.size(); ++i) {
      const int joint = request.name.empty() ? static_cast<int>(i) : machine_.findJoint(request.name[i]);
      if (joint >= 0) arrival[joint] = request.travel[i] > 0 ? 1.0 : (request.travel[i] < 0 ? -1.0 : 0.0);
    }
    if (request.name.empty()) {
      if (isSilent())
        throw InputError(
            "no joint states are arriving, so the present readings are not known; name joints and positions "
            "to "
            "start from");
      if (!inputs_.complete())
        throw InputError("the present readings are not known; name joints and positions to start from");
      inputs_.fill(active_.view, state);
    } else {
      measuring_machine::ProbeContact start;  // for its order of the joints and its messages
      start.name = request.name;
      start.position = request.position;
      const std::vector<double> position = fromMessage(start, machine_).position;
      inputs_.fill(active_.view, state);
      state.position = position;
      std::fill(state.travel.begin(), state.travel.end(), 0.0);
      state.sinceReversal.clear();
    }
    std::fill(state.velocity.begin(), state.velocity.end(), 0.0);
    const Eigen::Vector3d target(request.target.x, request.target.y, request.target.z);
    const TargetReadings found = active_.loaded->contacts.correctTarget(target, state, arrival);
    response.calibration_id = active_.loaded->id;
    for (const Joint& joint : machine_.joints()) response.name.push_back(joint.name);
    response.position = found.position;
    response.sigma = found.sigma;
    if (!found.reached) throw InputError("target not reached: " + found.reason);
    response.message = found.correction.note;
  });
  return true;
}

void CompensationNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const int level = !shown_.publishing
                        ? DiagnosticStatus::ERROR
                        : (shown_.message.empty() ? DiagnosticStatus::OK : DiagnosticStatus::WARN);
  status.summary(level, shown_.message.empty() ? "correcting" : shown_.message);
  status.add("calibration", shown_.calibration_id);
  status.add("candidate", shown_.candidate_id);
  status.add("frames", shown_.frames);
  status.add("withheld", shown_.withheld);
  status.add("sigma_um", shown_.sigma * 1e6);
}

}  // namespace mm
