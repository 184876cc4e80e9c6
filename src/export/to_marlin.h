#pragma once
#include "export/export_target.h"

namespace mm {

/// M425 and M852. Marlin: M425, M852, planner.h (skew), backlash.cpp.
Exported toMarlin(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
