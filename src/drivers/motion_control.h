#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "drivers/axis_controller.h"
#include "drivers/clock_map.h"
#include "drivers/motion_owner.h"
#include "drivers/probe_debounce.h"
#include "drivers/state_check.h"

namespace mm {

/// How the refusal of a probing motion begins whose probe is closed already.
inline constexpr const char* kProbeIsClosed = "the probe is closed before the probing move";

/// Stands between whoever wants a motion and the controller that makes it: checks what the controller says,
/// keeps every motion within the URDF, ends one that meets what it should not or that nobody answers for any
/// more (`MotionOwner`), and says how each ended. Stop and emergency stop have a way of their own to the
/// controller, past everything that may be waiting. No ROS. `cycle` is called by one thread; everything else
/// by any.
class MotionControl {
 public:
  struct Settings {
    double tolerance = 20e-6;       // m: an axis has arrived
    double rotaryTolerance = 1e-4;  // rad
    double silence = 0.5;           // s without a new state until the controller counts as lost
    double late = 0.25;             // s by which states may be late while something moves
    double restTimeout = 5.0;       // s within which the axes must rest after a stop
    double holdLimit = 600.0;       // s of feed hold until a motion is given up
    double escape = 2e-3;           // m from where the probe closed within which it must open again
    double rotaryEscape = 20e-3;    // rad: 2 mm at a lever of 100 mm
    double settle = 20e-3;          // s open until the probe is trusted again after that
    double reconnect = 1.0;         // s between attempts
    ProbeDebounce::Settings probe;  // of its switch
    unsigned silentMoves = 3;       // probing motions in a row without a trip until it is said
    bool simulatedTime = false;     // the controller makes the time: clocks are not compared
    std::vector<std::vector<std::string>> homingOrder;  // axes that are homed together, in order; empty: all
  };
  /// How a motion ended.
  struct Report {
    Outcome outcome = Outcome::kReached;
    std::string message;           // for people; empty: as it should
    std::vector<double> position;  // m or rad, after it
  };
  /// What is known now.
  struct View {
    AxesState state;    // the last one that could be true; `homed` is false after any reset
    std::string lost;   // why the controller is not to be trusted now; empty: it answers
    std::string fault;  // why nothing moves: lost, alarm or emergency stop; empty: it may
    bool homing = false, probing = false;
    std::uint32_t unsuccessful = 0;  // probing motions in a row without a trip
    std::uint32_t stops = 0;         // stops and emergency stops so far
    std::string stoppedBy;           // the last of them, for people
    double late = 0.0;               // s by which states arrive late
    std::string probe;               // what is wrong with the probe, for people; empty: nothing
    int bounces = 0, jolts = 0;      // of its switch: edges swallowed, closings that did not last
  };
  /// What a cycle found. `host` is the time (s) of the state on the host's clock.
  struct Observation {
    AxesState state;
    double host = 0.0;
    std::vector<ProbeEdge> edges, trips;  // of the probe's switch; closings that have settled
  };
  /// Told of the newest state while a motion is under way. @return false: cancel.
  using Watch = std::function<bool(const AxesState& state)>;

  /// @param controller opened. @throw InputError for axes that the machine does not have.
  MotionControl(std::shared_ptr<AxisController> controller, const Machine& machine, Settings settings);
  ~MotionControl();

  const std::vector<std::string>& axes() const { return axes_; }
  const std::vector<Joint>& joints() const { return joints_; }        ///< of the axes
  const Capabilities& capabilities() const { return capabilities_; }  ///< of the controller
  MotionOwner& owner() { return owner_; }                             ///< who may move

  /// Asks the controller once. @param elapsed s since the last call. @param host s on the host's clock now.
  /// @return nothing when there is no state, or none that can be true.
  std::optional<Observation> cycle(double elapsed, double host);
  /// This process paused for so long (s): what it measures of clocks does not hold, and a motion that nobody
  /// watched for longer than a controller may be silent is ended.
  void paused(double seconds);
  /// Nothing may move, and what moves is stopped, as long as there is a reason. @param why for people; empty:
  /// there is none any more.
  void forbid(const std::string& why);
  View view() const;

  /// Makes a motion and waits for its end. @param stopsSeen `stops()` when it was asked for: a stop since
  /// then ends it. @throw Error when it cannot begin, with why.
  Report move(AxesMotion motion, const Mover& mover, std::uint32_t stopsSeen, const Watch& watch = {});
  /// Homes axes by name in the order of the settings; none: all. Waits. @throw Error saying why not.
  void home(const std::vector<std::string>& names, const Mover& mover, const Watch& watch = {});
  /// Ends every motion and every ticket, and waits until the axes rest. @throw Error when that is not known.
  void stop(const std::string& who);
  /// Power off now; does not wait for anything. @return what could not be done, for people; empty: it was.
  std::string emergencyStop(const std::string& who);
  void resetEmergencyStop();  ///< @throw Error
  /// Feed hold, or its end. @throw Error when the controller cannot, or nothing moves.
  void hold(bool on);
  void setOverride(double share);              ///< above 0 up to 1 @throw InputError, Error
  void clearAlarm();                           ///< @throw Error
  void moveOffLimit(const Mover& mover);       ///< waits @throw Error
  void breakDevice(const std::string& fault);  ///< @throw Error
  std::optional<ProbeEdge> readLaser();        ///< @throw Error
  std::vector<std::pair<std::string, double>> temperatures();
  std::uint32_t stops() const { return stops_; }
  /// s on the host's clock of a time on the controller's.
  double toHost(double time) const;
  /// No motion begins any more; what moves is stopped. Waits until the axes rest, while `cycle` goes on.
  /// @return false: whether they rest is not known.
  bool shutDown(const std::string& who);
  /// Ends every wait with an error; before the last owner ends.
  void end();

