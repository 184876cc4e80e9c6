#pragma once
#include <string>
#include <utility>
#include <vector>

#include "model/model_spec.h"

namespace mm::test {

/// A plan over the nine balls of a plate that lies where it is said to: 40 contacts each, every axis in both
/// directions, contacts that scatter by 0.3 um. @param repeatability as the artifact's file declares it, um.
inline std::string knownPlatePlan(const std::string& repeatability = "0.3") {
  return R"(
artifact:
  name: plate
  pose: known
  probe: {tip_radius_mm: 1.0, repeatability_um: )" +
         repeatability + R"(}
  balls:
    - {name: b0, centre_mm: [-13, -8, -9], radius_mm: 3.9685}
    - {name: b1, centre_mm: [0, -8, -2], radius_mm: 3.9685}
    - {name: b2, centre_mm: [13, -8, 5], radius_mm: 3.9685}
    - {name: b3, centre_mm: [-13, 10, 5], radius_mm: 3.9685}
    - {name: b4, centre_mm: [0, 10, -9], radius_mm: 3.9685}
    - {name: b5, centre_mm: [13, 10, -2], radius_mm: 3.9685}
    - {name: b6, centre_mm: [-13, 28, -2], radius_mm: 3.9685}
    - {name: b7, centre_mm: [0, 28, 5], radius_mm: 3.9685}
    - {name: b8, centre_mm: [13, 28, -9], radius_mm: 3.9685}
speeds: {rapid_mm_s: 10, approach_mm_s: 2}
approach: {distance_mm: 1.5, overtravel_mm: 1.0}
clearance: {z_mm: 14}
touch: {features: all, points: 40, cone_deg: 105, order: interleaved}
instrument:
  noise: {repeatability_um: 0.3}
  thermal: {ambient: {start_degC: 20}}
)";
}

/// Scale and reversal of every axis and the squareness of every pair: the model that is fitted, and what is
/// hidden in the simulated machine.
struct GeometryAndReversal {
  ModelSpec model;
  std::vector<std::string> hidden;

  GeometryAndReversal() {
    for (const char* axis : {"x", "y", "z"}) {
      model.effects.push_back(EffectSpec("scale").set("axis", axis));
      model.effects.push_back(EffectSpec("backlash").set("axis", axis));
      hidden.push_back(std::string("scale:") + axis);
      hidden.push_back(std::string("backlash:") + axis);
    }
    for (const auto& [axis, of] : {std::pair("x", "y"), std::pair("x", "z"), std::pair("y", "z")}) {
      model.effects.push_back(EffectSpec("squareness").set("axis", axis).set("of", of));
      hidden.push_back(std::string("squareness:") + axis + "/" + of);
    }
  }
};

}  // namespace mm::test
