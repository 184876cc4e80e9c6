#pragma once
#include <memory>

#include "drivers/axis_controller.h"

namespace mm {

struct SimulatedInstrument;

/// The controller of the simulated instrument: no hardware, but homing, limits, an emergency stop, a probe
/// whose switch bounces, and sensors, with the errors of a plan's `instrument` and of `hide`.
/// Parameters: `plan` (path of a plan: artifact and instrument), `hide` (sources, separated by `;`), `seed`,
/// `bounce_s` (how long the switch bounces), `fault` (none, probe_stuck, probe_dead, temperature_frozen,
/// temperature_lost).
class SimulatedController final : public AxisController {
 public:
  SimulatedController();
  ~SimulatedController() override;

  void open(const Machine& machine, const Parameters& parameters) override;
  const std::vector<std::string>& axes() const override { return axes_; }
  AxesState poll(double elapsed) override;
  void home() override;
  void move(const AxesMotion& motion) override;
  void stop() override;
  void emergencyStop() override;
  void resetEmergencyStop() override;
  std::vector<ProbeEdge> takeProbeEdges() override;
  std::optional<ProbeEdge> readLaser() override;
  std::vector<std::pair<std::string, double>> temperatures() override;
  std::optional<Eigen::Vector3d> trueTip() const override;

 private:
  enum class Fault { kNone, kProbeStuck, kProbeDead, kTemperatureFrozen, kTemperatureLost };
  static Fault faultOf(const std::string& name);
  void advance(double seconds);
  void addEdges(double time, const std::vector<double>& position, const std::vector<double>& velocity);
  void requirePower() const;
  bool arrived() const;

  std::unique_ptr<SimulatedInstrument> instrument_;
  std::vector<std::string> axes_;
  std::vector<double> homePosition_;
  AxesMotion motion_;
  bool moving_ = false, homing_ = false, homed_ = false, stopped_ = false, touching_ = false;
  double bounce_ = 0.0;  // s
  Fault fault_ = Fault::kNone;
  std::vector<ProbeEdge> edges_;
  std::vector<std::pair<std::string, double>> frozen_;
};

}  // namespace mm
