#include <algorithm>
#include <cmath>

#include "base/erase_if.h"
#include "base/format.h"
#include "machine/joint_units.h"
#include "report/iso_tests.h"

namespace mm {
namespace {

/// Runs of one axis along one line of the machine's volume, with one zero of the instrument.
struct LineRuns {
  int setup = -1;
  std::vector<double> where;  // of all joints, m or rad, at the first of them
  AxisPositioning axis;
};

/// Whether nothing but one joint moved from one state to another: a circle is no positioning run.
bool onOneLine(const std::vector<double>& a, const std::vector<double>& b, std::size_t moving,
               const std::vector<Joint>& joints) {
  for (std::size_t k = 0; k < a.size(); ++k)
    if (k != moving &&
        std::abs(a[k] - b[k]) > (joints[k].kind == JointKind::kRotary ? 0.5 * kDegree : 0.5 * kMillimetre))
      return false;
  return true;
}

std::vector<LineRuns> linesOf(const CalibrationResult& fitted, std::size_t j) {
  std::vector<LineRuns> lines;
  const Problem& problem = *fitted.problem;
  const std::vector<Joint>& joints = problem.model().machine().joints();
  const double unit = errorUnit(joints[j]).factor, place = readingUnit(joints[j]).factor;
  for (int row = 0; row < problem.rowCount(); ++row) {
    const ResidualRow& r = problem.rows()[static_cast<std::size_t>(row)];
    const Observation& o = problem.session().observations[static_cast<std::size_t>(r.observation)];
    if (o.kind != ObservationKind::kDeviation || r.component != static_cast<int>(j) || o.travel[j] == 0.0)
      continue;
    auto line = std::find_if(lines.begin(), lines.end(), [&](const LineRuns& l) {
      return l.setup == o.setup && onOneLine(l.where, o.position, j, joints);
    });
    if (line == lines.end()) line = lines.insert(lines.end(), LineRuns{o.setup, o.position, {}});
    AxisPositioning& axis = line->axis;
    axis.rotary = joints[j].kind == JointKind::kRotary;
    axis.runs.push_back({o.position[j] / place, o.deviation[j] / unit, o.travel[j] > 0.0});
    axis.left.push_back({o.position[j] / place, fitted.residuals[row] / unit, o.travel[j] > 0.0});
  }
  return lines;
}

/// What tells a line from the others of its axis: ", setup left", ", at y = 100 mm".
std::string nameOf(const LineRuns& line, const std::vector<LineRuns>& all, std::size_t moving,
                   const Session& session) {
  const std::vector<Joint>& joints = session.machine.joints();
  std::string name = joints[moving].name;
  const auto differs = [&](auto same) { return !std::all_of(all.begin(), all.end(), same); };
  if (line.setup >= 0 && differs([&](const LineRuns& l) { return l.setup == line.setup; }))
    name += ", setup " + session.setups[static_cast<std::size_t>(line.setup)];
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const auto same = [&](const LineRuns& l) {
      std::vector<double> there = line.where;
      there[k] = l.where[k];
      return onOneLine(line.where, there, moving, joints);
    };
    if (k == moving || !differs(same)) continue;
    const JointUnit unit = readingUnit(joints[k]);
    name += ", at " + joints[k].name + format(" = %.4g %s", line.where[k] / unit.factor, unit.symbol);
  }
  return name;
}

}  // namespace

std::vector<AxisPositioning> axisPositioning(const CalibrationResult& fitted) {
  std::vector<AxisPositioning> axes;
  const Session& session = fitted.problem->session();
  const std::vector<Joint>& joints = session.machine.joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    std::vector<LineRuns> lines = linesOf(fitted, j);
    for (LineRuns& line : lines) {
      line.axis.measured = positioningTest(line.axis.runs);
      line.axis.calibrated = positioningTest(line.axis.left);
    }
    eraseIf(lines, [](const LineRuns& line) {
      const auto& targets = line.axis.measured.targets;
      const auto both = [](const PositioningTarget& t) { return t.forward > 0 && t.backward > 0; };
      return std::count_if(targets.begin(), targets.end(), both) < 3;
    });
    for (LineRuns& line : lines) {
      line.axis.axis = joints[j].name;
      line.axis.name = nameOf(line, lines, j, session);
      for (const AssumedInput& assumed : session.assumed)
        if (assumed.joint == line.axis.axis) line.axis.travelAssumed = assumed.how;
      axes.push_back(line.axis);
    }
  }
  return axes;
}

}  // namespace mm
