#pragma once
#include "base/yaml_mapping.h"
#include "session/plan_builder.h"

namespace mm {

// Shorthand of a plan file, each turned into single moves. All throw InputError.

/// `touch`: points spread evenly (Fibonacci spiral) over a cap of each ball.
void expandTouch(const YAML::Node& node, PlanBuilder& builder);
/// `postures`: laser readings on a ball, spread over the part of it that the beam sees in each posture.
void expandPostures(const YAML::Node& node, PlanBuilder& builder);
/// `reference`: positions of one axis from both sides, run after run (ISO 230-2).
void expandReference(const YAML::Node& node, PlanBuilder& builder);

/// The nodes of a list, or the one node itself.
std::vector<YAML::Node> entriesOf(const YAML::Node& node);
/// Keys `<joint>_mm` or `<joint>_deg` of every joint, in the machine's order.
std::vector<std::string> jointKeys(const Machine& machine);
/// `start` with the joints that the mapping names.
std::vector<double> readingsOf(const YamlMapping& map, const Machine& machine, std::vector<double> start);

}  // namespace mm
