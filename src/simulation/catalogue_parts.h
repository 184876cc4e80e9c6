#pragma once
#include <vector>

#include "simulation/catalogue.h"

// For the sources of the catalogue only.
namespace mm::source_kinds {

using Key = SourceKind::Key;
using Probe = SourceKind::Probe;
using Kinds = std::vector<SourceKind>;

Kinds screw();      ///< of the drives: positions along the axis
Kinds guideway();   ///< squareness, straightness, roll, pitch and yaw
Kinds structure();  ///< heat, time, weight, and what was logged beside them
Kinds probe();      ///< of probe and artifact
Kinds rotary();     ///< zero, place and direction of the axis, graduation, wobble

}  // namespace mm::source_kinds
