#pragma once
#include <atomic>
#include <deque>
#include <memory>
#include <mutex>

#include "drivers/axis_map.h"
#include "drivers/device_link.h"
#include "drivers/grbl_protocol.h"

namespace mm {

/// A controller that speaks grbl 1.1 or grblHAL, on a serial line or a TCP port, with up to six axes.
/// Positions come from status reports that are asked for; a probing motion is G38.3, and so is positioning
/// unless `guard` is false: the control itself stops where the probe trips. Lines are sent by counting the
/// characters that the control has not yet taken, so that real-time bytes never wait behind them.
/// grbl has no clock: a state's time is the middle between question and answer on the host's steady clock. A
/// report does not say which question it answers: it is taken for that of the oldest one that is open.
/// What is latched at a trip are commanded positions, in steps.
/// After ALARM:1 and ALARM:2 grbl 1.1 answers nothing, not even "?", until it is reset: no loss.
/// Parameters: `address`, `axes`, `sign`, `zero` (as AxisMap), `report_rate` (Hz), `guard` (true, false),
/// `connect_timeout` (s, for the first answers), `homing_timeout` (s), `off_limit_mm`, `silence` (s without a
/// report: lost), `dead_man` (s without a sign of this process: stopped by the program `line_guard`, which
/// this one starts), `helper` (its path).
class GrblController final : public AxisController {
 public:
  ~GrblController() override;

  void open(const ControllerSetup& setup) override;
  void reconnect() override;
  void close() override;
  const std::vector<std::string>& axes() const override { return map_->names(); }
  Capabilities capabilities() const override;
  AxesState poll(double elapsed) override;
  void home(const std::vector<std::size_t>& axes) override;
  void move(const AxesMotion& motion) override;
  void clearAlarm() override;
  void moveOffLimit() override;
  void resetEmergencyStop() override;
  std::vector<ProbeEdge> takeProbeEdges() override;
  void stop() override;
  void emergencyStop() override;
  void feedHold(bool hold) override;
  void setOverride(double share) override;

 private:
  enum class Task { kNone, kPlain, kJog, kGuarded, kProbing, kHoming };  // kJog: off a limit switch
  // How far what is under way has come. Free: nothing is. Sent: the control has not answered its line.
  // Answered: it has, and ends when a report says so. Stopping: a feed hold was sent; it ends with a soft
  // reset. Resetting: one was sent; only the greeting ends it.
  enum class Phase { kFree, kSent, kAnswered, kStopping, kResetting };
  struct Transition {
    Phase phase;
    std::vector<GrblShows> shows;
    bool since;  // only by a report that was asked for after the order, or the stop
    void (GrblController::*then)();
  };
  static const std::vector<Transition> kTransitions;
  // In the link's thread.
  void take(const std::string& line, double time);
  bool understood(const std::string& line, double time);
  void takeReport(const GrblReport& report, double time);
  void takeState(const std::vector<double>& machine, double at);
  void takePins(const std::string& pins);
  void takeCondition(const GrblReport& report);
  Phase phase() const;
  void judge(double sent);
  void arrive();
  void endHoming();
  void endStopInAlarm();
  void takeProbe(const GrblProbe& probe, double time);
  void takeAnswer(int code);
  void takeAlarm(int code);
  void takeWelcome(const std::string& line);
  void takeInfo(const std::string& line);
  // With `mutex_` held.
  void send(const std::string& line);
  void pump();
  void ask();
  bool askNow(double now) const;
  double questionOf(double time);
  void start(Task task);
  void finish(Outcome outcome, const std::string& note = {});
  void forgetLines();
  void endStop();
  void endReset();
  void requireNoStop() const;
  double setting(int id) const;  // NaN: it was not told
  std::string block(const std::vector<double>& target, const std::vector<double>& from, double seconds) const;
  void begin();
  void awaitReady(double seconds);
  double deceleration() const;
  void beat();

  std::unique_ptr<AxisMap> map_;
  std::unique_ptr<DeviceLink> link_, guardian_;  // the line, and the program that stops what moves without us
  double reportPeriod_ = 0.05, connectTimeout_ = kLinkConnect, homingTimeout_ = 120.0, offLimit_ = 2.0;
  double silence_ = kLinkSilence;
  bool guard_ = true;

  std::mutex
      byteMutex_;  // times of stops and resets follow each other as their bytes do; never held for long
  mutable std::mutex mutex_;
  std::map<int, double> settings_;
  bool hal_ = false;
  std::size_t buffer_ = 128;
  std::deque<std::string> waiting_;   // lines that the control has no room for yet
  std::deque<std::size_t> inFlight_;  // characters of lines that it has not answered
  std::deque<double> questions_;      // s, of those that may still be answered
  double lastAsked_ = 0.0, lastReport_ = 0.0, connected_ = 0.0, roundTrip_ = 0.0;
  GrblReport report_;
  std::vector<double> offset_;  // WCO
  AxesState state_;
  std::vector<bool> homed_;
  std::vector<std::size_t> homing_;
  std::atomic<Task> task_{Task::kNone};
  bool answered_ = false;  // the line of the task was answered
  bool begun_ = false;     // the control was seen to move, or the line was answered
  bool clearing_ = false;  // an alarm, as was asked
  bool locked_ = false;    // after a limit: it answers nothing until it is reset
  bool tripped_ = false;
  double taskBegan_ = 0.0, beatAt_ = 0.0;
  AxesMotion motion_;
  std::vector<double> lastDirection_;
  std::vector<ProbeEdge> edges_;
  std::string away_;     // why it could not be connected again
  std::string trouble_;  // why what arrives is not grbl
  int damaged_ = 0;      // lines in a row that were not
  std::atomic<bool> stopAsked_{false}, emergency_{false}, resetAsked_{false};
  std::atomic<double> stopSent_{0.0}, resetAt_{0.0};  // s
};

}  // namespace mm
