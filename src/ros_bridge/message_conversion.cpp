#include "ros_bridge/message_conversion.h"

#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/names_of.h"
#include "base/nearest_name.h"

namespace mm {
namespace {

constexpr std::int64_t kSecond = 1000000000;

/// Which entry of a message's arrays belongs to each joint of the machine.
std::vector<int> jointOrder(const std::vector<std::string>& names, const Machine& machine) {
  std::vector<int> order(machine.joints().size(), -1);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int joint = machine.findJoint(names[i]);
    if (joint < 0)
      throw InputError("joint '" + names[i] + "' is not a joint of machine '" + machine.name() + "'" +
                       didYouMean(names[i], allNames(machine.joints())));
    if (order[joint] >= 0) throw InputError("joint '" + names[i] + "' is given twice");
    order[joint] = static_cast<int>(i);
  }
  for (std::size_t j = 0; j < order.size(); ++j)
    if (order[j] < 0) throw InputError("no reading of joint '" + machine.joints()[j].name + "'");
  return order;
}

/// @param values empty: none of them was measured, where `optional`.
std::vector<double> inMachineOrder(const std::vector<double>& values, const std::vector<int>& order,
                                   const char* field, bool optional) {
  std::vector<double> sorted(order.size(), kNotMeasured);
  if (values.empty() && optional) return sorted;
  if (values.size() != order.size())
    throw InputError(std::string("field '") + field + "' has " + std::to_string(values.size()) +
                     " values for " + std::to_string(order.size()) + " joints");
  for (std::size_t j = 0; j < order.size(); ++j) sorted[j] = values[order[j]];
  return sorted;
}

/// Leaves an array that says nothing empty, as the messages describe it.
std::vector<double> unlessAllNaN(const std::vector<double>& values) {
  const bool none = std::all_of(values.begin(), values.end(), [](double v) { return std::isnan(v); });
  return none ? std::vector<double>() : values;
}

/// What every measurement says: of which joints, with which tip, where, and what it met.
template <typename Message>
Message measuredMessage(const Observation& o, const Session& session) {
  Message message;
  message.header.frame_id = "workpiece";
  message.name = allNames(session.machine.joints());
  message.laser_reading = o.laserReading;
  if (o.feature >= 0) message.feature = session.artifact.features.at(o.feature).name;
  if (!session.placements.empty()) message.placement = session.placements.at(o.placement);
  if (!session.artifact.styli.empty()) message.stylus = session.artifact.styli.at(o.stylus).name;
  return message;
}

}  // namespace

std::string topicOf(const std::string& name) {
  std::string topic = name;
  for (char& c : topic)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '/') c = '_';
  return topic;
}

std::string sensorOf(const std::string& topicEnd, const std::string& frameId) {
  return !frameId.empty() && frameId != topicEnd && topicOf(frameId) == topicEnd ? frameId : topicEnd;
}

std_msgs::String toText(std::string text) {
  std_msgs::String message;
  message.data = std::move(text);
  return message;
}

void addWords(std::string& text, const std::string& more) {
  if (!more.empty()) text += (text.empty() ? "" : "; ") + more;
}

std::int64_t nanoseconds(const ros::Time& stamp) { return static_cast<std::int64_t>(stamp.toNSec()); }

ros::Time rosTime(std::int64_t nanoseconds) {
  if (nanoseconds <= 0 || nanoseconds / kSecond > 4294967295LL)
    throw InputError("a ROS stamp cannot hold " + std::to_string(nanoseconds) + " ns");
  return ros::Time(static_cast<std::uint32_t>(nanoseconds / kSecond),
                   static_cast<std::uint32_t>(nanoseconds % kSecond));
}

measuring_machine::Artifact toMessage(const Artifact& artifact) {
  measuring_machine::Artifact message;
  message.header.frame_id = artifact.poseKnown ? "workpiece" : "artifact";
  message.name = artifact.name;
  message.pose_known = artifact.poseKnown;
  message.tip_radius = artifact.tipRadius;
  message.repeatability = artifact.repeatability;
  message.expansion = artifact.expansion;
  message.temperature_sensor = artifact.temperatureSensor;
  message.serial = artifact.serial;
  for (const Stylus& s : artifact.styli) {
    measuring_machine::Stylus stylus;
    stylus.name = s.name;
    stylus.tip_radius = s.tipRadius;
    tf2::toMsg(s.offset, stylus.offset);
    stylus.offset_known = s.known;
    message.styli.push_back(stylus);
  }
  for (const Feature& f : artifact.features) {
    measuring_machine::ArtifactFeature feature;
    feature.kind = f.kind == FeatureKind::kBall ? feature.BALL : feature.POINT;
    feature.name = f.name;
    feature.position = tf2::toMsg(f.position);
    feature.position_known = f.known;
    feature.position_std = f.positionStd;
    feature.radius = f.radius;
    feature.radius_std = f.radiusStd;
    message.features.push_back(feature);
  }
  return message;
}

