#pragma once
#include <string>

#include "design/next_measurement.h"

namespace mm {

/// With this the text of such a plan begins.
constexpr const char* kMovesBegin = "name: next_measurement\n";

/// The proposed moves as a measurement plan (YAML) that `mm simulate` and the node `measure` run, with the
/// session's artifact in it. Empty when nothing is proposed.
std::string movesYaml(const std::vector<Move>& moves, const Session& session);

}  // namespace mm
