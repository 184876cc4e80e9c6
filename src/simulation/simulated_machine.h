#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "session/session.h"
#include "simulation/instrument_settings.h"
#include "simulation/physics.h"
#include "simulation/reading_noise.h"
#include "simulation/screw.h"

namespace mm {

/// What the instrument latched when its probe tripped, or when its laser was read: readings with noise, the
/// approach by the nominal chain, the push of a touch. SI units.
struct Trip : TrueState {
  int feature = -1;
  Eigen::Vector3d truePosition = Eigen::Vector3d::Zero();  // tip centre or surface point, workpiece
};

/// What the simulated controller adds to a commanded position before it drives there, m or rad, a joint each.
/// The operator and every record go on to see the commanded position, as on LinuxCNC or a CNC with a pitch
/// error table: what is right makes the tip go where it was sent. @param travel a joint: -1, +1, or 0 where
/// it has not moved yet. @param temperatures degC, by sensor, without noise.
using ControllerAdds =
    std::function<std::vector<double>(const std::vector<double>& command, const std::vector<double>& travel,
                                      const std::map<std::string, double>& temperatures)>;

/// The instrument: drives, slides, probe, sensors. It is moved segment by segment, or step by step by a
/// driver. The same seed and the same calls give the same bits. Not thread-safe.
class SimulatedMachine {
 public:
  /// @param artifact as stated, for names only; the true one is in `physics`.
  SimulatedMachine(Machine machine, Artifact artifact, InstrumentSettings settings, Physics physics,
                   std::uint64_t seed);

  const TrueArtifact& artifact() const { return physics_.artifact; }            ///< as it lies now
  void putDown(const TrueArtifact& artifact) { physics_.artifact = artifact; }  ///< by hand, between moves
  /// @param stylus index in the artifact's. @param offset true place of its tip from probe_tip, m.
  void takeStylus(int stylus, const Eigen::Vector3d& offset) { stylus_ = stylus, offset_ = offset; }

  double time() const { return time_; }                              ///< s since switching on
  const std::vector<double>& readings() const { return drive_; }     ///< of the drives, m or rad
  const std::vector<double>& velocity() const { return velocity_; }  ///< m/s or rad/s
  const std::vector<double>& travel() const { return travel_; }  ///< -1, +1 of the last motion; 0: none yet
  const Machine& machine() const { return machine_; }            ///< nominal
  /// As the plan has them.
  const InstrumentSettings& settings() const { return settings_; }

  /// From now on the controller corrects what it is told; its readings stay the commanded ones. Only before
  /// anything else.
  void loadCorrection(ControllerAdds correction);
  /// The same at standstill, in the middle of a session: the drives go there with the next motion. Null: it
  /// corrects nothing.
  void switchCorrection(ControllerAdds correction) { correction_ = std::move(correction); }
  /// Puts the drives there without a motion: only before anything else.
  void home(const std::vector<double>& readings);
  void wait(double seconds);
  /// Goes straight to the readings, all joints arriving together. @param linear m/s and @param rotary rad/s:
  /// highest speed of a joint of its kind.
  void moveTo(const std::vector<double>& target, double linear, double rotary);
  /// Lets `seconds` pass while each joint goes towards its target with at most its own speed (m/s or rad/s,
  /// one a joint). A trip on the way is latched; the motion goes on. For drivers.
  void step(const std::vector<double>& target, const std::vector<double>& speed, double seconds);
  /// Since the last call of `takeTrip`.
  bool tripped() const { return trip_.has_value(); }
  bool touching() const { return touching_; }  ///< after the last `step`
  std::optional<Trip> takeTrip() { return std::exchange(trip_, std::nullopt); }
  /// Goes straight towards the readings until the tip touches the feature; stops there.
  /// @param speed of the tip, m/s. @return nothing when the target is reached without contact.
  std::optional<Trip> touch(const std::vector<double>& target, double speed, int feature);
  /// Reads the laser on a feature where it stands. @return nothing when it misses, is out of range or drops
  /// out.
  std::optional<Trip> readLaser(int feature);
  std::optional<Trip> readLaser();  ///< on whatever the beam meets first; for drivers
  /// True minus indicated of a joint (m or rad) as an interferometer or autocollimator finds it, with its
  /// noise.
  double measureDeviation(int joint);
  double sightDeviation(int joint, const ProbePose& truth) const;
  /// True tip in workpiece (m) as a tracker finds it, with its noise.
  Eigen::Vector3d measurePosition();

  const std::vector<std::string>& sensorNames() const { return settings_.thermal.sensors; }  ///< as logged
  std::vector<double> temperatures();  ///< degC, as the sensors say now, with noise
  const std::vector<Series>& temperatureLog() const { return temperatureLog_; }  ///< degC
  const std::vector<Series>& covariateLog() const { return covariateLog_; }      ///< own units
  Eigen::Vector3d trueTip() const;  ///< in workpiece, without the probe's pre-travel
  Truth truth() const { return Truth(chain_, physics_, thermal_); }  ///< what a reading truly means

 private:
  struct Segment {
    std::vector<double> from, to, velocity;
    double duration = 0.0;  // s
  };
  Segment straightTo(const std::vector<double>& target, double duration) const;
  Condition condition(const std::vector<double>& drive, double time) const;
  /// Where the drives really go for a commanded position.
  std::vector<double> travelNow() const;  // of each drive, -1 or +1; 0: it never moved
  std::vector<double> corrected(const std::vector<double>& command) const;
  /// The tip before a feature: distance (m) that is left until it touches, outward normal, its true centre.
  struct Clearance {
    double left = 0.0;
    Eigen::Vector3d normal, tip;
    double preTravel = 0.0;  // m
  };
  Clearance clearance(const Segment& segment, double part, int feature) const;  // part: 0 to 1
  double jointRepeatability(std::size_t joint) const;                           // m or rad
  std::optional<double> findContact(const Segment& segment, int feature,
                                    double from = 0.0) const;  // parts of the segment
  Trip latch(const Segment& segment, double part, int feature);
  void drive(const Segment& segment, double part);
  void pass(double seconds, double activity);
  void log();

  Machine machine_;
  Artifact artifact_;
  InstrumentSettings settings_;
  Physics physics_;
  Chain chain_;
  ThermalModel thermal_;
  std::vector<TemperatureSensor> sensors_;
  std::vector<Play> play_;
  ControllerAdds correction_;  // null: the controller corrects nothing
  std::vector<double> drive_, velocity_, travel_;
  double time_ = 0.0, nextLog_ = 0.0;
  ReadingNoise noise_;  // channels: readings of the joints, laser, deviations of the joints, x, y, z
  Random sensorNoise_;
  std::vector<Series> temperatureLog_, covariateLog_;
  std::optional<Trip> trip_;
  bool touching_ = false;
  int stylus_ = 0;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();  // of its tip from probe_tip, axes of probe_tip, m
};

}  // namespace mm
