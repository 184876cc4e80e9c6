#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>

#include "drivers/axis_map.h"
#include "drivers/device_link.h"

namespace mm {

/// One line of linuxcncrsh: `ABS_ACT_POS 1.0 2.0 …` as its first word and the rest.
struct LinuxCncLine {
  std::string word, rest;
};
/// @return nothing for an empty line or one with bytes that are no text.
std::optional<LinuxCncLine> parseLinuxCncLine(const std::string& line);
/// Numbers between blanks. @return empty where one of them is not a finite number.
std::vector<double> parseLinuxCncNumbers(const std::string& text);

/// LinuxCNC through its own server linuxcncrsh, on TCP. Motions are MDI: G1 in machine coordinates, G38.3 for
/// probing; what was latched (#5061 to #5066, feedback positions of the servo period of the trip) comes back
/// as `(DEBUG, …)`. A motion has ended when LinuxCNC has taken it, is idle, and nothing moves. LinuxCNC stops
/// by itself where the probe trips outside of probing. linuxcncrsh answers nothing on a connection while it
/// waits for what was commanded there, so questions, commands and stops have a connection each. Parameters:
/// `address`, `axes`, `sign`, `zero` (as AxisMap), `coordinates` (letters in the order of its joints),
/// `connect_password`, `enable_password`, `poll_rate` (Hz), `servo_period` (s), `connect_timeout` (s,
/// for the first answers), `homing_timeout` (s).
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
  struct Snapshot {                  // answers to one round of questions
    double asked = 0.0, came = 0.0;  // s
    bool emergency = false, on = false, probe = false, idle = true, mdi = false;
    std::vector<bool> homed;
    std::vector<int> limits;
    std::vector<double> absolute, relative;  // mm or deg, X Y Z A B C
    double feedOverride = 1.0;
    int parts = 0;
  };

  // In the links' threads.
  void take(const std::string& line, double time);
  void takePart(const LinuxCncLine& line, double time);
  void takeSnapshot();
  void takeMessage(const std::string& text);
  void takeError(const std::string& text);
  // With `mutex_` held.
  void ask();
  void send(const std::string& commands);
  void finish(Outcome outcome, const std::string& note = {});
  void begin();
  void urgent(const std::string& command);
  std::size_t jointOf(std::size_t axis) const;  // LinuxCNC's number of the joint

  std::unique_ptr<AxisMap> map_;
  std::unique_ptr<DeviceLink> link_, commandLink_, stopLink_;  // the first for questions alone
  std::string coordinates_ = "XYZABC", hello_ = "EMC", enable_ = "EMCTOO";
  double pollPeriod_ = 0.02, servoPeriod_ = 1e-3, connectTimeout_ = kLinkConnect, homingTimeout_ = 120.0;

  mutable std::mutex mutex_;
  Snapshot next_, last_;
  bool welcomed_ = false;
  double lastAsked_ = 0.0;
  AxesState state_;
  std::vector<ProbeEdge> edges_;
  Task task_ = Task::kNone;
  AxesMotion motion_;
  std::vector<std::size_t> homing_;
  double taskBegan_ = 0.0, still_ = 0.0, tripSeen_ = 0.0;  // s; still_: since when nothing moves
  double taken_ = 0.0;      // s: when LinuxCNC had taken all commands of the task; 0: not yet
  int unanswered_ = 0;      // sendings that it has not taken yet
  bool resetting_ = false;  // the emergency stop, until it has taken that
  std::optional<std::vector<double>> latched_;
  std::optional<Outcome> failed_;
  std::string note_, trouble_;
  int damaged_ = 0;
  std::atomic<bool> stopAsked_{false};
  std::atomic<double> stopSent_{0.0}, share_{1.0};
};

}  // namespace mm
