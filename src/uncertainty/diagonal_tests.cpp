#include "uncertainty/diagonal_tests.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/units.h"
#include "uncertainty/setup_rows.h"

namespace mm {
namespace {

constexpr int kFewestTargets = 5;                   // ISO 230-6, as ISO 230-2
constexpr double kOffTheLine = 0.5 * kMillimetre;   // of a target
constexpr double kStandsStill = 0.1 * kMillimetre;  // a linear joint that is not of the diagonal

struct LengthRow {
  int observation = 0;
  double distance = 0.0;  // m, nominal
  Eigen::Vector3d out;    // unit vector from the point to the tip
};

/// A linear joint of the diagonal, and whether it grows as the tip goes away.
struct DiagonalJoint {
  int joint = 0;
  bool grows = true;
};

/// Joints that follow the distance, those of the machine in their order; empty: others move too.
std::vector<DiagonalJoint> jointsOfDiagonal(const Session& session, const std::vector<LengthRow>& rows) {
  std::vector<DiagonalJoint> joints;
  const auto [least, most] =
      std::minmax_element(rows.begin(), rows.end(),
                          [](const LengthRow& a, const LengthRow& b) { return a.distance < b.distance; });
  const Observation &near = session.observations[least->observation],
                    &far = session.observations[most->observation];
  std::vector<int> observations;
  for (const LengthRow& row : rows) observations.push_back(row.observation);
  for (const int j : movedJoints(session, observations, kStandsStill)) {
    if (session.machine.joints()[j].kind != JointKind::kLinear) return {};
    joints.push_back({j, far.position[j] > near.position[j]});
  }
  return joints;
}

std::optional<DiagonalTest> diagonalOf(const Session& session, const std::vector<LengthRow>& rows,
                                       const ResidualOf& left) {
  for (const LengthRow& row : rows)
    if (row.distance * (row.out - rows.front().out).norm() > kOffTheLine) return std::nullopt;
  const std::vector<DiagonalJoint> joints = jointsOfDiagonal(session, rows);
  if (joints.size() < 2) return std::nullopt;
  DiagonalTest test;
  std::map<std::string, const char*> signs;  // x before y, whatever the machine's chain
  for (const DiagonalJoint& j : joints) signs[session.machine.joints()[j.joint].name] = j.grows ? "+" : "-";
  for (const auto& [name, sign] : signs) test.name += sign + name;
  double zero = kNotMeasured;
  for (const LengthRow& row : rows) {
    const Observation& o = session.observations[row.observation];
    const double travel = o.travel[joints.front().joint];
    if (travel == 0.0) continue;
    const bool outwards = (travel > 0.0) == joints.front().grows;
    if (std::isnan(zero)) zero = o.length - row.distance;
    const double along = row.distance / kMillimetre;
    test.runs.push_back({along, (o.length - row.distance - zero) / kMicrometre, outwards});
    const double rest = left ? left(row.observation, 0) : kNotMeasured;
    if (std::isfinite(rest)) test.leftRuns.push_back({along, rest / kMicrometre, outwards});
  }
  if (test.runs.empty()) return std::nullopt;
  test.measured = positioningTest(test.runs);
  if (!test.leftRuns.empty()) test.left = positioningTest(test.leftRuns);
  const auto& targets = test.measured.targets;
  const auto both = [](const PositioningTarget& t) { return t.forward > 0 && t.backward > 0; };
  if (std::count_if(targets.begin(), targets.end(), both) < kFewestTargets) return std::nullopt;
  return test;
}

}  // namespace

std::vector<DiagonalTest> diagonalTests(const Session& session, const ResidualOf& left) {
  std::vector<DiagonalTest> tests;
  for (const SetupRows& beam : lengthsBySetup(session)) {
    std::vector<LengthRow> rows;
    for (const int i : beam.observations) {
      const Eigen::Vector3d way = wayOfLength(session, session.observations[i]);
      if (way.allFinite() && way.norm() > 0.0) rows.push_back({i, way.norm(), way.normalized()});
    }
    if (rows.empty()) continue;
    if (std::optional<DiagonalTest> test = diagonalOf(session, rows, left)) {
      test->setup = beam.setup;
      tests.push_back(std::move(*test));
    }
  }
  return tests;
}

std::string inWords(const DiagonalTest& test) {
  return "ISO 230-6, diagonal " + test.name + ": " + std::to_string(test.runs.size()) + " readings at " +
         std::to_string(test.measured.targets.size()) + " positions";
}

}  // namespace mm
