#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/model.h"
#include "uncertainty/conformity.h"

namespace mm {

/// A place where the probe is in the course of a task. Frame: workpiece.
struct TaskPoint {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the tip's centre, m
  /// Outward unit normal of the surface that is touched there; zero: the place itself, nothing is touched.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  int axis = -1;      // a joint whose direction of travel the task prescribes; -1: none
  double side = 0.0;  // -1 or +1: that direction
};

/// Name of the probing error among the figures of ISO 10360-2.
inline constexpr const char* kProbingForm = "probing form P";

/// One figure that a task gives.
struct TaskQuantity {
  std::string name;       // "distance", "x", "form"
  double nominal = 0.0;   // m, of a perfect machine and workpiece
  bool oneSided = false;  // a figure that cannot be below its nominal value: form, range, largest error
  double length = 0.0;    // m, of a measured length, on which a permissible error may depend; else 0
};

/// Something that is measured: where it is touched, and how its figures follow from the points found.
struct MeasurementTask {
  using Places = std::vector<Eigen::Vector3d>;
  using Test = std::function<bool(const Places& measured)>;

  std::vector<TaskPoint> points;         // in the order of measuring
  std::vector<TaskQuantity> quantities;  // the first is the headline
  /// @param measured one a point, m, workpiece. @param values one a quantity, m.
  std::function<void(const Places& measured, double* values)> figures;
  /// Whether everything that the task tests is within what is permitted, all at once; empty: no test has
  /// limits of its own.
  Test passes = {};
  std::string text = {};  // as it was asked
};

struct TaskOptions {
  int points = 0;  // that are touched on a ball, circle, plane or line; targets of ISO 230-2; 0: as usual
  std::optional<PermissibleError> permissible;  // of every length of ISO 10360-2
};

/// Makes a task from its words (taskHelp), lengths in mm, frame workpiece. A ball is touched on its upper
/// half. A ball whose radius is not told has that of the balls of the calibration, else 10 mm.
/// @throw InputError naming the part of the text that is wrong, its value and what is expected.
std::unique_ptr<MeasurementTask> makeTask(const std::string& text, const TaskOptions& options,
                                          const Model& model);

/// The words that makeTask knows, as one line a word, for a help text.
std::string taskHelp();

}  // namespace mm
