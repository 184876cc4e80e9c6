#pragma once
#include <string>
#include <vector>

#include "export/fitted_tables.h"

namespace mm {

/// What joint tables leave to be added to each linear axis, over the positions of all linear axes, and how it
/// changes with each temperature: multilinear between grid points, linear in the temperatures. What
/// LinuxCNC's external offsets can take, as the file of the HAL component `linuxcnc_offsets`.
struct OffsetGrid {
  std::vector<std::string> letters, sensors;  // axes that it moves; sensors that change something
  double largest = 0.0;  // m: at the reference temperatures, and by the whole range of any temperature
  std::string json;      // the file: lengths in mm, temperatures in degC, keys with their units
};
/// What the position of an axis alone does to it, both directions together, is left to the joint's table,
/// also what no table can follow.
OffsetGrid offsetGrid(const NeededCorrection& needed, CorrectionPart part = &NeededCorrection::at);

}  // namespace mm
