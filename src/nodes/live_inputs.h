#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "compensation/compensator.h"
#include "effects/domain.h"
#include "machine/machine.h"
#include "model/series_history.h"
#include "session/travel_tracker.h"

namespace mm {

/// What is known of the machine now: the newest reading of every joint, the direction of its last motion, and
/// the temperatures and covariates so far, with their age. Stamps in ns. Not thread-safe.
class LiveInputs {
 public:
  struct Settings {
    double jointAge = 0.05;   // s by which the readings of one frame may differ
    double sensorAge = 30.0;  // s after which a temperature or covariate counts as lost
    double deadband = travelDeadband(JointKind::kLinear);        // m: a shorter way back is no reversal
    double rotaryDeadband = travelDeadband(JointKind::kRotary);  // rad
  };
  /// What one calibration sees of it. Lives no longer than the inputs.
  struct View {
    std::vector<int> sensors, covariates;  // a sensor or covariate of the domain: its place here
    std::shared_ptr<TemperatureHistory> history;
  };

  LiveInputs(const Machine& machine, Settings settings);

  /// @return false when no frame can be made of the message: `reason` says why; it is empty where the stamp
  /// is the one before, and where the message has no joint of this machine: neither its joints nor its clock
  /// say anything here. A stamp that goes back by more than a blink begins everything anew.
  bool takeJoints(std::int64_t stamp, const std::vector<std::string>& names,
                  const std::vector<double>& position, const std::vector<double>& velocity,
                  std::string& reason);
  /// @param name of a sensor that is watched; others are left alone. @param value degC. @return false where
  /// it was set aside: it has no stamp, or one before the last. Several such in a row are a clock that went
  /// back.
  bool takeTemperature(const std::string& name, std::int64_t stamp, double value);
  bool takeCovariate(const std::string& name, std::int64_t stamp, double value);
  /// Direction of the last motion of a joint as its driver tells it, -1 or 1; 0: it does not know. It counts
  /// from the joint state of that stamp on, before what was seen here until then.
  void takeTravel(int joint, std::int64_t stamp, double direction) { told_[joint] = {stamp, direction}; }
  /// As Settings: s by which the readings of one frame may differ, and after which a sensor counts as lost.
  void setTimeouts(double jointAge, double sensorAge) {
    settings_.jointAge = jointAge;
    settings_.sensorAge = sensorAge;
  }
  /// How the joint moved before is not known.
  void forgetTravel(int joint);
  /// What `t = 0` is: the last homing, or the session's start. 0: not known.
  void setTimeZero(std::int64_t stamp) { zero_ = stamp; }

  /// Watches what the domain knows from here on.
  View watch(const Domain& domain);
  const std::vector<std::string>& sensors() const { return sensorNames_; }
  const std::vector<std::string>& covariates() const { return covariateNames_; }

  /// The state at the last joint state, in the order of a domain, without what is touched.
  void fill(const View& view, MovingState& state) const;
  /// The same with other readings of the same moment or shortly before, as a contact brings them. NaN
  /// velocity: not known. The direction of a joint that moves is that of its velocity.
  void fill(const View& view, std::int64_t stamp, const std::vector<double>& position,
            const std::vector<double>& velocity, MovingState& state) const;
  /// Whether every sensor and covariate of the view has been heard.
  bool heard(const View& view) const;
  bool complete() const { return complete_; }

 private:
  class History;
  struct Logged {
    std::int64_t stamp = 0;  // 0: never
    double value = 0.0;
    Series history;  // t in s since origin_
    int behind = 0;  // stamps in a row before the last one
  };
  bool take(Logged& logged, std::int64_t stamp, double value);
  double at(const Logged& logged, std::int64_t stamp) const;
  void fillLogged(const View& view, std::int64_t stamp, MovingState& state) const;
  void followTravel(int joint);
  void forget();
  void orderFor(const std::vector<std::string>& names);

  Settings settings_;
  std::vector<std::string> joints_;
  std::vector<std::int64_t> seen_;  // a joint; 0: never
  std::vector<double> position_, velocity_;
  std::vector<TravelTracker> travel_;  // a joint
  struct Told {
    std::int64_t stamp = 0;
    double direction = 0.0;  // 0: nothing
  };
  std::vector<Told> told_;  // a joint
  std::vector<std::string> namesBefore_, sensorNames_, covariateNames_;
  std::vector<int> order_;  // an entry of the message: joint, or -1
  std::vector<Logged> sensors_, covariates_;
  std::int64_t last_ = 0, zero_ = 0, origin_ = 0;
  std::uint64_t revision_ = 0;  // of the temperatures
  bool complete_ = false;
};

}  // namespace mm
