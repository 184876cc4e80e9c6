#pragma once
#include <measuring_machine/ProbeContact.h>
#include <measuring_machine/ProbeLatch.h>
#include <sensor_msgs/JointState.h>

#include <string>
#include <vector>

#include "drivers/axis_controller.h"
#include "ros_bridge/resting_joints.h"

namespace mm {

// Between the messages of the nodes and the structures of the drivers. Both sides are SI.

/// What a joint state says of the homing of its axes: of that very moment and of that very driver, so that no
/// message of another topic, and of a driver that has ended, can say otherwise.
struct Homing {
  bool told = false;   // false: not by a driver of this package
  bool homed = false;  // the readings have a zero
  ros::Time at;        // of the homing; zero: it does not say
};

/// Readings and velocities in m, rad and s, stamped `stamp`. `header.frame_id` is the frame that they count
/// in: the workpiece's, or `unhomed`, which no tree has. @param prefix of the frames' names.
sensor_msgs::JointState toJointState(const std::vector<std::string>& axes, const AxesState& state,
                                     const ros::Time& stamp, const std::string& prefix);
/// Also of recordings in which the frame says "homed at 1795316193.267980268" or "not homed".
Homing homingOf(const sensor_msgs::JointState& message);

/// What a probing move means to touch, and where.
struct Meant {
  std::string feature, placement, stylus;
};
/// @param goal a MoveGoal.
template <typename Goal>
Meant meantBy(const Goal& goal) {
  return {goal.feature, goal.placement, goal.stylus};
}

/// What the controller latched at a trip of the probe, or as the laser was read, m and rad.
measuring_machine::ProbeLatch toLatchMessage(const ProbeEdge& trip, const std::vector<std::string>& axes,
                                             const ros::Time& stamp, const Meant& meant);

/// How far latches of several controllers may be apart, by what the joints move in the time between them.
struct LatchTolerance {
  double linear = 0.1e-6;  // m
  double rotary = 1e-6;    // rad
};
/// The contact that a trip is, of all joints of the machine: each as its controller latched it; as another
/// one did at the same trip, of several latches the one nearest in time; or, where none did, as its joint
/// states say if it rested. The approach is the direction of the tip's motion by the latched velocities, or
/// that of the beam of a laser; zero at standstill, or where a velocity is not known.
/// @throw InputError when it was no probing move, no position was latched, or of a joint it is not known
/// where it was: naming it, by how much it moved between the latches (uncertainties included), or why it
/// cannot be said that it rested.
measuring_machine::ProbeContact contactOf(const measuring_machine::ProbeLatch& trip,
                                          const std::vector<measuring_machine::ProbeLatch>& others,
                                          const RestingJoints& resting, const Machine& machine,
                                          const LatchTolerance& tolerance);

}  // namespace mm
