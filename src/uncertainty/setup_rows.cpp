#include "uncertainty/setup_rows.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace mm {

std::vector<SetupRows> rowsBySetup(const Session& session, ObservationKind kind) {
  std::map<std::tuple<int, int, int, int>, SetupRows> groups;
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const Observation& o = session.observations[i];
    if (o.kind != kind) continue;
    SetupRows& group = groups[{o.recording, o.setup, o.placement, o.feature}];
    if (o.setup >= 0) group.setup = session.setups[static_cast<std::size_t>(o.setup)];
    group.placement = o.placement;
    group.feature = o.feature;
    group.observations.push_back(static_cast<int>(i));
  }
  std::vector<SetupRows> all;
  for (auto& [key, group] : groups) all.push_back(std::move(group));
  return all;
}

std::vector<SetupRows> lengthsBySetup(const Session& session) {
  std::vector<SetupRows> all = rowsBySetup(session, ObservationKind::kLength);
  const auto unknown = [&](const SetupRows& rows) {
    return rows.feature < 0 || session.poseFree(rows.placement);
  };
  all.erase(std::remove_if(all.begin(), all.end(), unknown), all.end());
  return all;
}

Eigen::Vector3d wayOfLength(const Session& session, const Observation& length) {
  return session.nominalProbe(length).position -
         session.artifact.features[static_cast<std::size_t>(length.feature)].position;
}

}  // namespace mm
