#pragma once
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>

#include "drivers/axis_map.h"
#include "drivers/device_link.h"
#include "drivers/linuxcnc_state.h"

namespace mm {

/// LinuxCNC through its Python module, on the computer where it runs: two programs `linuxcnc_helper`, which
/// this one starts. One tells states, the other gives commands; each can stop by itself, and each does where
/// this process ends or falls silent. Motions are MDI: G1 in machine coordinates, G38.3 for probing, whatever
/// the work coordinates are; what motion latched at the trip (feedback, machine coordinates) comes with the
/// state. LinuxCNC stops by itself where the probe trips outside of probing. Parameters: `axes`, `sign`,
/// `zero` (as AxisMap), `coordinates` (letters in the order of its joints), `poll_rate` (Hz), `servo_period`
/// (s), `connect_timeout` (s, for the first state), `homing_timeout` (s), `silence` (s without a state:
/// lost), `dead_man` (s without a sign of this process: stopped), `helper` (path).
class LinuxCncController final : public AxisController {
 public:
  ~LinuxCncController() override;

  void open(const ControllerSetup& setup) override;
  void reconnect() override;
  void close() override;
  const std::vector<std::string>& axes() const override { return map_->names(); }
  Capabilities capabilities() const override;
  AxesState poll(double elapsed) override;
  void home(const std::vector<std::size_t>& axes) override;
  void move(const AxesMotion& motion) override;
  void clearAlarm() override;
  void resetEmergencyStop() override;
  std::vector<ProbeEdge> takeProbeEdges() override;
  void stop() override;
  void emergencyStop() override;
  void feedHold(bool hold) override;
  void setOverride(double share) override;

 private:
  enum class Task { kNone, kGo, kProbing, kHoming };
  void take(const std::string& line);  // in the links' threads
  // With `mutex_` held.
  void takeState(const LinuxCncState& now);
  void takeReadings(const LinuxCncState& now);
  void takeErrors(const LinuxCncState& now);
  void takeProbe(const LinuxCncState& now);
  void judge(const LinuxCncState& now);
  void tendOverride(const LinuxCncState& now);
  Alarm alarmOf(const LinuxCncState& now) const;
  std::string axisOnLimit() const;  // for people; empty: none
  bool settled(const LinuxCncState& now) const;
  bool rests(const LinuxCncState& now) const;
  bool arrived(const LinuxCncState& now) const;
  ProbeEdge latchOf(const LinuxCncState& now) const;
  void finish(Outcome outcome, const std::string& note);
  void beginTask(Task task);
  std::vector<std::string> motionLines(const AxesMotion& motion) const;
  std::string probingWords(const std::vector<double>& way) const;
  void give(const std::vector<std::string>& commands);
  void giveOverride(double share);
  void beat();
  // Without it.
  void begin();
  void urgent(const char* word, std::atomic<double>& said);
  void requireFit(const LinuxCncState& first) const;  // to be driven
  std::size_t jointOf(std::size_t axis) const;        // LinuxCNC's number of the joint

  std::unique_ptr<AxisMap> map_;
  std::unique_ptr<DeviceLink> watch_, act_;
  std::string coordinates_ = "XYZABC";
  double period_ = 0.02, servoPeriod_ = 1e-3, connectTimeout_ = kLinkConnect, homingTimeout_ = 120.0;
  double silence_ = kLinkSilence, deadMan_ = 0.5;

  std::atomic<std::int64_t> sent_{0};                       // number of the last command, stops among them
  std::atomic<double> stopSaid_{0.0}, emergencySaid_{0.0};  // s; 0: none is under way
  std::atomic<double> emergencySince_{0.0};                 // s

  mutable std::mutex mutex_;  // everything below
  std::condition_variable first_;
  std::optional<LinuxCncState> last_;
  std::int64_t taken_ = 0, serial_ = 0;  // the last command that LinuxCNC was given, and as which of its own
  double settledAt_ = 0.0;               // s of the last state that shows every command taken
  double untakenAt_ = 0.0;               // s of the last state that does not
  double ownAt_ = 0.0;                   // s of the last state in which what happens may be by this driver
  double idleSince_ = 0.0;               // s since when nothing is under way
  double beatAt_ = 0.0;                  // s
  std::string trouble_;
  AxesState state_;
  std::vector<ProbeEdge> edges_;

  Task task_ = Task::kNone;
  AxesMotion motion_;
  std::vector<double> goal_;  // of it: X Y Z A B C, mm or deg
  std::vector<std::size_t> homing_;
  double began_ = 0.0, driven_ = 0.0, tripSeen_ = 0.0;  // s; driven_: of the last change of what is commanded
  std::int64_t lapses_ = 0;                             // when the task began
  bool openSeen_ = false;   // the probe was open when the task began, or was seen to open since
  std::string error_;       // that LinuxCNC told since then
  std::string said_;        // that it told last, and when
  double saidAt_ = 0.0;     // s
  double off_ = 0.0;        // s since when the machine is seen off; 0: it is on
  std::string offSaid_;     // behind a colon: what it told when its machine went off
  bool resetting_ = false;  // the emergency stop, until it has taken that
  bool others_ = false;     // the axes move, or a program runs, that is none of ours

  double share_ = 1.0;     // of the speeds, when nothing holds them
  bool holding_ = false;   // asked for by `feedHold`
  bool giveBack_ = false;  // a hold that has lost its motion
  bool owed_ = false;      // an override that was asked for while LinuxCNC showed 0
};

}  // namespace mm
