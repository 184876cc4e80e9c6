#pragma once
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>

#include "drivers/axis_map.h"
#include "drivers/linuxcnc_talk.h"

namespace mm {

/// LinuxCNC through its own server linuxcncrsh, on TCP. Motions are MDI: G1 in machine coordinates, G38.3 for
/// probing, whatever the work coordinates are; what was latched (#5061 to #5066, feedback positions of the
/// servo period of the trip) comes back as `(DEBUG, …)`. A motion has ended when LinuxCNC has taken it, is
/// idle, and nothing moves. LinuxCNC stops by itself where the probe trips outside of probing. Parameters:
/// `address`, `axes`, `sign`, `zero` (as AxisMap), `coordinates` (letters in the order of its joints),
/// `connect_password`, `enable_password`, `poll_rate` (Hz), `servo_period` (s), `connect_timeout` (s,
/// for the first answers), `homing_timeout` (s), `silence` (s without a state: lost).
class LinuxCncController final : public AxisController {
 public:
  LinuxCncController();
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
  // In the connections' threads.
  void take(const LinuxCncLine& line, double time);
  void takePart(const LinuxCncLine& line, double time);
  void damaged();
  // With `mutex_` held.
  void takeRound();
  void takeState(const LinuxCncRound& now, double at);
  void takeProbe(bool closed, double at);
  void takeMessage(const std::string& text);
  void takeError(const std::string& text);
  void judge();
  void judgeStop();
  void judgeOff();
  void giveOverrideBack();
  void judgeHoming();
  void judgeProbing();
  std::vector<double> latchedPlace() const;
  void ask();
  void finish(Outcome outcome, const std::string& note = {});
  void beginTask(Task task);
  void begin();
  void requireUnits() const;
  std::vector<std::string> motionLines(const AxesMotion& motion) const;
  std::string probingWords(const std::vector<double>& way) const;
  std::string axisOnLimit() const;  // for people; empty: none
  std::string overrideLine(bool hold) const;
  std::size_t jointOf(std::size_t axis) const;  // LinuxCNC's number of the joint

  std::unique_ptr<AxisMap> map_;
  std::unique_ptr<LinuxCncTalk> talk_;
  std::string coordinates_ = "XYZABC";
  double pollPeriod_ = 0.02, servoPeriod_ = 1e-3, connectTimeout_ = kLinkConnect, homingTimeout_ = 120.0;
  double silence_ = kLinkSilence;

  mutable std::mutex mutex_;       // everything below
  std::condition_variable heard_;  // a round has ended
  LinuxCncRound next_, last_;
  double lastAsked_ = 0.0;  // s
  AxesState state_;
  std::vector<ProbeEdge> edges_;
  Task task_ = Task::kNone;
  AxesMotion motion_;
  std::vector<std::size_t> homing_;
  double taskBegan_ = 0.0, still_ = 0.0, tripSeen_ = 0.0;  // s; still_: since when nothing moves
  double age_ = 0.0;         // s since when LinuxCNC shows axes still that it drives
  bool went_ = false;        // an axis moved since the task began
  double homedSince_ = 0.0;  // s, of the first round from which on all flags of the axes stand
  bool fell_ = false;        // a flag was seen to fall since homing was asked for
  double taken_ = 0.0;       // s: when LinuxCNC had taken all commands of the task; 0: not yet
  bool openSeen_ = false;    // the probe was open when the task began, or was seen to open since
  bool resetting_ = false;   // the emergency stop, until it has taken that
  bool others_ = false;      // the axes move, or a program runs, that is none of ours
  double driven_ = 0.0;      // s of the last change of what is commanded
  double off_ = 0.0;         // s since when the machine is seen off; 0: it is on
  std::string said_;         // by LinuxCNC as an error, and when
  double saidAt_ = 0.0;      // s
  std::string offSaid_;      // behind a colon: what it said when its machine went off
  std::string refusedStop_;  // a stop that LinuxCNC refused, and when
  double refusedAt_ = 0.0;   // s
  std::optional<std::vector<double>> latched_;
  std::optional<Outcome> failed_;
  std::string note_, trouble_;
  int damaged_ = 0;
  std::atomic<bool> stopAsked_{false};
  std::atomic<double> stopSent_{0.0};

  mutable std::mutex feedMutex_;  // held to give a command on its way; after `mutex_` where both are
  double share_ = 1.0;            // of the speeds, when nothing holds them
  bool holding_ = false;          // asked for by `feedHold`
  bool stands_ = false;           // LinuxCNC shows an override of 0, whoever gave it
  bool giveBack_ = false;         // a hold that has lost its motion
  bool owed_ = false;             // an override that was asked for while LinuxCNC showed 0
};

}  // namespace mm
