#pragma once
#include <string>
#include <vector>

#include "base/units.h"
#include "session/session.h"

namespace mm {

/// Observations of one kind by an instrument with one zero: of one recording, setup, placement and feature.
struct SetupRows {
  std::string setup;  // empty: none
  int feature = -1, placement = 0;
  std::vector<int> observations;  // indices, in the order of time
};

/// Those of a session, by recording, setup, placement and feature.
std::vector<SetupRows> rowsBySetup(const Session& session, ObservationKind kind);

/// The same for lengths from a point whose place in workpiece is known.
std::vector<SetupRows> lengthsBySetup(const Session& session);

/// Joints that were not in one place at these observations, by more than the noise of readings: a linear one
/// by `length` (m), a rotary one by 0.05 deg.
std::vector<int> movedJoints(const Session& session, const std::vector<int>& observations,
                             double length = 0.05 * kMillimetre);

/// The one joint of a list where it is rotary; -1: it is none, or there are several.
int singleRotary(const Session& session, const std::vector<int>& joints);

/// From the point at which a length begins to where the readings say that the tip is: workpiece, m.
Eigen::Vector3d wayOfLength(const Session& session, const Observation& length);

}  // namespace mm
