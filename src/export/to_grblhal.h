#pragma once
#include "export/export_target.h"

namespace mm {

/// $160 and following: backlash. grblHAL: settings.h, motion_control.c.
Exported toGrblhal(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
