// The tests of the standards as tasks: what they would find on a machine that is corrected.
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/units.h"
#include "uncertainty/fitted_feature.h"
#include "uncertainty/positioning_figures.h"
#include "uncertainty/task_shapes.h"

namespace mm {
namespace {

constexpr int kLengths = 5, kRepeats = 3;  // ISO 10360-2: five lengths, three times, in seven positions
constexpr int kTargets = 5, kRuns = 5;     // ISO 230-2, 5.3, axes up to 2 m: five targets a metre and runs
constexpr double kShift = 0.3;             // of an interval at most, of a target
constexpr double kInset = 0.02;            // of a range, from its ends
constexpr double kShortestLine = 1.0 * kMillimetre;
constexpr int kProbingContacts = 25;

struct TestLine {
  std::string name;
  Eigen::Vector3d from, to;  // m
};

/// Body diagonals of the calibrated volume, and lines along its sides through the middle.
std::vector<TestLine> linesOf(const Domain& domain) {
  const Eigen::Vector3d size = domain.tipUpper - domain.tipLower,
                        middle = 0.5 * (domain.tipUpper + domain.tipLower);
  std::vector<TestLine> lines;
  const auto add = [&](const std::string& name, const Eigen::Vector3d& way) {
    const Eigen::Vector3d half = (0.5 - kInset) * size.cwiseProduct(way);
    if (2.0 * half.norm() >= kShortestLine) lines.push_back({name, middle - half, middle + half});
  };
  const bool space = size.minCoeff() >= kShortestLine;
  for (int k = 0; space && k < 4; ++k) {
    const Eigen::Vector3d way(1.0, (k & 1) != 0 ? -1.0 : 1.0, (k & 2) != 0 ? -1.0 : 1.0);
    add(format("diagonal +%c%c", way[1] > 0 ? '+' : '-', way[2] > 0 ? '+' : '-'), way);
  }
  for (int k = 0; k < 3; ++k) add(std::string(1, "xyz"[k]), Eigen::Vector3d::Unit(k));
  return lines;
}

/// ISO 10360-2: bidirectional lengths; with it a ball, for the probing error (ISO 10360-5).
class LengthTest : public MeasurementTask {
 public:
  /// @param radius m, of the ball; 0: none, as the volume has no room for one.
  LengthTest(const std::vector<TestLine>& lines, const Eigen::Vector3d& middle, double radius,
             std::optional<PermissibleError> permissible)
      : permissible_(std::move(permissible)) {
    quantities_ = {{"largest |E|", 0.0, true, 0.0}};
    if (radius > 0.0) quantities_.push_back({kProbingForm, 0.0, true, 0.0});
    first_ = quantities_.size();
    for (const TestLine& line : lines) {
      const Eigen::Vector3d way = (line.to - line.from).normalized();
      for (int i = 1; i <= kLengths; ++i) {
        const Eigen::Vector3d end = line.from + (line.to - line.from) * (static_cast<double>(i) / kLengths);
        const double length = (end - line.from).norm();
        quantities_.push_back({format("%.4g mm, ", length / kMillimetre) + line.name, length, false, length});
        along_.push_back(way);
        for (int r = 0; r < kRepeats; ++r) {
          points_.push_back({line.from, -way, -1, 0.0});
          points_.push_back({end, way, -1, 0.0});
        }
      }
    }
    firstOfBall_ = points_.size();
    if (!(radius > 0.0)) return;
    const std::vector<TaskPoint> ball = ballPoints(middle, radius, kProbingContacts);
    ball_.emplace(FittedFeature::Kind::kSphere, middle, Eigen::Vector3d::UnitZ(), radius, placesOf(ball));
    points_.insert(points_.end(), ball.begin(), ball.end());
  }
  void evaluate(const std::vector<Eigen::Vector3d>& measured, double* values) const override {
    double largest = 0.0;
    for (std::size_t l = 0; l < along_.size(); ++l)
      for (std::size_t r = 0; r < kRepeats; ++r) {
        const double error = errorOf(measured, l, r);
        if (r == 0) values[first_ + l] = quantities_[first_ + l].nominal + error;
        largest = std::max(largest, std::abs(error));
      }
    values[0] = largest;
    if (ball_) values[1] = ball_->fit(measured, firstOfBall_).form;
  }
  /// The test asks it of every length, each time that it is measured (ISO 10360-2, 8.1). Here without the
  /// repetitions that the standard allows where single values are beyond: what passes here passes there.
  std::optional<bool> passes(const std::vector<Eigen::Vector3d>& measured) const override {
    if (!permissible_) return std::nullopt;
    for (std::size_t l = 0; l < along_.size(); ++l) {
      const double most = permissible_->at(quantities_[first_ + l].length / kMillimetre) * kMicrometre;
      for (std::size_t r = 0; r < kRepeats; ++r)
        if (std::abs(errorOf(measured, l, r)) > most) return false;
    }
    return true;
  }

 private:
  /// m, of one of the repeats of a length.
  double errorOf(const std::vector<Eigen::Vector3d>& measured, std::size_t length, std::size_t repeat) const {
    const std::size_t first = 2 * (length * kRepeats + repeat);
    return (measured[first + 1] - measured[first]).dot(along_[length]) - quantities_[first_ + length].nominal;
  }

