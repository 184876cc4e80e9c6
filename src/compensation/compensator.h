#pragma once
#include <memory>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "compensation/limits.h"
#include "model/model.h"

namespace mm {

/// What a motion along a joint, or along x, y or z of workpiece, does to the tip: m/rad, or a unit vector;
/// zero where there is no such direction. @param jacobian of the machine.
Eigen::Vector3d motionAlong(const std::string& direction, const Domain& domain,
                            const Eigen::Matrix<double, 6, Eigen::Dynamic>& jacobian);

/// Where the probe really is, and whether that can be trusted. Frame: workpiece; m, rad.
struct Correction {
  ProbePose nominal, corrected;                            // tip centre (touch) or surface point (laser)
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  // corrected minus nominal, m
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  // from nominal to corrected, as a rotation vector, rad
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of the corrected position, m^2
  double sigma = 0.0;          // m: root mean square over the three coordinates of their standard deviations
  bool valid = false;          // may be used as a measured position
  bool extrapolating = false;  // an input is outside the calibrated range by more than the margin
  bool inputLost = false;      // a temperature or covariate that the model uses is not known
  bool pastUnknown = false;    // temperatures were not heard for long enough for what lags behind them
  bool tooOld = false;         // outside the calibrated duration: effects of time are not applied
  std::string reason;          // why it is not valid; empty when it is
  std::string note;            // what to know although it is valid
};

/// A history that began while it was asked already: what was before is not known.
class YoungHistory : public TemperatureHistory {
 public:
  /// The same had the temperatures before the first value been a standard deviation away from it; null: what
  /// was before has decayed.
  virtual const TemperatureHistory* otherPast() const = 0;
};

/// A state with what its joints did before it.
struct MovingState : State {
  /// A joint; m or rad that it has come back from its farthest reading, too little to be called a reversal.
  /// Empty: nothing.
  std::vector<double> back;
  MovingState() = default;
  MovingState(State state) : State(std::move(state)) {}
};

/// Readings that bring the probe to a true point.
struct TargetReadings {
  bool reached = false;
  std::string reason;            // why not
  std::vector<double> position;  // uncorrected readings, m and rad
  double sigma = 0.0;            // m, as in Correction
  int iterations = 0;
  Correction correction;  // at these readings
};

/// Applies one calibration to the present state, within its limits. The standard deviation is that of the
/// calibration's parameters, of what the machine wanders, and of play that is still being taken up after a
/// reversal (MovingState); the repeatability of a single contact is not in it. Immutable: several
/// threads may use one, with a workspace each.
class Compensator {
 public:
  struct Options {
    double margin =
        0.10;           // beyond the observed range of a joint, temperature or covariate, as a fraction of it
    bool sigma = true;  // false: covariance and sigma stay zero, which is faster
  };
  /// Buffers of one thread.
  struct Workspace {
    Model::Workspace model;
  };

  /// @throw InputError when the calibration's effects are not those that its parameters belong to, or its
  /// margin is negative.
  explicit Compensator(const Calibration& calibration) : Compensator(calibration, Options()) {}
  Compensator(const Calibration& calibration, Options options);

  const std::string& id() const { return id_; }  ///< of the calibration
  const Model& model() const { return model_; }  ///< its machine and effects

  /// A state with a place for everything that the calibration knows, nothing of it known yet.
  State blankState() const;

  /// @param state in the order of the calibration's domain; tip and orientation as by Model::place.
  Correction apply(const State& state, Workspace& work) const { return apply(state, {}, work); }
  Correction apply(const State& state) const;
  Correction apply(const MovingState& state) const;

  /// Solves for the readings at which the corrected position is `truePoint` (Newton's method on the nominal
  /// chain's Jacobian). The linear joints move; rotary joints keep their readings unless the linear ones
  /// cannot reach every direction. The direction of travel at the target is that of the move that leads
  /// there; a joint that stays keeps the one it has. Where the target is nearer than the play, so that
  /// neither direction leads to it by a move of its own, it is approached upwards, and the note says so.
  /// @param start present state. @param arrival a joint: +1 or -1 where the direction at the target is told,
  /// 0: by the move; empty: none is told.
  TargetReadings correctTarget(const Eigen::Vector3d& truePoint, MovingState start,
                               const std::vector<double>& arrival = {}) const;

 private:
  /// The effects that are applied at some time, with their parameters.
  struct Part {
    std::shared_ptr<const Model> model;
    Eigen::VectorXd parameters;
    Eigen::MatrixXd covariance;
  };
  Part partOf(const Calibration& calibration, bool timed) const;
  void judge(const State& state, const Part& part, Correction& c) const;
  Correction apply(const State& state, const MovingState* moved, Workspace& work) const;
  void addPast(const State& state, const Part& part, Workspace& work, Correction& c) const;
  void addPlay(const State& state, const MovingState& moved, const Part& part, Workspace& work,
               Correction& c) const;

  std::string id_;
  Options options_;
  Model model_;
  Part all_, timeless_;
  /// An effect: it counts the time since the start, and says nothing beyond the calibrated duration.
  std::vector<bool> ofTime_;
  std::string timed_;             // names of these
  std::vector<Wandering> drift_;  // what the corrected position may be off by, beside its parameters
  std::unique_ptr<const CalibratedLimits> limits_;
};

/// A state at rest in the middle of everything that was calibrated: positions, temperatures, covariates, the
/// laser's reading. Directions of travel and the time are those of Compensator::blankState.
State middleState(const Compensator& compensator);

}  // namespace mm
