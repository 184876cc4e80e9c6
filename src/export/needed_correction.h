#pragma once
#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "export/export_axes.h"
#include "interpreters/interpreter.h"
#include "model/model.h"

namespace mm {

/// What a calibration asks of the motors: where they must stand so that the probe is where its user commands
/// it. Linear joints move, rotary ones stay. Nothing is touched and the machine stands still, so that effects
/// of the contact and of the speed say nothing here; temperatures have settled. SI units, frame workpiece.
class NeededCorrection {
 public:
  /// @throw InputError: the calibration contradicts itself (as Compensator), or exportAxes refuses the
  /// machine.
  NeededCorrection(const Calibration& calibration, const std::map<std::string, std::string>& letters);

  const Model& model() const { return model_; }
  const std::vector<ExportAxis>& axes() const { return axes_; }  ///< in the order of the joints
  const std::vector<int>& linear() const { return linear_; }     ///< joints that move
  const ExportAxis* findAxis(const std::string& letter) const;   ///< null: none
  /// A joint moved during the session, so that there is something to tabulate over it.
  bool moved(int joint) const;
  /// The reading at which tables are zero: 0, or the end of the observed range that is nearest to it.
  double reference(int joint) const;

  /// `count` states that fill the calibrated volume, temperatures, covariates and duration evenly (a Latin
  /// hypercube), with either direction of travel of every joint equally often. The same for the same seed.
  std::vector<State> states(int count, unsigned seed) const;

  /// Motors minus command, m, one a joint; 0 for rotary ones. @param command its `position` are the commanded
  /// readings. @throw NumericalError where the model has no finite answer.
  Eigen::VectorXd at(const State& command) const;

  /// Where the probe is minus where it was commanded, when the motors stand at `motors` (m, rad): m.
  Eigen::Vector3d missed(const State& command, const std::vector<double>& motors) const;
  /// Model's displacement of the probe from nominal at these readings, m.
  Eigen::Vector3d displacement(const State& state) const { return missed(state, state.position); }

  /// The state as a controller knows it, joints by their letters.
  CommandedState commandOf(const State& state) const;

 private:
  Eigen::Vector3d truePosition(State state) const;

  Model model_;
  Eigen::VectorXd parameters_;
  std::vector<ExportAxis> axes_;
  std::vector<int> linear_;
};

}  // namespace mm
