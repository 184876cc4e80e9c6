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
/// Immutable.
class MeasurementTask {
 public:
  using Places = std::vector<Eigen::Vector3d>;
  using Figures = std::function<void(const Places& measured, double* values)>;
  using Test = std::function<bool(const Places& measured)>;

  /// @param figures, test see evaluate, passes; no test: the task has no limits of its own.
  MeasurementTask(std::vector<TaskPoint> points, std::vector<TaskQuantity> quantities, Figures figures,
                  Test test = {})
      : points_(std::move(points)),
        quantities_(std::move(quantities)),
        figures_(std::move(figures)),
        test_(std::move(test)) {}

  const std::string& text() const { return text_; }                            ///< as it was asked
  const std::vector<TaskPoint>& points() const { return points_; }             ///< in the order of measuring
  const std::vector<TaskQuantity>& quantities() const { return quantities_; }  ///< the first is the headline
  /// @param measured one a point, m, workpiece. @param values one a quantity, m.
  void evaluate(const Places& measured, double* values) const { figures_(measured, values); }
  /// Whether everything that the task tests is within what is permitted, all at once; nothing: no test has
  /// limits of its own.
  std::optional<bool> passes(const Places& measured) const {
    return test_ ? std::optional<bool>(test_(measured)) : std::nullopt;
  }

 private:
  friend std::unique_ptr<MeasurementTask> makeTask(const std::string& text, const struct TaskOptions& options,
                                                   const Model& model);
  std::string text_;
  std::vector<TaskPoint> points_;
  std::vector<TaskQuantity> quantities_;
  Figures figures_;
  Test test_;
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