 private:
  using Wall = std::chrono::steady_clock;
  struct Current {  // the motion under way
    AxesMotion motion;
    bool homing = false, armed = true;  // armed: a trip ends it
    std::vector<double> from;
    std::optional<double> openSince;  // s on the controller's clock, while it leaves a surface
    std::optional<Wall::time_point> heldSince;
    Outcome forced = Outcome::kUnderWay;  // why it was ended from here
    std::string why;
  };

  /// Frees the axes for the next who asks, however a motion ends.
  struct EndOfMotion {
    MotionControl& control;
    explicit EndOfMotion(MotionControl& c) : control(c) {}
    EndOfMotion(const EndOfMotion&) = delete;
    EndOfMotion& operator=(const EndOfMotion&) = delete;
    ~EndOfMotion();
  };

  void withDevice(const std::function<void()>& call) const;
  void owe(bool answer);                          // also while another call of the controller does not end
  double owing() const;                           // s that the controller has owed an answer; 0: it owes none
  static std::string shortSeconds(double value);  // for people, with its unit
  void loseDevice(const std::string& why);
  bool weigh(Observation& seen, double host);
  void takeReset();
  void endByReason(const Observation& seen);
  std::string pauseWords() const;
  std::string probeWords(const Observation& seen);
  std::string lateWords(const AxesState& state) const;
  bool awaitEnd(std::unique_lock<std::mutex>& lock, std::uint32_t stopsSeen, const Watch& watch);
  void lose(const std::string& why, bool zeroInDoubt);
  void regain();
  void take(const AxesState& state, double host);
  std::string stuckWords(const Current& current) const;
  void takeRest(const AxesState& state);
  void takeSurface(const AxesState& state);
  void forgetSurface();
  void force(Outcome outcome, const std::string& why);
  void sendStop();
  bool atRest() const;
  bool awaitRest(std::unique_lock<std::mutex>& lock);
  bool awaitState(std::unique_lock<std::mutex>& lock, double seconds, const std::function<bool()>& shows);
  void countStop(const std::string& who);
  std::string stoppedBy() const;
  bool emergency() const { return emergencies_ != undone_; }
  void requireAnswering(std::uint32_t stopsSeen) const;  // with `mutex_` held, as the next two
  void requireReady(std::uint32_t stopsSeen) const;
  void beginCurrent(bool armed);
  void order(std::uint32_t stopsSeen, bool homing, const std::function<void()>& give);
  std::string faultText() const;
  std::string switchWords() const;
  void awaitHoming(const std::vector<std::size_t>& stage, std::uint32_t stopsSeen, const Watch& watch);
  Report judge(const Current& current, bool cancelled) const;
  std::string tripWords(const Current& current) const;
  std::vector<std::vector<std::size_t>> stagesOf(const std::vector<std::string>& names) const;

  std::shared_ptr<AxisController> controller_;
  std::vector<std::string> axes_;
  std::vector<Joint> joints_;
  Settings settings_;
  Capabilities capabilities_;
  MotionOwner owner_;

  mutable std::timed_mutex device_;  // calls of the controller that one thread makes at a time
  mutable std::mutex mutex_;         // everything below
  mutable std::condition_variable changed_;
  StateCheck check_;
  ClockMap clock_;
  ProbeDebounce probe_;
  AxesState state_;
  std::string lost_, forbidden_;
  bool regained_ = false;   // after a loss, until the axes rest
  double pause_ = 0.0;      // s that this process stood still before the cycle that comes
  bool homedHere_ = false;  // since this object began, and no reset since
  std::optional<Current> current_;
  MotionId lastId_ = 0;
  std::uint32_t unsuccessful_ = 0;
  bool touched_ = false;  // a trip ended the last motion: the next one leaves a surface
  std::optional<std::vector<double>> closedAt_;  // where the probe closed, until it has opened for good
  std::optional<double> openSince_;              // s on the controller's clock, while `closedAt_`
  std::vector<double> restsAt_;                  // since `restsSince_` no axis was further away than noise
  double restsSince_ = 0.0;                      // s on the controller's clock
  std::uint64_t states_ = 0;                     // taken so far
  Wall::time_point fresh_;                       // of the last state that was newer than the one before
  std::optional<Wall::time_point> asking_;       // since when the controller owes an answer
  Wall::time_point nextReconnect_;

  mutable std::mutex stopperMutex_;  // held to copy a name and for nothing else: no stop waits for it
  std::string stopper_;
  std::atomic<std::uint32_t> stops_{0};
  std::atomic<int> stopping_{0};
  // An emergency stop counts before and after it told the controller: it holds until a reset that began after
  // both has come through.
  std::atomic<std::uint32_t> emergencies_{0}, undone_{0};
  std::atomic<bool> ending_{false}, leaving_{false};
};

}  // namespace mm
