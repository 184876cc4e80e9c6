#include "effects/domain.h"

#include <algorithm>

namespace mm {
namespace {

int indexOf(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

}  // namespace

int Domain::findJoint(const std::string& name) const {
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (joints[j].name == name) return static_cast<int>(j);
  return -1;
}

int Domain::findSensor(const std::string& name) const { return indexOf(sensors, name); }
int Domain::findCovariate(const std::string& name) const { return indexOf(covariates, name); }
int Domain::findStylus(const std::string& name) const { return indexOf(styli, name); }
int Domain::findFeature(const std::string& name) const { return indexOf(features, name); }

double Domain::spacingOf(int joint) const {
  const auto j = static_cast<std::size_t>(joint);
  return j < spacing.size() ? spacing[j] : 0.0;
}

void Domain::setMachine(const Machine& machine) {
  joints = machine.joints();
  tableJoints = machine.tableJoints();
  probeZero = machine.tipTranslation();
  probeRotation = machine.tipRotation();
}

Domain domainOverTravel(const Machine& machine) {
  constexpr int kPositions = 5;
  Domain domain;
  domain.setMachine(machine);
  for (const Joint& joint : domain.joints) {
    domain.lower.push_back(joint.lower);
    domain.upper.push_back(joint.upper);
    std::vector<double> positions;
    for (int i = 0; i < kPositions; ++i)
      positions.push_back(joint.lower + i * (joint.upper - joint.lower) / (kPositions - 1.0));
    domain.positions.push_back(positions);
  }
  return domain;
}

}  // namespace mm
