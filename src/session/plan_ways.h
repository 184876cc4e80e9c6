#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "session/plan.h"

namespace mm {

/// The way to a move's position on which the nominal tip would enter a ball: on a machine a collision.
struct BlockedWay {
  std::size_t move = 0;  // in the plan: the one that it leads to
  int ball = -1;         // index in the artifact
  double depth = 0.0;    // m by which tip and ball would overlap
};

/// The least distance of a point from a way of straight pieces, m.
double distanceToWay(const Eigen::Vector3d& point, const std::vector<Eigen::Vector3d>& way);

/// The ways between the moves of a plan that lead through a ball, in their order. Of the way to the first
/// move nobody knows where it begins; a laser has no tip. Balls that overlap the one that is touched cannot
/// be there with it (one ball at many angles of a spindle is written so) and are left out.
std::vector<BlockedWay> blockedWays(const Plan& plan, const Machine& machine);

/// One line for people: file and line, touch, ball, how deep, how many more, and the remedy. Empty: no way is
/// blocked.
std::string blockedWaysText(const Plan& plan, const std::vector<BlockedWay>& ways);

}  // namespace mm
