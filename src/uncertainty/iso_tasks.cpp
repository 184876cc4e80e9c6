// The tests of the standards as tasks: what they would find on a machine that is corrected.
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/units.h"
#include "session/test_targets.h"
#include "uncertainty/fitted_feature.h"
#include "uncertainty/positioning_figures.h"
#include "uncertainty/task_shapes.h"

namespace mm {
namespace {

constexpr int kLengths = 5, kRepeats = 3;  // ISO 10360-2: five lengths, three times, in seven positions
constexpr int kRuns = 5;                   // ISO 230-2, 5.3
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

/// What ISO 10360-2 measures: bidirectional lengths; with them a ball, for the probing error (ISO 10360-5).
struct LengthTest {
  using Places = MeasurementTask::Places;

  /// m, of one of the repeats of a length.
  double errorOf(const Places& measured, std::size_t length, std::size_t repeat) const {
    const std::size_t at = 2 * (length * kRepeats + repeat);
    return (measured[at + 1] - measured[at]).dot(along[length]) - nominal[length];
  }
  /// The largest error, that of the ball, the first of the repeats of every length.
  void figures(const Places& measured, double* values) const {
    double& largest = *values++ = 0.0;
    if (ball) *values++ = ball->fit(measured, firstOfBall).form;
    for (std::size_t l = 0; l < along.size(); ++l)
      for (std::size_t r = 0; r < kRepeats; ++r) {
        const double error = errorOf(measured, l, r);
        if (r == 0) *values++ = nominal[l] + error;
        largest = std::max(largest, std::abs(error));
      }
  }
  /// The test asks it of every length, each time that it is measured (ISO 10360-2, 8.1). Here without the
  /// repetitions that the standard allows where single values are beyond: what passes here passes there.
  bool passes(const Places& measured, const PermissibleError& permissible) const {
    for (std::size_t l = 0; l < along.size(); ++l) {
      const double most = permissible.at(nominal[l] / kMillimetre) * kMicrometre;
      for (std::size_t r = 0; r < kRepeats; ++r)
        if (std::abs(errorOf(measured, l, r)) > most) return false;
    }
    return true;
  }

  std::vector<Eigen::Vector3d> along;
  std::vector<double> nominal;  // m
  std::optional<FittedFeature> ball;
  std::size_t firstOfBall = 0;  // among the points
};

}  // namespace

MeasurementTask lengthTestTask(const Model& model, const std::optional<PermissibleError>& permissible) {
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
  LengthTest test;
  std::vector<TaskPoint> points;
  std::vector<TaskQuantity> quantities = {{"largest |E|", 0.0, true, 0.0}};
  if (room) quantities.push_back({kProbingForm, 0.0, true, 0.0});
  for (const TestLine& line : lines) {
    const Eigen::Vector3d way = (line.to - line.from).normalized();
    for (int i = 1; i <= kLengths; ++i) {
      const Eigen::Vector3d end = line.from + (line.to - line.from) * (static_cast<double>(i) / kLengths);
      const double length = (end - line.from).norm();
      quantities.push_back({format("%.4g mm, ", length / kMillimetre) + line.name, length, false, length});
      test.along.push_back(way);
      test.nominal.push_back(length);
      for (int r = 0; r < kRepeats; ++r) {
        points.push_back({line.from, -way, -1, 0.0});
        points.push_back({end, way, -1, 0.0});
      }
    }
  }
  test.firstOfBall = points.size();
  if (room) {
    const Eigen::Vector3d middle = 0.5 * (domain.tipLower + domain.tipUpper);
    const std::vector<TaskPoint> ball = ballPoints(middle, radius, kProbingContacts);
    test.ball.emplace(FittedFeature::Kind::kSphere, middle, Eigen::Vector3d::UnitZ(), radius, placesOf(ball));
    points.insert(points.end(), ball.begin(), ball.end());
  }
  MeasurementTask::Test passes;
  if (permissible)
    passes = [test, permissible](const auto& measured) { return test.passes(measured, *permissible); };
  return {std::move(points), std::move(quantities),
          [test](const auto& measured, double* values) { test.figures(measured, values); }, passes};
}

MeasurementTask positioningTask(const std::string& axis, int targets, const Model& model) {
  const Domain& domain = model.domain();
  const int joint = domain.findJoint(axis);
  std::vector<std::string> names;
  for (const Joint& j : domain.joints)
    if (j.kind == JointKind::kLinear) names.push_back(j.name);
  const std::string task = "--task 'iso230-2:" + axis + "': ";
  if (joint < 0 || domain.joints[joint].kind != JointKind::kLinear)
    throw InputError(task + "'" + axis + "' is not a linear axis of this machine; it has " + listOf(names));
  std::vector<double> q;
  for (std::size_t j = 0; j < domain.joints.size(); ++j)
    q.push_back(0.5 * (domain.lower[j] + domain.upper[j]));
  const double range = domain.upper[joint] - domain.lower[joint];
  if (!(range >= kShortestLine))
    throw InputError(task +
                     format("it was calibrated over %.3g mm, which is too short; 1 mm or more is needed",
                            range / kMillimetre));
  const int least = fewestTargets(range);
  if (targets != 0 && targets < least)
    throw InputError(task + format("--points %d is fewer than the five targets per metre of ISO 230-2: %d",
                                   targets, least));
  const std::vector<double> targetsAt =
      shiftedTargets(targets == 0 ? least : targets, (1.0 - 2.0 * kInset) * range);
  const double beam = domain.laser ? 0.5 * (domain.readingLower + domain.readingUpper) : kNotMeasured;
  const Eigen::Vector3d middle = model.machine().nominal(q.data(), beam).position,
                        way = model.machine().jacobian(q.data(), beam).block<3, 1>(0, joint);
  std::vector<TaskPoint> points;
  std::vector<double> at;  // mm
  for (int run = 0; run < kRuns; ++run)
    for (const bool up : {true, false})
      for (std::size_t i = 0; i < targetsAt.size(); ++i) {
        const double target = up ? targetsAt[i] : targetsAt[targetsAt.size() - 1 - i];
        points.push_back({middle + target * way, {0, 0, 0}, joint, up ? 1.0 : -1.0});
        at.push_back(target / kMillimetre);
      }
  std::vector<TaskQuantity> quantities;  // the figures of ISO 230-2, section 3
  for (const char* name : {"accuracy A", "repeatability R", "systematic E", "reversal B", "mean range M"})
    quantities.push_back({name, 0.0, true, 0.0});
  const auto figures = [points, at, way](const MeasurementTask::Places& measured, double* values) {
    std::vector<PositioningRun> runs(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)  // it stops where it is measured to be at the target
      runs[i] = {at[i], (points[i].place - measured[i]).dot(way) / kMicrometre, points[i].side > 0.0};
    const PositioningFigures f = positioningTest(std::move(runs)).figures;
    for (const double figure : {f.accuracy, f.repeatability, f.systematic, f.reversal, f.meanRange})
      *values++ = figure * kMicrometre;
  };
  return {points, std::move(quantities), figures};
}

}  // namespace mm
