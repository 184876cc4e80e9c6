#pragma once
#include <string>
#include <vector>

#include "machine/machine.h"
#include "measuring_machine/axis_controller.h"

namespace mm {

/// What a controller of this machine is opened with.
ControllerSetup controllerSetup(const Machine& machine, AxisController::Parameters parameters);

/// reached, tripped, held, limit, alarm, stopped, lost; "under way" before.
std::string outcomeName(Outcome outcome);

/// A straight motion in which no linear axis is faster than `linear` (m/s) and no rotary one than `rotary`
/// (rad/s), nor than its URDF allows. @param joints of the machine, one an axis. @throw InputError when a
/// speed that is needed is not above 0.
AxesMotion straightMotion(const std::vector<Joint>& joints, const std::vector<double>& from,
                          const std::vector<double>& to, double linear, double rotary);
/// The same in `seconds`. @throw InputError unless above 0.
AxesMotion timedMotion(const std::vector<double>& from, const std::vector<double>& to, double seconds);

/// @throw InputError naming the joint, the value and the limit when a target is beyond the limits of the
/// URDF, is not a number, or has the wrong size.
void checkTarget(const std::vector<Joint>& joints, const std::vector<double>& target);
/// @throw InputError naming the joint, the value and the limit when a motion is faster than the URDF allows,
/// or a speed is not a number.
void checkSpeeds(const std::vector<Joint>& joints, const AxesMotion& motion);

}  // namespace mm
