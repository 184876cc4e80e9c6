// The tests of ISO 230-2, -4, -6, -7 and ISO 10360-2: readings at places.
#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "session/plan_test_sheet.h"
#include "session/test_targets.h"

namespace mm {
namespace {

constexpr double kStandoff = 0.1;  // m from where a beam's lengths begin to its first target
constexpr int kGaugeLengths = 5;   // ISO 10360-2

/// A straight line of the joints, every one going evenly.
struct BeamLine {
  std::string name;
  PlanScript::Readings from, to;
  PlanScript::Readings at(double share) const {
    PlanScript::Readings q = from;
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += share * (to[j] - from[j]);
    return q;
  }
  /// Beyond the place at a share of the way, every joint that moves by as much as takes up its play.
  /// @param side -1 before it, +1 behind it.
  PlanScript::Readings outside(const TestSheet& t, double share, double side) const {
    PlanScript::Readings q = at(share);
    for (std::size_t j = 0; j < q.size(); ++j)
      if (to[j] != from[j]) q[j] += std::copysign(t.beyond(static_cast<int>(j)), side * (to[j] - from[j]));
    return q;
  }
};

/// Places to and fro along a line, each end reached from beyond it. @param shares of the way, ascending.
template <typename Read>
void toAndFro(TestSheet& t, const BeamLine& line, const std::vector<double>& shares, const Read& read) {
  t.script.repeat(t.size.runs, [&] {
    t.script.go(line.outside(t, 0.0, -1.0));
    for (const double share : shares) read(line.at(share));
    t.script.go(line.outside(t, 1.0, 1.0));
    for (auto share = shares.rbegin(); share != shares.rend(); ++share) read(line.at(*share));
  });
}

/// Shares of a line of that length (m or rad) at which ISO 230-2 and 230-6 read.
std::vector<double> sharesOf(const TestSheet& t, const std::string& line, double length, bool linear) {
  std::vector<double> shares = shiftedTargets(linear ? t.targets(line, length) : t.size.positions, 1.0);
  for (double& share : shares) share += 0.5;
  return shares;
}

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

Eigen::Vector3d tipAt(const TestSheet& t, const PlanScript::Readings& q) {
  return t.machine.nominal(q.data(), kNotMeasured).position;
}

/// The point, on the line drawn out, from which its lengths count.
int beamOf(TestSheet& t, const BeamLine& line) {
  const Eigen::Vector3d from = tipAt(t, line.from), way = (tipAt(t, line.to) - from).normalized();
  return t.script.addPoint(line.name, from - kStandoff * way);
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
    std::string positions;
    for (const double share : sharesOf(t, "joint " + t.joint(j).name, s.length(), !t.turns(j)))
      positions += (positions.empty() ? "" : ", ") + format("%.6g", s.at(share) / t.unit(j));
    t.head += "  - {joint: " + t.joint(j).name + ", positions_" + readingUnit(t.joint(j)).symbol + ": [" +
              positions + format("], runs: %d, dwell_s: %.3g", t.size.runs, kTestDwell) +
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
    const auto point = [&](int k) {
      const double angle = 2.0 * kPi * k / t.size.positions;
      PlanScript::Readings q = t.with(first, u.at(0.5) + radius * std::cos(angle));
      q[static_cast<std::size_t>(second)] = v.at(0.5) + radius * std::sin(angle);
      return q;
    };
    const std::string setup = t.joint(first).name + t.joint(second).name;
    t.script.repeat(t.size.runs, [&] {
      for (const int sense : {1, -1}) {           // counter-clockwise, clockwise
        const int first = sense > 0 ? 0 : 1;      // where the other sense has ended
        t.script.go(point(sense * (first - 1)));  // the way from there takes up the play
        for (int k = first; k <= t.size.positions; ++k)
          t.script.position(point(sense * k), kTestDwell, setup);
      }
    });
  }
}

void writeRotation(TestSheet& t) {
  for (const int j : t.rotaryJoints()) {
    const Stretch s = stretchOf(t, j);
    std::vector<double> evenly;
    for (int k = 0; k < t.size.positions; ++k) evenly.push_back(k / (t.size.positions - 1.0));
    toAndFro(t, {t.joint(j).name, t.with(j, s.from), t.with(j, s.to)}, evenly,
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
    const double length = (tipAt(t, line.to) - tipAt(t, line.from)).norm();
    toAndFro(t, line, sharesOf(t, "diagonal " + line.name, length, true),
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
    for (int i = 1; i <= kGaugeLengths; ++i) {
      const double share = static_cast<double>(i) / kGaugeLengths;
      t.script.repeat(t.size.runs, [&] {  // each end from outside
        t.script.go(line.outside(t, 0.0, -1.0));
        t.script.length(beam, line.at(0.0), kTestDwell);
        t.script.go(line.outside(t, share, 1.0));
        t.script.length(beam, line.at(share), kTestDwell);
      });
    }
  }
}

}  // namespace mm
