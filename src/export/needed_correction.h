#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "export/export_axes.h"
#include "interpreters/loaded_compensation.h"
#include "model/model.h"

namespace mm {

/// What a calibration asks of the motors: where they must stand so that the probe is where its user commands
/// it. A calibration says what remained beside the compensation that was active while its session was
/// measured: the motors then stood at the reading and what that adds. Linear joints move, rotary ones stay.
/// Nothing is touched and the machine stands still, so that effects of the contact and of the speed say
/// nothing here; temperatures have settled. SI units, frame workpiece.
class NeededCorrection {
 public:
  /// @throw InputError: the calibration contradicts itself (as Compensator), exportAxes refuses the
  /// machine, or the compensation that was active is for an axis that the machine does not have.
  NeededCorrection(const Calibration& calibration, const std::map<std::string, std::string>& letters);

  const Model& model() const { return model_; }
  const std::vector<ExportAxis>& axes() const { return axes_; }  ///< in the order of the joints
  const ExportAxis& axis(int joint) const { return axes_[joint]; }
  const std::vector<int>& linear() const { return linear_; }    ///< joints that move
  const ExportAxis* findAxis(const std::string& letter) const;  ///< null: none
  /// A joint moved during the session, so that there is something to tabulate over it.
  bool moved(int joint) const;
  /// The reading at which tables are zero: 0, or the end of the observed range that is nearest to it.
  double reference(int joint) const;

  /// `count` states that fill the calibrated volume, temperatures, covariates and duration evenly (a Latin
  /// hypercube), with either direction of travel of every joint equally often. The same for the same seed.
  std::vector<State> states(int count, unsigned seed) const;

  /// What was stated of the compensation that was active.
  const ControllerCompensation& compensation() const { return compensation_; }
  const LoadedCompensation* active() const { return active_.get(); }  ///< null: none, or not stated
  /// Range of a joint over which there is something to tabulate: what the session observed, and the tables
  /// that were active; m or rad.
  std::pair<double, double> tabulated(int joint) const;
  /// The calibration corrects this joint somewhere, by more than any machine repeats.
  bool changes(int joint) const { return changes_[joint]; }

  /// Motors minus command, m, one a joint; 0 for rotary ones: adds() and activeAt(). @param command its
  /// `position` are the commanded readings. @throw NumericalError where the model has no finite answer.
  Eigen::VectorXd at(const State& command) const;
  /// The part of it that the calibration adds to the active compensation; beyond the observed range of a
  /// joint, its value at the end.
  Eigen::VectorXd adds(const State& command) const;
  /// What the active compensation adds at a command, m or rad, one a joint.
  Eigen::VectorXd activeAt(const State& command) const;

  /// Where the probe is minus where it was commanded, when the motors stand at `motors` (m, rad): m.
  Eigen::Vector3d missed(const State& command, const std::vector<double>& motors) const;
  /// Model's displacement of the probe from nominal at these readings, as it was measured, m.
  Eigen::Vector3d displacement(const State& state) const;

  /// How uncertain displacement() is by the parameters: three rows a state, a column an independent
  /// combination of the parameters, times its standard deviation, to first order, m.
  Eigen::MatrixXd uncertain(const std::vector<State>& states) const;

  /// Where the tables that were active have points over a joint, m or rad; empty: none.
  std::vector<double> activePoints(int joint) const;
  /// The state as a controller knows it, joints by their letters.
  CommandedState commandOf(const State& state) const;

 private:
  Eigen::Vector3d truePosition(State state,
                               Eigen::Matrix<double, 6, Eigen::Dynamic>* byParameter = nullptr) const;
  Eigen::Vector3d besideNominal(const State& command, std::vector<double> readings) const;
  void checkActive() const;

  Model model_;
  Eigen::VectorXd parameters_;
  Eigen::MatrixXd covariance_;
  std::vector<ExportAxis> axes_;
  std::vector<int> linear_;
  ControllerCompensation compensation_;
  std::shared_ptr<const LoadedCompensation> active_;
  JointPoints activePoints_;
  Eigen::Array<bool, Eigen::Dynamic, 1> changes_;  // a joint
};

/// at(), adds() or activeAt().
using CorrectionPart = Eigen::VectorXd (NeededCorrection::*)(const State& command) const;

}  // namespace mm