Artifact fromMessage(const measuring_machine::Artifact& message) {
  Artifact artifact;
  artifact.name = message.name;
  artifact.poseKnown = message.pose_known != 0;
  artifact.tipRadius = message.tip_radius;
  artifact.repeatability = message.repeatability;
  artifact.expansion = message.expansion;
  artifact.temperatureSensor = message.temperature_sensor;
  artifact.serial = message.serial;
  for (const auto& s : message.styli) {
    Stylus stylus;
    stylus.name = s.name;
    stylus.tipRadius = s.tip_radius;
    tf2::fromMsg(s.offset, stylus.offset);
    stylus.known = s.offset_known != 0;
    if (s.name.empty()) throw InputError("a stylus has no name");
    if (artifact.findStylus(s.name) >= 0) throw InputError("two styli are called '" + s.name + "'");
    if (!(s.tip_radius >= 0.0 && std::isfinite(s.tip_radius)))
      throw InputError("stylus '" + s.name + "': 'tip_radius' must be a number, at least 0");
    if (stylus.offset.array().isInf().any() || (stylus.known && stylus.offset.hasNaN()))
      throw InputError("stylus '" + s.name + "': 'offset' is not a number");
    artifact.styli.push_back(std::move(stylus));
  }
  if (!(artifact.tipRadius >= 0.0) || std::isinf(artifact.tipRadius))
    throw InputError("field 'tip_radius' must be a number, at least 0");
  if (artifact.repeatability <= 0.0) throw InputError("field 'repeatability' must be above 0, or NaN");
  if (!std::isfinite(artifact.expansion)) throw InputError("field 'expansion' is not a number");
  for (const auto& f : message.features) {
    Feature feature;
    feature.kind = f.kind == f.BALL ? FeatureKind::kBall : FeatureKind::kPoint;
    feature.name = f.name;
    tf2::fromMsg(f.position, feature.position);
    feature.known = f.position_known != 0;
    feature.positionStd = f.position_std;
    feature.radius = f.radius;
    feature.radiusStd = f.radius_std;
    const std::string who = "feature '" + f.name + "'";
    if (f.name.empty()) throw InputError("a feature has no name");
    if (artifact.findFeature(f.name) >= 0) throw InputError("two features are called '" + f.name + "'");
    if (f.kind > f.POINT) throw InputError(who + ": 'kind' must be BALL or POINT");
    if (feature.kind == FeatureKind::kBall && !(f.radius > 0.0 && std::isfinite(f.radius)))
      throw InputError(who + ": 'radius' must be above 0");
    if (!(f.position_std >= 0.0) || !(f.radius_std >= 0.0))
      throw InputError(who + ": a standard deviation must be at least 0");
    if (feature.known && !feature.position.allFinite())
      throw InputError(who + ": 'position' is not a number");
    artifact.features.push_back(std::move(feature));
  }
  return artifact;
}

measuring_machine::ProbeContact toContactMessage(const Observation& contact, const Session& session) {
  auto message = measuredMessage<measuring_machine::ProbeContact>(contact, session);
  message.position = contact.position;
  message.velocity = unlessAllNaN(contact.velocity);
  if (!contact.approach.hasNaN()) tf2::toMsg(contact.approach, message.approach);
  return message;
}

Observation fromMessage(const measuring_machine::ProbeContact& message, const Machine& machine) {
  Observation contact;
  contact.kind = ObservationKind::kContact;
  const std::vector<int> order = jointOrder(message.name, machine);
  contact.position = inMachineOrder(message.position, order, "position", false);
  contact.velocity = inMachineOrder(message.velocity, order, "velocity", true);
  Eigen::Vector3d approach;
  tf2::fromMsg(message.approach, approach);
  if (!approach.hasNaN() && !approach.isZero(0.0)) {
    constexpr double kUnitLength = 1e-3;  // what is written with three digits is a unit vector
    if (std::abs(approach.norm() - 1.0) > kUnitLength)
      throw InputError("field 'approach' must be a unit vector, or zero");
    contact.approach = approach;
  }
  contact.laserReading = message.laser_reading;
  return contact;
}

measuring_machine::ReferenceMeasurement toReferenceMessage(const Observation& reference,
                                                           const Session& session) {
  auto message = measuredMessage<measuring_machine::ReferenceMeasurement>(reference, session);
  message.joint_position = reference.position;
  message.joint_velocity = unlessAllNaN(reference.velocity);
  for (int k = 0; k < 3; ++k) message.position[k] = reference.reference[k];
  message.deviation = unlessAllNaN(reference.deviation);
  message.deviation_std = unlessAllNaN(reference.deviationStd);
  message.length = reference.length;
  if (reference.setup >= 0) message.setup = session.setups.at(reference.setup);
  return message;
}

Observation fromMessage(const measuring_machine::ReferenceMeasurement& message, const Machine& machine) {
  Observation o;
  const std::vector<int> order = jointOrder(message.name, machine);
  o.position = inMachineOrder(message.joint_position, order, "joint_position", false);
  o.velocity = inMachineOrder(message.joint_velocity, order, "joint_velocity", true);
  o.laserReading = message.laser_reading;
  o.reference = {message.position[0], message.position[1], message.position[2]};
  const std::vector<double> deviation = inMachineOrder(message.deviation, order, "deviation", true);
  const bool anyPosition = !o.reference.array().isNaN().all();
  const bool anyDeviation = !unlessAllNaN(deviation).empty();
  const bool anyLength = !message.feature.empty();
  if (anyPosition + anyDeviation + anyLength > 1)
    throw InputError("more than one of position, deviation and length; send each as a separate message");
  if (anyPosition + anyDeviation + anyLength == 0)
    throw InputError("neither a position nor a deviation nor a length was measured");
  o.kind = anyDeviation ? ObservationKind::kDeviation
           : anyLength  ? ObservationKind::kLength
                        : ObservationKind::kPosition;
  if (anyLength) o.length = message.length;
  if (!anyDeviation) return o;
  o.deviation = deviation;
  o.deviationStd = inMachineOrder(message.deviation_std, order, "deviation_std", true);
  return o;
}

}  // namespace mm
