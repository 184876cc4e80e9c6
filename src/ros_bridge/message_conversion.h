#pragma once
#include <measuring_machine/Artifact.h>
#include <measuring_machine/Covariate.h>
#include <measuring_machine/ProbeContact.h>
#include <measuring_machine/ReferenceMeasurement.h>
#include <ros/time.h>
#include <sensor_msgs/Temperature.h>
#include <std_msgs/String.h>

#include <cstdint>
#include <string>

#include "session/session.h"

namespace mm {

// Between the messages of the package and the structures of the session. Both sides are SI; nothing is
// rounded.
// @throw InputError: the text says what is wrong with the message; the caller adds where it came from.

/// The end of a topic's name for a sensor or covariate: what a graph name must not have ("motor left") is
/// `_`.
std::string topicOf(const std::string& name);
/// The sensor of a temperature: the topic's end; of a name that a topic cannot hold, what an import wrote
/// into `frame_id`.
std::string sensorOf(const std::string& topicEnd, const std::string& frameId);

/// A text as the message of a topic.
std_msgs::String toText(std::string text);
/// What else is to be said, behind a semicolon; nothing where that is empty.
void addWords(std::string& text, const std::string& more);

/// Of a stamp, since the epoch.
std::int64_t nanoseconds(const ros::Time& stamp);
/// @throw InputError for a stamp that a ROS time cannot hold.
ros::Time rosTime(std::int64_t nanoseconds);

/// Lengths in m both ways. @throw InputError naming the field that is not a number, out of range or doubled.
measuring_machine::Artifact toMessage(const Artifact& artifact);
Artifact fromMessage(const measuring_machine::Artifact& message);

/// @param session says what its feature, placement and stylus are called.
measuring_machine::ProbeContact toContactMessage(const Observation& contact, const Session& session);
/// `time`, `row`, `travel` and the index of the feature are the caller's.
Observation fromMessage(const measuring_machine::ProbeContact& message, const Machine& machine);

/// A deviation or a position of an independent instrument, m and rad.
measuring_machine::ReferenceMeasurement toReferenceMessage(const Observation& reference,
                                                           const Session& session);
/// `time`, `row`, `travel` and the index of the setup are the caller's.
Observation fromMessage(const measuring_machine::ReferenceMeasurement& message, const Machine& machine);

}  // namespace mm