  std::optional<PermissibleError> permissible_;
  std::vector<Eigen::Vector3d> along_;
  std::size_t first_ = 1, firstOfBall_ = 0;  // of the lengths among the figures; of the ball's points
  std::optional<FittedFeature> ball_;
};

class PositioningOfAxis : public MeasurementTask {
 public:
  PositioningOfAxis(int joint, const Eigen::Vector3d& middle, const Eigen::Vector3d& way,
                    const std::vector<double>& targets)
      : way_(way) {
    // The figures of ISO 230-2, section 3.
    for (const char* name : {"accuracy A", "repeatability R", "systematic E", "reversal B", "mean range M"})
      quantities_.push_back({name, 0.0, true, 0.0});
    for (int run = 0; run < kRuns; ++run)
      for (const bool up : {true, false})
        for (std::size_t i = 0; i < targets.size(); ++i) {
          const double at = up ? targets[i] : targets[targets.size() - 1 - i];
          points_.push_back({middle + at * way, {0, 0, 0}, joint, up ? 1.0 : -1.0});
          at_.push_back(at / kMillimetre);
        }
  }
  void evaluate(const std::vector<Eigen::Vector3d>& measured, double* values) const override {
    std::vector<PositioningRun> runs(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i)  // it stops where it is measured to be at the target
      runs[i] = {at_[i], (points_[i].place - measured[i]).dot(way_) / kMicrometre, points_[i].side > 0.0};
    const PositioningFigures f = positioningTest(std::move(runs)).figures;
    const double figures[] = {f.accuracy, f.repeatability, f.systematic, f.reversal, f.meanRange};
    for (int k = 0; k < 5; ++k) values[k] = figures[k] * kMicrometre;
  }

 private:
  Eigen::Vector3d way_;
  std::vector<double> at_;
};

/// Targets over a span about zero, each a part of an interval beside equal spacing, lest the period of a
/// screw or of a scale is met at one phase only (ISO 230-2, 5.3: (i - 1) p + r).
std::vector<double> shiftedTargets(int count, double span) {
  const double interval = span / (count - 1 + kShift);
  std::vector<double> at;
  for (int i = 0; i < count; ++i) {
    const double part = std::fmod(i * 0.618033988749895, 1.0);  // no two alike, and evenly spread
    at.push_back(interval * (i + kShift * part) - 0.5 * span);
  }
  return at;
}

}  // namespace

std::unique_ptr<MeasurementTask> lengthTestTask(const Model& model,
                                                const std::optional<PermissibleError>& permissible) {
  const Domain& domain = model.domain();
  const std::vector<TestLine> lines = linesOf(domain);
  if (lines.empty())
    throw InputError(
        format("--task 'iso10360-2': the calibrated volume is %.3g x %.3g x %.3g mm; a side must be 1 mm "
               "or longer: calibrate over a larger volume",
               (domain.tipUpper - domain.tipLower).x() / kMillimetre,
               (domain.tipUpper - domain.tipLower).y() / kMillimetre,
               (domain.tipUpper - domain.tipLower).z() / kMillimetre));
  // A ball needs contacts, and room on every side.
  const double radius = usualBallRadius(domain);
  const bool room =
      !domain.features.empty() && (domain.tipUpper - domain.tipLower).minCoeff() >= 2.0 * radius;
  return std::make_unique<LengthTest>(lines, 0.5 * (domain.tipLower + domain.tipUpper), room ? radius : 0.0,
                                      permissible);
}

std::unique_ptr<MeasurementTask> positioningTask(const std::string& axis, int targets, const Model& model) {
  const Domain& domain = model.domain();
  const int joint = domain.findJoint(axis);
  std::vector<std::string> names;
  for (const Joint& j : domain.joints)
    if (j.kind == JointKind::kLinear) names.push_back(j.name);
  const std::string task = "--task 'iso230-2:" + axis + "': ";
  if (joint < 0 || domain.joints[static_cast<std::size_t>(joint)].kind != JointKind::kLinear)
    throw InputError(task + "'" + axis + "' is no linear axis of this machine; it has " + listOf(names));
  std::vector<double> q;
  for (std::size_t j = 0; j < domain.joints.size(); ++j)
    q.push_back(0.5 * (domain.lower[j] + domain.upper[j]));
  const auto j = static_cast<std::size_t>(joint);
  const double range = domain.upper[j] - domain.lower[j];
  if (!(range >= kShortestLine))
    throw InputError(task +
                     format("it was calibrated over %.3g mm, which is no travel; 1 mm or more is needed",
                            range / kMillimetre));
  const int least = std::max(kTargets, static_cast<int>(std::ceil(kTargets * range)));
  if (targets != 0 && targets < least)
    throw InputError(
        task + format("--points %d is fewer than the five targets a metre of ISO 230-2: %d", targets, least));
  const std::vector<double> at = shiftedTargets(targets == 0 ? least : targets, (1.0 - 2.0 * kInset) * range);
  const double beam = domain.laser ? 0.5 * (domain.readingLower + domain.readingUpper) : kNotMeasured;
  return std::make_unique<PositioningOfAxis>(joint, model.machine().nominal(q.data(), beam).position,
                                             model.machine().jacobian(q.data(), beam).block<3, 1>(0, joint),
                                             at);
}

}  // namespace mm
