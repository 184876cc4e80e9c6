#pragma once
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

/// Something that several placements, styli or sessions may tell apart from something else, and one cannot.
struct Separation {
  std::string what;   // "the squareness of x to y from an error of the artifact"
  bool told = false;  // by this session
  std::string needs;  // where it is not told: what to change and measure again
};

/// What a set of placements, styli and sessions separates, before any fit: from the geometry of what was
/// touched, with every position of the artifact unknown. Empty: it has no contacts with several features.
std::vector<Separation> separationsOf(const Session& session);

}  // namespace mm
