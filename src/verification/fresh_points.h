#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "estimation/residual_space.h"
#include "session/session.h"
#include "verification/loaded_export.h"

namespace mm {

/// A table that is loaded for another linear axis, and is entered by that axis's position and direction.
struct MisplacedTable {
  int of = 0, on = 0;      // of FreshPoints::axes()
  Eigen::VectorXd column;  // length rows: what the table says, as an error of the axis `on`
};

/// What the points of a fresh session could show of a calibration's correction: the residuals of the raw
/// readings, and a column for each way in which the correction enters them. The effects of the probe and of
/// the artifact are applied throughout with the calibration's values: no controller corrects them. Rows are
/// whitened by the stated noise of each residual, priors follow them; a column is what has to be explained
/// (minus the residual) where the machine has that error and nobody corrects it.
class FreshPoints {
 public:
  /// Linearises where the machine's effects are `factor` of the calibration's values, which should be near
  /// to what the readings show. @param session, calibration, exported must outlive it. @param weights a data
  /// row: 0 leaves it out; empty: all. @param exported what the controller adds where it was given less than
  /// the whole correction; null: all of it. @throw InputError: another machine; the calibration corrects
  /// nothing of the machine, or neither tables nor offsets add anything at these points. NumericalError: too
  /// few points.
  FreshPoints(const Session& session, const Calibration& calibration, const CalibrateOptions& options,
              int factor, const Eigen::VectorXd& weights = {}, const LoadedExport* exported = nullptr);

  const CalibrationResult& fitted() const { return *fitted_; }  ///< at the factor
  const ResidualSpace& space() const { return *space_; }        ///< of `fitted`
  int rows() const { return space_->rows(); }                   ///< residuals in use
  const ResidualRow& row(int i) const { return fitted_->problem->rows()[space_->used()[i]]; }  ///< of these
  bool angular() const;                                                      ///< none of these is in m
  int length() const { return space_->length(); }                            ///< rows and priors
  const std::vector<std::string>& axes() const { return axes_; }             ///< joints that are corrected
  int axisCount() const { return axes_.size(); }                             ///< their number
  const std::vector<EffectPtr>& effects() const { return machineEffects_; }  ///< of the machine
  const std::vector<int>& indices() const { return indices_; }               ///< of these in the calibration

  const Eigen::VectorXd& raw() const { return raw_; }            ///< to be explained: the machine uncorrected
  const Eigen::MatrixXd& byEffect() const { return byEffect_; }  ///< each effect at its calibrated size
  Eigen::VectorXd whole() const { return byEffect_.rowwise().sum(); }      ///< all of them
  bool tabled() const { return exported_ != nullptr; }                     ///< tables were named
  bool hasOffsets() const { return tabled() && exported_->hasOffsets(); }  ///< external offsets were named
  /// What the external offsets say, of all axes together; 0 where there are none.
  const Eigen::VectorXd& offsets() const { return offsets_; }
  /// What nothing corrects: of the whole correction, beyond that of every axis and of the offsets.
  Eigen::VectorXd rest() const;
  /// Column a * axes + b: what the calibration (where tables were named: they) says of axis b, as an error of
  /// axis a.
  const Eigen::MatrixXd& crossed() const { return crossed_; }
  /// What it says of an axis as an error of the same one.
  Eigen::VectorXd own(int axis) const { return crossed_.col(axis * axisCount() + axis); }
  const std::vector<MisplacedTable>& misplaced() const { return misplaced_; }  ///< of every pair of axes
  /// By each parameter of the machine's effects, per SI unit.
  const Eigen::MatrixXd& byParameter() const { return byParameter_; }
  const std::vector<int>& parameters() const { return parameters_; }  ///< of these in the calibration
  /// What a machine can become that no effect of the calibration says: each axis by each axis's position
  /// and by its own direction of travel; every column as large as `share` of the whole correction.
  const Eigen::MatrixXd& shapes() const { return shapes_; }
  /// What the effects of the probe and the artifact do, where they can be left out; length rows.
  const Eigen::VectorXd& measuring() const { return measuring_; }

 private:
  void sort(const Calibration& calibration, const Model& whole);
  void fit(const Session& session, const Calibration& calibration, CalibrateOptions options, int factor,
           const Eigen::VectorXd& weights);
  void fillColumns(const Calibration& calibration);
  /// Columns of the data rows as they enter: whitened, with nothing where the session's unknowns take them.
  Eigen::MatrixXd entered(const Eigen::MatrixXd& columns) const;
  void fillAxes(const Eigen::MatrixXd& change);
  /// The error of each joint that the correction takes away at a state. @param values of the machine's
  /// effects.
  Eigen::VectorXd takenAway(const State& state, const std::vector<std::vector<double>>& values) const;
  void fillMisplaced(const std::vector<std::vector<double>>& values);
  void fillShapes();

  /// A column of what the external offsets say. @return whether they add anything.
  bool fillOffsets();

  const LoadedExport* exported_;
  std::unique_ptr<CalibrationResult> fitted_;
  std::unique_ptr<ResidualSpace> space_;
  std::vector<EffectPtr> machineEffects_, measuringEffects_;
  std::vector<int> indices_, measuringIndices_, parameters_;
  std::vector<int> axisJoints_;
  std::vector<std::string> axes_;
  Eigen::VectorXd raw_, measuring_, offsets_;
  Eigen::MatrixXd byEffect_, crossed_, byParameter_, shapes_;
  std::vector<MisplacedTable> misplaced_;
};

}  // namespace mm
