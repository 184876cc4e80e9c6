#include "report/report_positioning.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

struct Sample {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  void add(double value) {  // Welford
    ++count;
    const double delta = value - sum;
    sum += delta / count;
    squares += delta * (value - sum);
  }
  double mean() const { return count > 0 ? sum : kNotMeasured; }
  double deviation() const { return count > 1 ? std::sqrt(squares / (count - 1)) : kNotMeasured; }
};

/// Largest and smallest of what exists.
struct Range {
  double low = kNotMeasured, high = kNotMeasured;
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::isfinite(low) ? std::min(low, value) : value;
    high = std::isfinite(high) ? std::max(high, value) : value;
  }
  double width() const { return high - low; }
};

PositioningFigures figuresOf(const std::vector<PositioningTarget>& targets) {
  PositioningFigures f;
  Range systematic, accuracy, middle, both, up, down;
  double reversal = 0.0, reversals = 0.0;
  int bidirectional = 0;
  bool repeated = true;
  for (const PositioningTarget& t : targets) {
    systematic.add(t.meanForward);
    systematic.add(t.meanBackward);
    accuracy.add(t.meanForward + 2.0 * t.sForward);
    accuracy.add(t.meanForward - 2.0 * t.sForward);
    accuracy.add(t.meanBackward + 2.0 * t.sBackward);
    accuracy.add(t.meanBackward - 2.0 * t.sBackward);
    up.add(4.0 * t.sForward);
    down.add(4.0 * t.sBackward);
    repeated = repeated && (t.forward == 0 || t.forward > 1) && (t.backward == 0 || t.backward > 1);
    if (t.forward == 0 || t.backward == 0) continue;
    const double b = t.meanForward - t.meanBackward;
    middle.add(0.5 * (t.meanForward + t.meanBackward));
    both.add(2.0 * t.sForward + 2.0 * t.sBackward + std::abs(b));
    if (std::abs(b) > std::abs(reversal)) reversal = b;
    reversals += b;
    ++bidirectional;
  }
  f.systematic = systematic.width();
  if (bidirectional > 0) {
    f.meanRange = middle.width();
    f.reversal = reversal;
    f.meanReversal = reversals / bidirectional;
  }
  if (!repeated) return f;  // a single run has no standard deviation
  f.accuracy = accuracy.width();
  f.repeatabilityForward = up.high;
  f.repeatabilityBackward = down.high;
  Range largest;
  for (const double r : {both.high, up.high, down.high}) largest.add(r);
  f.repeatability = largest.high;
  return f;
}

}  // namespace

PositioningTest positioningTest(std::vector<PositioningRun> runs) {
  PositioningTest test;
  std::stable_sort(runs.begin(), runs.end(),
                   [](const PositioningRun& a, const PositioningRun& b) { return a.at < b.at; });
  if (runs.empty()) return test;
  const double tolerance =
      2e-3 * (runs.back().at - runs.front().at);  // a target is reached up to its deviation
  for (std::size_t first = 0; first < runs.size();) {
    Sample forward, backward, place;
    std::size_t i = first;
    for (; i < runs.size() && runs[i].at - runs[first].at <= tolerance; ++i) {
      (runs[i].forward ? forward : backward).add(runs[i].deviation);
      place.add(runs[i].at);
    }
    test.targets.push_back({place.mean(), forward.mean(), backward.mean(), forward.deviation(),
                            backward.deviation(), forward.count, backward.count});
    first = i;
  }
  test.figures = figuresOf(test.targets);
  return test;
}

std::vector<AxisPositioning> axisPositioning(const CalibrationResult& fitted) {
  std::vector<AxisPositioning> axes;
  const Problem& problem = *fitted.problem;
  const std::vector<Joint>& joints = problem.model().machine().joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    AxisPositioning axis;
    axis.axis = joints[j].name;
    axis.rotary = joints[j].kind == JointKind::kRotary;
    const double unit = axis.rotary ? kArcsecond : kMicrometre, place = axis.rotary ? kDegree : kMillimetre;
    for (int row = 0; row < problem.rowCount(); ++row) {
      const ResidualRow& r = problem.rows()[static_cast<std::size_t>(row)];
      const Observation& o = problem.session().observations[static_cast<std::size_t>(r.observation)];
      if (o.kind != ObservationKind::kDeviation || r.component != static_cast<int>(j)) continue;
      if (o.travel[j] == 0.0 || !(fitted.weight[row] > 0.0)) continue;
      axis.runs.push_back({o.position[j] / place, o.deviation[j] / unit, o.travel[j] > 0.0});
      axis.left.push_back({o.position[j] / place, fitted.residuals[row] / unit, o.travel[j] > 0.0});
    }
    axis.measured = positioningTest(axis.runs);
    axis.calibrated = positioningTest(axis.left);
    const auto bothWays = [](const PositioningTarget& t) { return t.forward > 0 && t.backward > 0; };
    if (std::count_if(axis.measured.targets.begin(), axis.measured.targets.end(), bothWays) >= 3)
      axes.push_back(std::move(axis));
  }
  return axes;
}

}  // namespace mm
