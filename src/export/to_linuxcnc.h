#pragma once
#include "export/export_target.h"

namespace mm {

/// COMP_FILE triplets of each joint (position; trim upwards; trim downwards) and the lines of the INI file.
/// LinuxCNC: INI configuration, [JOINT_n] COMP_FILE, COMP_FILE_TYPE, BACKLASH.
Exported toLinuxcnc(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
