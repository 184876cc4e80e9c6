#include "session/plan_test_sheet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "machine/linear_inverse.h"
#include "session/test_targets.h"

namespace mm {
namespace {

constexpr double kUsualRapid = 10e-3, kUsualTurning = 20.0 * kDegree;  // per s, of joints that state none

std::pair<double, double> travelOf(const Joint& joint) {
  if (joint.upper > joint.lower || joint.kind == JointKind::kLinear) return {joint.lower, joint.upper};
  return {0.0, 2.0 * kPi};  // turns without end
}

}  // namespace

TestSheet::TestSheet(const PlanTest& itsTest, const Machine& itsMachine, const PlanTestSize& itsSize)
    : test(itsTest), machine(itsMachine), size(itsSize), script(itsMachine), rapid(kUsualRapid) {
  for (const Joint& j : machine.joints())
    middle.push_back(j.upper > j.lower ? 0.5 * (j.lower + j.upper) : 0.0);
  turning = slowest(JointKind::kRotary);
}

void TestSheet::refuse(const std::string& why) const {
  throw InputError(machine.name() + ": --test " + test.name + " " + why);
}

PlanScript::Readings TestSheet::with(int j, double reading) const {
  PlanScript::Readings q = middle;
  q[static_cast<std::size_t>(j)] = reading;
  return q;
}

int TestSheet::targets(const std::string& line, double length) const {
  const int fewest = fewestTargets(length);
  if (positionsSaid && size.positions < fewest)
    refuse(format(
        "needs --positions %d or more, not %d: %s is %.6g mm long, and ISO 230-2 has five targets a metre",
        fewest, size.positions, line.c_str(), length / kMillimetre));
  return std::max(size.positions, fewest);
}

double TestSheet::slowest(JointKind kind) const {
  double speed = INFINITY;
  for (const Joint& j : machine.joints())
    if (j.kind == kind && j.maxVelocity > 0.0) speed = std::min(speed, j.maxVelocity);
  if (std::isfinite(speed)) return speed;
  return kind == JointKind::kLinear ? kUsualRapid : kUsualTurning;
}

std::vector<int> TestSheet::rotaryJoints() const {
  std::vector<int> joints;
  for (int j = 0; j < machine.jointCount(); ++j)
    if (turns(j)) joints.push_back(j);
  if (joints.empty()) refuse("needs a rotary joint, and the machine has none");
  return joints;
}

std::vector<int> TestSheet::spatialJoints(std::size_t fewest) const {
  const auto jacobian = machine.jacobian(middle.data(), kNotMeasured);
  std::vector<int> joints;
  Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
  for (const int j : linearJoints(machine.joints())) {
    const auto found = static_cast<Eigen::Index>(joints.size());
    if (found == 3) break;
    directions.col(found) = jacobian.col(j).head<3>();
    if (Eigen::FullPivLU<Eigen::Matrix3d>(directions).rank() > found)
      joints.push_back(j);
    else
      directions.col(found).setZero();
  }
  const auto letter = [&](int j) {
    Eigen::Index along = 0;
    jacobian.col(j).head<3>().cwiseAbs().maxCoeff(&along);
    return along;
  };
  std::stable_sort(joints.begin(), joints.end(), [&](int a, int b) { return letter(a) < letter(b); });
  if (joints.size() < fewest)
    refuse(format("needs %d linear axes of different directions, and the machine has %d",
                  static_cast<int>(fewest), static_cast<int>(joints.size())));
  return joints;
}

Stretch stretchOf(const TestSheet& sheet, int j) {
  const Joint& joint = sheet.joint(j);
  const auto [lower, upper] = travelOf(joint);
  const double margin = 0.02 * (upper - lower) + (kBeyondStretch + 0.1) * sheet.unit(j);
  // The upper margin is a little wider: positions that are no multiple of a pitch (ISO 230-2).
  if (upper - lower > 2.2 * margin) return {lower + margin, upper - 1.1 * margin};
  const char* symbol = readingUnit(joint).symbol;
  sheet.refuse(format("needs a travel of 1.4 %s, and joint %s has %.6g %s", symbol, joint.name.c_str(),
                      (upper - lower) / sheet.unit(j), symbol));
}

}  // namespace mm
