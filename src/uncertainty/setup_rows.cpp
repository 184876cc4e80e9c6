#include "uncertainty/setup_rows.h"

#include <map>
#include <tuple>

#include "base/erase_if.h"
#include "base/range.h"

namespace mm {

std::vector<SetupRows> rowsBySetup(const Session& session, ObservationKind kind) {
  std::map<std::tuple<int, int, int, int>, SetupRows> groups;
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const Observation& o = session.observations[i];
    if (o.kind != kind) continue;
    SetupRows& group = groups[{o.recording, o.setup, o.placement, o.feature}];
    if (o.setup >= 0) group.setup = session.setups[o.setup];
    group.placement = o.placement;
    group.feature = o.feature;
    group.observations.push_back(i);
  }
  std::vector<SetupRows> all;
  for (auto& [key, group] : groups) all.push_back(std::move(group));
  return all;
}

std::vector<SetupRows> lengthsBySetup(const Session& session) {
  std::vector<SetupRows> all = rowsBySetup(session, ObservationKind::kLength);
  eraseIf(all, [&](const SetupRows& rows) { return rows.feature < 0 || session.poseFree(rows.placement); });
  return all;
}

std::vector<int> movedJoints(const Session& session, const std::vector<int>& observations, double length) {
  constexpr double kAngle = 0.05 * kDegree;
  std::vector<int> moved;
  for (int j = 0; j < session.machine.jointCount(); ++j) {
    Range range;
    for (const int i : observations) range.add(session.observations[i].position[j]);
    const bool linear = session.machine.joints()[j].kind == JointKind::kLinear;
    if (range.size() > (linear ? length : kAngle)) moved.push_back(j);
  }
  return moved;
}

int singleRotary(const Session& session, const std::vector<int>& joints) {
  const bool single =
      joints.size() == 1 && session.machine.joints()[joints.front()].kind == JointKind::kRotary;
  return single ? joints.front() : -1;
}

Eigen::Vector3d wayOfLength(const Session& session, const Observation& length) {
  return session.nominalProbe(length).position - session.artifact.features[length.feature].position;
}

}  // namespace mm
