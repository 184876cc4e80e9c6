#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/random.h"
#include "calibration_file/calibration.h"
#include "compensation/compensator.h"
#include "session/session.h"
#include "uncertainty/found_remainder.h"
#include "uncertainty/measurement_task.h"

namespace mm {

/// Where and when a task is measured. SI units, degC.
struct TaskConditions {
  struct Temperature {
    std::string sensor;
    double value = 0.0;  // degC
    double std = 0.0;    // K, of the value
  };
  struct JointValue {
    std::string joint;
    double value = 0.0;  // rad, m, or a direction of travel
  };
  std::vector<Temperature> temperatures;  // others: the middle of their calibrated range
  std::vector<JointValue> positions;      // of joints that the task does not move, rotary ones first of all
  std::vector<JointValue> travel;         // -1 or +1 where no contact tells it; others: +1
  Eigen::Vector3d approach =
      Eigen::Vector3d::Zero();            // at points without a surface; zero: nothing is touched
  double time = kNotMeasured;             // s, on the clock of the calibrated session; NaN: its end
  double interval = 5.0;                  // s from point to point
  double contactSpeed = 2e-3;             // m/s
  double margin = 0.10;                   // as Compensator::Options
  double repeatability = -1.0;            // m, of a coordinate of a point; negative: that of the calibration
  double artifactScale = 0.0;             // standard uncertainty of the artifact's scale, 1 (um/m = 1e-6)
  double artifactRadius = 0.0;            // m, of the radius of the ball on which the tip was qualified
  double remainderLength = kNotMeasured;  // m, over which it changes; NaN: a quarter of the volume's diagonal
  /// As residuals show it; empty: alike in every direction, half of it smooth, by its size alone.
  std::optional<Remainder> remainder;
};

/// Over how many m the unexplained remainder changes where nothing else is said: a quarter of the diagonal of
/// the calibrated volume.
double usualRemainderLength(const Domain& domain);

/// Machines that a calibration holds possible, measuring one task: its parameters vary by their joint
/// distribution, and with them drift, remainder, probe, artifact and temperatures. Immutable; `draw` may be
/// called from several threads.
///
/// A measured point is wrong by what the correction with the calibrated values differs from that with the
/// values of a drawn machine, at the readings that lead to the point, and by the other causes
/// (docs/uncertainty.md).
class VirtualMachine {
 public:
  /// Buffers of one thread.
  struct Workspace {
    Model::Workspace model;
    Eigen::VectorXd normal, shift, parameters;
    Eigen::MatrixXd field;
  };

  /// @throw InputError: unknown sensor or joint; a state in which the model has no answer (an input that is
  /// not known), with the reason.
  VirtualMachine(const Calibration& calibration, const MeasurementTask& task,
                 const TaskConditions& conditions);
  VirtualMachine(const VirtualMachine&) = delete;  // its history refers to its temperatures
  VirtualMachine& operator=(const VirtualMachine&) = delete;

  /// What makes a measurement uncertain: independent of each other, for people ("squareness of y to x").
  const std::vector<std::string>& sources() const { return names_; }
  /// One line a reason for which the calibration does not hold at a point; empty: it holds.
  const std::vector<std::string>& outside() const { return outside_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// Errors of one measurement of the task, a point each: measured minus true, m, workpiece.
  /// @param only the index of a source that acts alone; -1: all act.
  void draw(Random& random, int only, Workspace& work, std::vector<Eigen::Vector3d>& errors) const;

 private:
  /// kCommon: one number for all points, as the scale of the artifact or a temperature.
  enum class Cause { kParameters, kDrift, kRemainder, kProbe, kCommon };
  struct Source {
    Cause cause;
    double std = 0.0;             // m, 1 or K, by the cause
    Eigen::Matrix3Xd along = {};  // by point: of a drift (1 or m/rad), of what is common to all (m/K, …)
    double tau = 0.0;             // s, of a drift
    bool smooth = false;          // of a drift: Matern 3/2, else an Ornstein-Uhlenbeck process
  };
  struct Point {
    State state;
    Eigen::Vector3d place, normal, calibrated;  // calibrated: as errorOf, at the calibrated values
    Eigen::Matrix3Xd byParameter;               // of errorOf
  };
  void place(const Calibration& calibration, const MeasurementTask& task, const TaskConditions& conditions);
  void addParameters(const Calibration& calibration);
  void addDrift(const Calibration& calibration);
  void addRemainder(const Calibration& calibration, const TaskConditions& conditions);
  Remainder remainderBySize(const Calibration& calibration, double length) const;
  void addTemperatures(const TaskConditions& conditions);
  State blank(const TaskConditions& conditions);
  void add(std::string name, Source source);
  /// A column of Source::along a point.
  template <typename Of>
  Eigen::Matrix3Xd byPoint(Of of) const {
    Eigen::Matrix3Xd along(3, points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) along.col(i) = of(points_[i]);
    return along;
  }
  /// Where the tip, or the surface that it touches, is taken to be: corrected position less the effective
  /// radius's error along the normal.
  Eigen::Vector3d seen(const Point& point, const double* parameters, Model::Workspace& work) const;
  void drawParameters(Random& random, int only, Workspace& work, std::vector<Eigen::Vector3d>& errors) const;
  void drawRemainder(Random& random, Workspace& work, std::vector<Eigen::Vector3d>& errors) const;

  Compensator compensator_;
  std::unique_ptr<const TemperatureHistory> history_;
  std::vector<double> temperature_;
  std::vector<Point> points_;
  std::vector<std::string> names_, outside_, notes_;
  std::vector<Source> sources_;
  Eigen::VectorXd values_;
  Eigen::MatrixXd root_;       // of the covariance: D P^1/2
  std::vector<int> sourceOf_;  // a parameter; -1: it is held
  double freedoms_ = 0.0;      // of the parameters' distribution; 0: normal
  bool linear_ = true;
  double interval_ = 0.0;
  Remainder remainder_;
  Eigen::MatrixXd smooth_;  // Cholesky factor of the correlation of the remainder between points
};

}  // namespace mm
