#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// What a controller says of its axes at one moment. SI units, one value an axis.
struct AxesState {
  double time = 0.0;  // s on the controller's own clock, ascending
  std::vector<double> position, velocity;
  std::vector<int> limitSwitch;  // -1 or +1: the switch at that end is closed; 0: neither
  bool homed = false;
  bool moving = false;
  bool emergencyStop = false;
  bool probeClosed = false;
  std::string fault;  // why nothing moves, for people; empty: none
};

/// A straight motion: all axes start and arrive together.
struct AxesMotion {
  std::vector<double> target;  // m or rad
  std::vector<double> speed;   // m/s or rad/s of each axis on the way; 0 for one that stays
  bool probing = false;        // latches at the trip of the probe and stops there
};

/// The probe's switch opened or closed, or the laser was read, with what the controller latched.
struct ProbeEdge {
  double time = 0.0;  // s on the controller's clock
  bool closed = true;
  bool probing = false;                    // during a probing motion
  std::vector<double> position, velocity;  // latched; empty: the controller did not latch
  double laserReading = std::numeric_limits<double>::quiet_NaN();  // m
};

/// One motion controller with one or more axes and the input of a probe: simulated, on a serial line, or at
/// a network address. Called by one thread at a time. Calls that start something return at once; what came of
/// it is in the next `poll`. @throw Error from any call when the connection is lost.
class AxisController {
 public:
  using Parameters = std::map<std::string, std::string>;

  virtual ~AxisController() = default;

  /// Connects. @param machine whose joints these axes are; all of them, or some.
  /// @throw InputError naming the parameter that is missing, unknown or wrong.
  virtual void open(const Machine& machine, const Parameters& parameters) = 0;
  /// Names of the joints that this controller moves, in the order of every vector here.
  virtual const std::vector<std::string>& axes() const = 0;
  /// The newest state. @param elapsed s since the last call: a simulated controller lets that much pass; one
  /// of hardware reads what has arrived and never waits longer.
  virtual AxesState poll(double elapsed) = 0;

  /// Starts looking for the reference marks. @throw Error when it cannot (emergency stop, fault).
  virtual void home() = 0;
  /// Starts a motion; one that runs is replaced. @throw Error before homing, in emergency stop, in a fault.
  virtual void move(const AxesMotion& motion) = 0;
  /// Brings everything to rest, with its deceleration.
  virtual void stop() = 0;
  /// Power off now. Ends only by `resetEmergencyStop`, after which the machine must be homed again.
  virtual void emergencyStop() = 0;
  virtual void resetEmergencyStop() = 0;

  /// Edges since the last call, oldest first.
  virtual std::vector<ProbeEdge> takeProbeEdges() = 0;
  /// Reads the laser where it stands. @return nothing out of range, or when there is no laser.
  virtual std::optional<ProbeEdge> readLaser() { return std::nullopt; }
  /// Sensors at the controller: name and degC; NaN: the sensor does not answer.
  virtual std::vector<std::pair<std::string, double>> temperatures() { return {}; }
  /// Where the tip truly is, in workpiece (m): only a simulation knows.
  virtual std::optional<Eigen::Vector3d> trueTip() const { return std::nullopt; }
};

/// A straight motion in which no linear axis is faster than `linear` (m/s) and no rotary one than `rotary`
/// (rad/s). @param joints of the machine, one an axis. @throw InputError when a speed that is needed is not
/// above 0.
AxesMotion straightMotion(const std::vector<Joint>& joints, const std::vector<double>& from,
                          const std::vector<double>& to, double linear, double rotary);
/// The same in `seconds`. @throw InputError unless above 0.
AxesMotion timedMotion(const std::vector<double>& from, const std::vector<double>& to, double seconds);

/// @throw InputError naming the joint, the value and the limit when a target is beyond the limits of the
/// URDF, is not a number, or has the wrong size.
void checkTarget(const std::vector<Joint>& joints, const std::vector<double>& target);

}  // namespace mm
