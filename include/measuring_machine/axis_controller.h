#pragma once
// What a package of your own needs to bring a motion controller into measuring_machine: this header, nothing
// to link. Only the standard library is in it, so that a plugin does not depend on how measuring_machine was
// built. A worked example is in examples/own_controller.
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace mm {

/// Changes whenever something below does: a plugin that was built with another header is refused, by name.
constexpr int kControllerInterface = 2;

/// A motion that was started: ascending within the driver's life, from 1. 0: none.
using MotionId = std::uint64_t;

/// How a motion ended.
enum class Outcome : std::uint8_t {
  kUnderWay,  // it has not ended
  kReached,   // all axes rest at the target, within tolerance
  kTripped,   // the probe tripped: what a probing motion is for, and what ends any other
  kHeld,      // in feed hold, and not resumed in time
  kLimit,     // a limit switch, or a soft limit of the controller
  kAlarm,     // the controller refuses to go on until it is cleared, or rests elsewhere than it should
  kStopped,   // asked to: stop, emergency stop, cancel
  kLost,      // the controller does not answer, or what it answers cannot be true
};

/// What keeps a controller from moving, by its own code. Code 0 with an empty text: nothing.
struct Alarm {
  int code = 0;
  std::string text;    // what happened, for people
  std::string remedy;  // what to do, for people
  bool present() const { return code != 0 || !text.empty(); }
};

/// One joint that a controller may move: of the machine's URDF. SI: m and rad.
struct ControllerAxis {
  std::string name;
  bool rotary = false;
  double lower = 0.0, upper = 0.0;  // limits of motion; equal: none
  double maxVelocity = 0.0;         // per s; 0: not stated
};

/// The machine of which a controller moves all joints or some.
struct ControllerSetup {
  std::string machine, urdf;         // name, and text of the URDF
  std::vector<ControllerAxis> axes;  // all joints, from workpiece to probe_tip
  std::map<std::string, std::string> parameters;
};

/// What one axis can do; NaN: the controller does not say. SI: m and rad.
struct AxisCapability {
  double lower = std::numeric_limits<double>::quiet_NaN();  // soft limits of the controller
  double upper = std::numeric_limits<double>::quiet_NaN();
  double maxVelocity = std::numeric_limits<double>::quiet_NaN();
  double acceleration = std::numeric_limits<double>::quiet_NaN();
  double resolution = 0.0;  // of a reading; 0: finer than any tolerance
};

/// What a controller can do; asked once it is connected.
struct Capabilities {
  bool feedHold = false, feedOverride = false;  // `feedHold`, `setOverride` act
  bool homingByAxis = false;                    // `home` takes some of the axes; else always all
  bool moveOffLimit = false;                    // `moveOffLimit` acts
  bool guardsPositioning = false;               // stops by itself when the probe trips outside of probing
  bool positionSurvivesReset = false;           // after a reset or a loss of connection homing still holds
  std::vector<AxisCapability> axes;             // one an axis
  std::vector<std::string> notes;               // what a user should know of this one; for diagnostics
};

/// What a controller says of its axes at one moment. SI units, one value an axis.
struct AxesState {
  double time = 0.0;             // s on the controller's own clock, ascending
  double timeUncertainty = 0.0;  // s: how well `time` is that of the readings
  std::vector<double> position, velocity;
  bool actual = false;           // readings of encoders; false: what was commanded
  std::vector<int> limitSwitch;  // -1 or +1: the switch at that end is closed; 0: neither; empty: not known
  bool homed = false;            // every axis
  std::vector<bool> axisHomed;   // of each; empty: as `homed`
  bool moving = false;
  bool held = false;  // in feed hold
  bool emergencyStop = false;
  bool probeClosed = false;
  double feedOverride = 1.0;            // share of the commanded speeds
  std::uint32_t resets = 0;             // of the controller, seen since it was opened
  MotionId motion = 0;                  // the last one that was started
  Outcome outcome = Outcome::kReached;  // of that motion, as the controller knows it
  std::string note;                     // why it ended so, for people; may be empty
  Alarm alarm;
};

/// A straight motion: all axes start and arrive together.
struct AxesMotion {
  MotionId id = 0;
  std::vector<double> target;  // m or rad
  std::vector<double> speed;   // m/s or rad/s of each axis on the way; 0 for one that stays
  bool probing = false;        // latches at the trip of the probe and stops there
  bool leaving = false;        // the probe is closed at the start: it must open, and its trips do not count
};

/// The probe's switch opened or closed, or the laser was read, with what the controller latched.
struct ProbeEdge {
  double time = 0.0;             // s on the clock of `AxesState::time`
  double timeUncertainty = 0.0;  // s: between the edge and what was latched
  bool closed = true;
  bool probing = false;                    // during a probing motion
  bool actual = false;                     // readings of encoders were latched; false: commanded positions
  MotionId motion = 0;                     // during which it was
  std::vector<double> position, velocity;  // latched; empty: the controller did not latch
  double laserReading = std::numeric_limits<double>::quiet_NaN();  // m
};

/// One motion controller with one or more axes and the input of a probe: simulated, on a serial line, or at
/// a network address. What it says is checked by the driver, and never trusted to be finite, ascending or
/// possible. Calls that start something return at once; from then on `AxesState::moving` is true until it has
/// ended, and what came of it is in a later `poll`.
/// @throw std::exception from any call, with one line for people; from `poll` when the connection is lost.
class AxisController {
 public:
  using Parameters = std::map<std::string, std::string>;

  virtual ~AxisController() = default;
  /// As the plugin was compiled.
  virtual int interface() const { return kControllerInterface; }

  // From one thread at a time. --------------------------------------------------------------------------

  /// Connects. @throw naming the parameter that is missing, unknown or wrong.
  virtual void open(const ControllerSetup& setup) = 0;
  /// Once more after a loss; what was moving is stopped. @throw while it is still away.
  virtual void reconnect() = 0;
  /// Leaves the controller at rest; a later call may be `reconnect` or nothing.
  virtual void close() {}
  /// Names of the joints that this controller moves, in the order of every vector here.
  virtual const std::vector<std::string>& axes() const = 0;
  virtual Capabilities capabilities() const { return {}; }
  /// The newest state. @param elapsed s since the last call: a simulated controller lets that much pass; one
  /// of hardware reads what has arrived and never waits longer.
  virtual AxesState poll(double elapsed) = 0;

  /// Starts looking for the reference marks of these axes (indices). @throw when it cannot.
  virtual void home(const std::vector<std::size_t>& axes) = 0;
  /// Starts a motion; one that runs is replaced. @throw before homing, in emergency stop, in an alarm.
  virtual void move(const AxesMotion& motion) = 0;
  /// Leaves the alarm where that is possible; which axes are still homed is in the next state.
  virtual void clearAlarm() = 0;
  /// Moves axes that stand on their limit switch back into the range, slowly.
  virtual void moveOffLimit() {}
  /// Power on again after an emergency stop; the machine must then be homed.
  virtual void resetEmergencyStop() = 0;

  /// Edges since the last call, oldest first.
  virtual std::vector<ProbeEdge> takeProbeEdges() = 0;
  /// Reads the laser where it stands. @return nothing out of range, or when there is no laser.
  virtual std::optional<ProbeEdge> readLaser() { return std::nullopt; }
  /// Sensors at the controller: name and degC; NaN: the sensor does not answer.
  virtual std::vector<std::pair<std::string, double>> temperatures() { return {}; }
  /// Where the tip truly is, in workpiece (m): only a simulation knows.
  virtual std::optional<std::array<double, 3>> trueTip() const { return std::nullopt; }
  /// Breaks the device on purpose, where that is possible: ok, off, stuck, garbage, wrong, slow,
  /// intermittent.
  /// @throw where it is not.
  virtual void breakDevice(const std::string& fault) {
    throw std::runtime_error("this controller cannot be broken on purpose ('" + fault + "')");
  }

  // From any thread, at any time, also while another call has not returned. They never wait for another
  // call, nor for the device, and return within 10 ms. ---------------------------------------------------

  /// Brings everything to rest, with its deceleration; the motion under way ends as stopped.
  virtual void stop() = 0;
  /// Power off, or the nearest to it, now. Ends only by `resetEmergencyStop`.
  virtual void emergencyStop() = 0;
  /// Comes to rest on the way (true), goes on (false).
  virtual void feedHold(bool hold) { (void)hold; }
  /// Share of the commanded speeds, above 0 up to 1: no motion becomes faster than it was checked for.
  virtual void setOverride(double share) { (void)share; }
};

}  // namespace mm
