#pragma once
#include <string>

#include "diagnosis/diagnose.h"

namespace mm {

/// The proposed moves as a measurement plan (YAML) that `mm simulate` and the node `measure` run, with the
/// session's artifact in it. Empty when nothing is proposed.
std::string movesYaml(const Diagnosis& diagnosis, const Session& session);

}  // namespace mm
