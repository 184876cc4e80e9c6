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
  ros::Time at;        // of the homing; zero: not homed
};

/// Readings and velocities in m, rad and s, stamped `stamp`. `header.frame_id` tells the homing: "homed at
/// 1795316193.267980268" or "not homed". @param homedAt stamp of the homing; zero: not homed.
sensor_msgs::JointState toJointState(const std::vector<std::string>& axes, const AxesState& state,
                                     const ros::Time& stamp, const ros::Time& homedAt);
Homing homingOf(const sensor_msgs::JointState& message);

/// What the controller latched at an edge of the probe, m and rad.
measuring_machine::ProbeLatch toLatchMessage(const ProbeEdge& edge, const std::vector<std::string>& axes,
                                             const ros::Time& stamp, const std::string& feature);
/// `time` is the stamp in s: differences of such times are good to a microsecond.
ProbeEdge fromMessage(const measuring_machine::ProbeLatch& message);

/// How far latches of several controllers may be apart, by what the joints move in the time between them.
struct LatchTolerance {
  double linear = 0.1e-6;  // m
  double rotary = 1e-6;    // rad
};
/// s before and behind a trip, beside its uncertainty, over which a joint must have rested to be known
/// without a latch of its own.
inline constexpr double kRestAround = 0.05;
/// When a joint that nobody latched must have rested: around the trip, uncertainty and margin included.
ros::Time restFrom(const measuring_machine::ProbeLatch& latch);
ros::Time restTo(const measuring_machine::ProbeLatch& latch);

/// The latch of one controller with the joints of the others: each as another latched it at the same trip, of
/// several latches the one nearest in time, or, where none did, as its joint states say if it rested; the
/// time uncertainty is then that of those states. @throw InputError naming the joint that moved by more than
/// the tolerance between the latches, their uncertainties included: the latches are not synchronised; or that
/// was not latched, and why it cannot be said that it rested.
measuring_machine::ProbeLatch joinLatches(const measuring_machine::ProbeLatch& first,
                                          const std::vector<measuring_machine::ProbeLatch>& others,
                                          const RestingJoints& resting, const Machine& machine,
                                          const LatchTolerance& tolerance);

/// The contact that a latched edge is. @param machine gives the direction of the approach: that of the tip's
/// motion by the latched velocities, or along the beam for a laser; zero at standstill.
/// @throw InputError when a joint of the machine is missing in the message.
measuring_machine::ProbeContact toContactMessage(const measuring_machine::ProbeLatch& latch,
                                                 const Machine& machine);

}  // namespace mm
