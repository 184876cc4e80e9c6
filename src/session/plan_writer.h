#pragma once
#include <string>

#include "session/plan.h"

namespace mm {

/// An artifact as YAML, as parseArtifact reads it (with `indent` blanks before each line).
std::string artifactYaml(const Artifact& artifact, int indent = 0);

/// The key `placements` of a plan; empty: it has none.
std::string placementsYaml(const Plan& plan);

/// One move as an entry of `moves`, as Plan::parse on the same machine reads it back (to 1 nm).
std::string moveYaml(const PlanMove& move, const Plan& plan, const Machine& machine);

}  // namespace mm
