#pragma once
#include "base/format.h"
#include "base/json_text.h"
#include "base/units.h"
#include "session/plan_writer.h"

namespace mm {

/// A plan with every move written out under `moves`: Plan::parse on the same machine gives the same moves
/// back (to 1 nm). The simulation's settings are not in it.
inline std::string planYaml(const Plan& plan, const Machine& machine) {
  std::string out =
      "name: " + jsonLine(Json(plan.name)) + "\nprobe: " + (plan.laser ? "laser" : "touch") + "\n";
  if (!plan.artifact.features.empty()) out += "artifact:\n" + artifactYaml(plan.artifact, 2);
  out += format("speeds: {rapid_mm_s: %.12g, rapid_deg_s: %.12g}\n", plan.rapid / kMillimetre,
                plan.rapidRotary / kDegree);
  out += placementsYaml(plan) + "moves:\n";
  for (const PlanMove& move : plan.moves) out += "  - " + moveYaml(move, plan, machine) + "\n";
  return out;
}

}  // namespace mm
