#include "uncertainty/positioning_figures.h"

#include <algorithm>
#include <cmath>

#include "base/range.h"

namespace mm {
namespace {

struct RunSample {
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

double widthOf(const Range& range) { return range.any() ? range.size() : kNotMeasured; }
double highestOf(const Range& range) { return range.any() ? range.upper : kNotMeasured; }

/// A, R and E of the directions of approach that are asked. @param spread what else belongs to R.
ApproachFigures figuresOf(const std::vector<PositioningTarget>& targets,
                          std::initializer_list<bool> directions, Range spread) {
  Range means, edges;
  bool repeated = true;
  for (const PositioningTarget& t : targets)
    for (const bool forward : directions) {
      const double mean = forward ? t.meanForward : t.meanBackward, s = forward ? t.sForward : t.sBackward;
      means.add(mean);
      edges.add(mean + 2.0 * s);
      edges.add(mean - 2.0 * s);
      spread.add(4.0 * s);
      repeated = repeated && (forward ? t.forward : t.backward) != 1;
    }
  ApproachFigures out;
  out.systematic = widthOf(means);
  if (!repeated) return out;  // a single run has no standard deviation
  out.accuracy = widthOf(edges);
  out.repeatability = highestOf(spread);
  return out;
}

PositioningFigures figuresOf(const std::vector<PositioningTarget>& targets) {
  PositioningFigures f;
  f.forward = figuresOf(targets, {true}, {});
  f.backward = figuresOf(targets, {false}, {});
  Range middle, spread;
  double reversal = 0.0, reversals = 0.0;
  int bidirectional = 0;
  for (const PositioningTarget& t : targets) {
    if (t.forward == 0 || t.backward == 0) continue;
    const double b = t.meanForward - t.meanBackward;
    middle.add(0.5 * (t.meanForward + t.meanBackward));
    spread.add(2.0 * t.sForward + 2.0 * t.sBackward + std::abs(b));
    reversal = std::max(reversal, std::abs(b));
    reversals += b;
    ++bidirectional;
  }
  if (bidirectional > 0) {
    f.meanRange = widthOf(middle);
    f.reversal = reversal;
    f.meanReversal = reversals / bidirectional;
  }
  static_cast<ApproachFigures&>(f) = figuresOf(targets, {true, false}, spread);
  return f;
}

/// By the slope of each figure along each mean and each standard deviation: a largest value
/// follows one of them, or each by half where some are as large.
PositioningFigures stdOf(std::vector<PositioningTarget> targets) {
  PositioningFigures figures = figuresOf(targets), variances;
  for (double* variance : eachFigure(variances)) *variance = 0.0;
  const auto vary = [&](double& value, double variance) {
    const double here = value, step = 1e-6 * std::max(1.0, std::abs(here));
    value = here + step;
    PositioningFigures above = figuresOf(targets);
    value = here - step;
    PositioningFigures below = figuresOf(targets);
    value = here;
    const auto at = eachFigure(figures), up = eachFigure(above), down = eachFigure(below),
               of = eachFigure(variances);
    for (std::size_t k = 0; k < of.size(); ++k) {
      const double slope = (std::abs(*up[k] - *at[k]) + std::abs(*down[k] - *at[k])) / (2.0 * step);
      if (std::isfinite(slope) && slope != 0.0) *of[k] += slope * slope * variance;
    }
  };
  for (PositioningTarget& t : targets)
    for (const bool forward : {true, false}) {
      const int runs = forward ? t.forward : t.backward;
      double& s = forward ? t.sForward : t.sBackward;
      if (runs > 0) vary(forward ? t.meanForward : t.meanBackward, s * s / runs);
      if (runs > 1) vary(s, s * s / (2.0 * (runs - 1)));
    }
  const auto of = eachFigure(variances), figure = eachFigure(figures);
  for (std::size_t k = 0; k < of.size(); ++k)
    *of[k] = std::isfinite(*figure[k]) ? std::sqrt(*of[k]) : *figure[k];
  return variances;
}

}  // namespace

std::array<double*, 12> eachFigure(PositioningFigures& f) {
  return {&f.accuracy,
          &f.forward.accuracy,
          &f.backward.accuracy,
          &f.repeatability,
          &f.forward.repeatability,
          &f.backward.repeatability,
          &f.systematic,
          &f.forward.systematic,
          &f.backward.systematic,
          &f.meanRange,
          &f.reversal,
          &f.meanReversal};
}

PositioningTest positioningTest(std::vector<PositioningRun> runs) {
  PositioningTest test;
  std::stable_sort(runs.begin(), runs.end(),
                   [](const PositioningRun& a, const PositioningRun& b) { return a.at < b.at; });
  if (runs.empty()) return test;
  const double tolerance = kSameTarget * (runs.back().at - runs.front().at);
  for (std::size_t first = 0; first < runs.size();) {
    RunSample forward, backward, place;
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
  test.std = stdOf(test.targets);
  return test;
}

}  // namespace mm
