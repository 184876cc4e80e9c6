#include "machine/iso230_axes.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace mm {
namespace {

/// The n-th axis, counted from 0, that moves along (about) axis k of the workpiece.
std::string axisLetter(JointKind kind, int k, std::size_t n) {
  constexpr const char* kLinear[] = {"XYZ", "UVW", "PQR"};
  constexpr std::size_t kSets = 3;
  if (kind == JointKind::kRotary) return std::string(1, "ABC"[k]) + (n == 0 ? "" : std::to_string(n + 1));
  return n < kSets ? std::string(1, kLinear[n][k]) : std::string(1, "XYZ"[k]) + std::to_string(n + 1);
}

bool isCalled(const std::string& joint, const std::string& letter) {
  return joint.size() == 1 && std::toupper(static_cast<unsigned char>(joint[0])) == letter[0];
}

}  // namespace

std::vector<Eigen::Matrix3d> fixedSides(const Machine& machine) {
  const std::vector<double> q(static_cast<std::size_t>(machine.jointCount()), 0.0);
  const ErrorLayout at = machine.layout();
  const std::vector<double> errors(static_cast<std::size_t>(at.size()), 0.0);
  Eigen::Matrix<double, 6, Eigen::Dynamic> gradient;
  machine.measure(q.data(), 0.0, errors.data(), &gradient);
  std::vector<Eigen::Matrix3d> sides;
  for (int j = 0; j < machine.jointCount(); ++j)
    sides.emplace_back(gradient.block<3, 3>(3, at.jointRotation(j, 0)) *
                       (j < machine.tableJoints() ? -1.0 : 1.0));
  return sides;
}

int alongWorkpieceAxis(const Eigen::Vector3d& direction) {
  constexpr double kCosine = 0.985;  // of 10 degrees
  for (int k = 0; k < 3; ++k)
    if (std::abs(direction[k]) >= kCosine * direction.norm() && direction.norm() > 0.0) return k;
  return -1;
}

std::vector<Iso230Axis> iso230Axes(const Machine& machine) {
  const std::vector<Eigen::Matrix3d> sides = fixedSides(machine);
  std::vector<Iso230Axis> axes;
  for (std::size_t j = 0; j < sides.size(); ++j) {
    const Joint& joint = machine.joints()[j];
    axes.push_back({{}, joint.kind, sides[j] * joint.axis, sides[j]});
  }
  for (const JointKind kind : {JointKind::kLinear, JointKind::kRotary})
    for (int k = 0; k < 3; ++k) {
      std::vector<std::size_t> alike;
      for (std::size_t j = 0; j < axes.size(); ++j)
        if (axes[j].kind == kind && alongWorkpieceAxis(axes[j].direction) == k) alike.push_back(j);
      std::stable_partition(alike.begin(), alike.end(), [&](std::size_t j) {
        return isCalled(machine.joints()[j].name, axisLetter(kind, k, 0));
      });
      for (std::size_t n = 0; n < alike.size(); ++n) axes[alike[n]].name = axisLetter(kind, k, n);
    }
  return axes;
}

std::string kinematicChain(const Machine& machine) {
  const std::vector<Iso230Axis> axes = iso230Axes(machine);
  const auto bed = static_cast<std::size_t>(machine.tableJoints());
  std::string chain = "w";
  for (std::size_t j = 0; j < axes.size(); ++j) {
    if (j == bed) chain += "-b";
    chain += "-" + (axes[j].name.empty() ? "\"" + machine.joints()[j].name + "\"" : axes[j].name);
  }
  return chain + (bed >= axes.size() ? "-b-t" : "-t");
}

}  // namespace mm
