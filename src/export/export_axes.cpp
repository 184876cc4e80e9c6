#include "export/export_axes.h"

#include "base/error.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/text.h"

namespace mm {
namespace {

const std::string kLetters = "xyzabcuvw";

bool isLetter(const std::string& text) {
  return text.size() == 1 && kLetters.find(text) != std::string::npos;
}

/// Letters that a joint without one of its own may have, best first.
std::string lettersFor(const Eigen::Vector3d& along, JointKind kind) {
  Eigen::Index most = 0;
  along.cwiseAbs().maxCoeff(&most);
  const std::string own = kind == JointKind::kLinear ? "xyz" : "abc";
  const std::string rest = kind == JointKind::kLinear ? "uvw" : "";
  return std::string(1, own[most]) + rest + own;
}

void checkTold(const Machine& machine, const std::map<std::string, std::string>& told) {
  const std::vector<std::string> names = allNames(machine.joints());
  for (const auto& [joint, letter] : told) {
    if (machine.findJoint(joint) < 0)
      throw InputError("--axis " + joint + "=" + letter + ": the machine has no joint '" + joint + "'" +
                       didYouMean(joint, names) + " (it has " + listOf(names) + ")");
    if (!isLetter(letter))
      throw InputError("--axis " + joint + "=" + letter + ": '" + letter +
                       "' is not a letter of an axis; take one of x, y, z, a, b, c, u, v, w");
  }
}

}  // namespace

std::vector<ExportAxis> exportAxes(const Machine& machine, const std::map<std::string, std::string>& told,
                                   const std::vector<double>& lower, const std::vector<double>& upper) {
  checkTold(machine, told);
  const auto& joints = machine.joints();
  const std::vector<double> zero(joints.size(), 0.0);
  const auto jacobian = machine.jacobian(zero.data(), 0.0);
  std::vector<ExportAxis> axes(joints.size());
  std::string taken;
  const auto give = [&](std::size_t j, const std::string& letter, const std::string& why) {
    if (taken.find(letter) != std::string::npos)
      throw InputError("joint '" + joints[j].name + "' " + why + " axis " + letter +
                       ", which another joint already has; assign letters with --axis " + joints[j].name +
                       "=LETTER");
    axes[j].letter = letter;
    taken += letter;
  };
  bool linear = false;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    axes[j] = {static_cast<int>(j), joints[j].name, "", joints[j].kind, lower[j], upper[j]};
    linear = linear || joints[j].kind == JointKind::kLinear;
    const auto found = told.find(joints[j].name);
    if (found != told.end()) give(j, found->second, "is assigned to");
  }
  if (!linear)
    throw InputError("machine '" + machine.name() +
                     "' has no linear axis: a controller's tables correct the positions of linear axes; "
                     "correct its readings with mm apply");
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (axes[j].letter.empty() && isLetter(mm::lower(joints[j].name)))
      give(j, mm::lower(joints[j].name), "is");
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!axes[j].letter.empty()) continue;
    const Eigen::Index top = joints[j].kind == JointKind::kLinear ? 0 : 3;
    for (const char letter : lettersFor(jacobian.block<3, 1>(top, j), axes[j].kind))
      if (axes[j].letter.empty() && taken.find(letter) == std::string::npos)
        give(j, std::string(1, letter), "becomes");
    if (axes[j].letter.empty())
      throw InputError("joint '" + joints[j].name + "' has no free axis letter; assign one with --axis " +
                       joints[j].name + "=LETTER");
  }
  return axes;
}

}  // namespace mm
