// The tests of ISO 230-2, -4, -6, -7 and ISO 10360-2: readings at places.
#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "session/plan_test_sheet.h"

namespace mm {
namespace {

constexpr double kStandoff = 0.1;  // m from where a beam's lengths begin to its first target
constexpr int kGaugeLengths = 5;   // ISO 10360-2

/// Positions up and down, each end reached from beyond it. @param at readings at a share of the way.
template <typename At, typename Read>
void upAndDown(TestSheet& t, double beyond, const At& at, const Read& read) {
  const double last = t.size.positions - 1.0;
  t.script.repeat(t.size.runs, [&] {
    t.script.go(at(-beyond));
    for (int k = 0; k < t.size.positions; ++k) read(at(k / last));
    t.script.go(at(1.0 + beyond));
    for (int k = t.size.positions - 1; k >= 0; --k) read(at(k / last));
  });
}

/// A straight line of the tip, every joint going evenly.
struct BeamLine {
  std::string name;
  PlanScript::Readings from, to;
  PlanScript::Readings at(double share) const {
    PlanScript::Readings q = from;
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += share * (to[j] - from[j]);
    return q;
  }
};

/// @param signs by which each axis goes along the line, 0: it stands in the middle.
BeamLine beamLine(const TestSheet& t, const std::vector<int>& axes, const std::vector<int>& signs) {
  BeamLine line{"", t.middle, t.middle};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (signs[i] == 0) continue;
    const Stretch s = stretchOf(t, axes[i]);
    const auto j = static_cast<std::size_t>(axes[i]);
    line.from[j] = signs[i] > 0 ? s.from : s.to;
    line.to[j] = signs[i] > 0 ? s.to : s.from;
    line.name += (signs[i] > 0 ? "+" : "-") + t.joint(axes[i]).name;
  }
  return line;
}

const std::vector<std::vector<int>> kBodyDiagonals = {{1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};
const std::vector<std::vector<int>> kFaceDiagonals = {{1, 1, 0},  {1, -1, 0}, {0, 1, 1},
                                                      {0, 1, -1}, {1, 0, 1},  {-1, 0, 1}};
const std::vector<std::vector<int>> kAlongAxes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// The point, on the line drawn out, from which its lengths count.
int beamOf(TestSheet& t, const BeamLine& line) {
  const auto tip = [&](const PlanScript::Readings& q) {
    return t.machine.nominal(q.data(), kNotMeasured).position;
  };
  const Eigen::Vector3d from = tip(line.from), way = (tip(line.to) - from).normalized();
  return t.script.addPoint(line.name, from - kStandoff * way);
}

/// Share of a line by which the joints go beyond its ends.
double beyondOf(const TestSheet& t, const BeamLine& line) {
  double share = INFINITY;
  for (std::size_t j = 0; j < line.from.size(); ++j)
    if (line.to[j] != line.from[j])
      share = std::min(share, t.beyond(static_cast<int>(j)) / std::abs(line.to[j] - line.from[j]));
  return share;
}

}  // namespace

void writePositioning(TestSheet& t) {
  std::string at;
  for (int j = 0; j < t.machine.jointCount(); ++j)
    at += (j > 0 ? ", " : "") + t.joint(j).name + "_" + readingUnit(t.joint(j)).symbol +
          format(": %.9g", t.middle[static_cast<std::size_t>(j)] / t.unit(j));
  t.head +=
      format("approach: {overrun_mm: %.3g, overrun_deg: %.3g}\nreference:\n", kBeyondStretch, kBeyondStretch);
  for (int j = 0; j < t.machine.jointCount(); ++j) {
    const Stretch s = stretchOf(t, j);
    const char* symbol = readingUnit(t.joint(j)).symbol;
    t.head +=
        "  - {joint: " + t.joint(j).name +
        format(", from_%s: %.6g, to_%s: %.6g, points: %d, runs: %d, dwell_s: %.3g", symbol,
               s.from / t.unit(j), symbol, s.to / t.unit(j), t.size.positions, t.size.runs, kTestDwell) +
        ", setup: " + t.joint(j).name + ", at: {" + at + "}}\n";
  }
}

void writeCircular(TestSheet& t) {
  const std::vector<int> axes = t.spatialJoints(2);
  const std::size_t planes = axes.size() == 3 ? 3 : 1;
  for (std::size_t p = 0; p < planes; ++p) {
    const int first = axes[p], second = axes[(p + 1) % axes.size()];
    const Stretch u = stretchOf(t, first), v = stretchOf(t, second);
    const double radius = 0.5 * std::min(u.to - u.from, v.to - v.from);
    const auto read = [&](int k) {
      const double angle = 2.0 * kPi * k / t.size.positions;
      PlanScript::Readings q = t.with(first, u.at(0.5) + radius * std::cos(angle));
      q[static_cast<std::size_t>(second)] = v.at(0.5) + radius * std::sin(angle);
      t.script.position(q, kTestDwell, t.joint(first).name + t.joint(second).name);
    };
    t.script.repeat(t.size.runs, [&] {
      for (int k = 0; k <= t.size.positions; ++k) read(k);      // counter-clockwise
      for (int k = t.size.positions - 1; k >= 0; --k) read(k);  // clockwise
    });
  }
}

void writeRotation(TestSheet& t) {
  for (const int j : t.rotaryJoints()) {
    const Stretch s = stretchOf(t, j);
    upAndDown(
        t, t.beyond(j) / s.length(), [&](double share) { return t.with(j, s.at(share)); },
        [&](const PlanScript::Readings& q) { t.script.position(q, kTestDwell, t.joint(j).name); });
  }
}

void writeDiagonal(TestSheet& t) {
  const std::vector<int> axes = t.spatialJoints(2);
  std::vector<std::vector<int>> lines = {{1, 1}, {1, -1}};
  if (axes.size() == 3) {
    lines = kBodyDiagonals;
    lines.insert(lines.end(), kFaceDiagonals.begin(), kFaceDiagonals.end());
  }
  for (const std::vector<int>& signs : lines) {
    const BeamLine line = beamLine(t, axes, signs);
    const int beam = beamOf(t, line);
    upAndDown(
        t, beyondOf(t, line), [&](double share) { return line.at(share); },
        [&](const PlanScript::Readings& q) { t.script.length(beam, q, kTestDwell); });
  }
}

void writeLength(TestSheet& t) {
  const std::vector<int> axes = t.spatialJoints(3);
  std::vector<std::vector<int>> lines = kBodyDiagonals;
  lines.insert(lines.end(), kAlongAxes.begin(), kAlongAxes.end());
  for (const std::vector<int>& signs : lines) {
    const BeamLine line = beamLine(t, axes, signs);
    const int beam = beamOf(t, line);
    const double beyond = beyondOf(t, line);
    for (int i = 1; i <= kGaugeLengths; ++i) {
      const double share = static_cast<double>(i) / kGaugeLengths;
      t.script.repeat(t.size.runs, [&] {  // each end from outside
        t.script.go(line.at(-beyond));
        t.script.length(beam, line.at(0.0), kTestDwell);
        t.script.go(line.at(share + beyond));
        t.script.length(beam, line.at(share), kTestDwell);
      });
    }
  }
}

}  // namespace mm
