#pragma once
#include <string>

#include "session/plan.h"

namespace mm {

/// An artifact as YAML, as parseArtifact reads it (with `indent` blanks before each line).
std::string artifactYaml(const Artifact& artifact, int indent = 0);

/// The key `placements` of a plan; empty: it has none.
std::string placementsYaml(const Plan& plan);

/// A plan with every move written out under `moves`: Plan::parse on the same machine gives the same moves
/// back (to 1 nm). The simulation's settings are not in it. For the proposals of a diagnosis, and to look at
/// a shorthand.
std::string planYaml(const Plan& plan, const Machine& machine);

/// One move as an entry of `moves`.
std::string moveYaml(const PlanMove& move, const Plan& plan, const Machine& machine);

}  // namespace mm
