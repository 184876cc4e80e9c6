#pragma once
#include <atomic>
#include <deque>
#include <memory>

#include "drivers/axis_controller.h"

namespace mm {

struct SimulatedInstrument;

/// The controller of the simulated instrument: no hardware, but homing, limits, an emergency stop, a probe
/// whose switch bounces, and sensors, with the errors of a plan's `instrument` and of `hide`.
/// Parameters: `plan` (path of a plan: artifact and instrument), `hide` (sources, separated by `;`), `seed`,
/// `bounce_s` (how long the probe's switch bounces), `acceleration_m_s2`, `acceleration_rad_s2`, `fault`
/// (none or ok, off, stuck, garbage, wrong, slow, intermittent, probe_stuck, probe_dead, temperature_frozen,
/// temperature_lost).
class SimulatedController final : public AxisController {
 public:
  SimulatedController();
  ~SimulatedController() override;

  void open(const ControllerSetup& setup) override;
  void reconnect() override;
  const std::vector<std::string>& axes() const override { return axes_; }
  Capabilities capabilities() const override;
  AxesState poll(double elapsed) override;
  void home(const std::vector<std::size_t>& axes) override;
  void move(const AxesMotion& motion) override;
  void clearAlarm() override {}
  void resetEmergencyStop() override;
  std::vector<ProbeEdge> takeProbeEdges() override;
  std::optional<ProbeEdge> readLaser() override;
  std::vector<std::pair<std::string, double>> temperatures() override;
  std::optional<std::array<double, 3>> trueTip() const override;
  void breakDevice(const std::string& fault) override;

  void stop() override { stopAsked_ = true; }
  void emergencyStop() override { emergency_ = true; }
  void feedHold(bool hold) override { held_ = hold; }
  void setOverride(double share) override { override_ = share; }

 private:
  enum class Fault {
    kNone,
    kOff,
    kStuck,
    kGarbage,
    kWrong,
    kSlow,
    kIntermittent,
    kProbeStuck,
    kProbeDead,
    kTemperatureFrozen,
    kTemperatureLost
  };
  static Fault faultOf(const std::string& name);
  void start();
  void takeOrders();
  void advance(double seconds);
  double rampAfter(double seconds) const;
  void finish(Outcome outcome);
  void addEdges(const ProbeEdge& edge);
  void requirePower() const;
  bool answers() const;
  AxesState stateNow() const;
  AxesState broken(const AxesState& state);

  std::unique_ptr<SimulatedInstrument> instrument_;
  std::vector<std::string> axes_;
  std::string errors_;  // that the instrument has, for people
  std::vector<double> homePosition_, acceleration_;
  std::vector<bool> homed_;
  std::vector<std::size_t> homing_;  // axes; empty: none
  AxesMotion motion_;
  double ramp_ = 0.0, rise_ = 0.0;  // share of the motion's speed; s from rest to the whole of it
  std::optional<Outcome> ending_;   // decelerates, then ends so
  Outcome outcome_ = Outcome::kReached;
  bool moving_ = false, touching_ = false, powered_ = true;
  double bounce_ = 0.0;  // s
  Fault fault_ = Fault::kNone;
  std::uint32_t resets_ = 0;
  std::uint64_t polls_ = 0;
  std::deque<AxesState> late_;
  std::optional<AxesState> last_;  // that was told
  std::vector<ProbeEdge> edges_;
  std::vector<std::pair<std::string, double>> frozen_;
  std::atomic<bool> stopAsked_{false}, emergency_{false}, held_{false};
  std::atomic<double> override_{1.0};
};

}  // namespace mm
