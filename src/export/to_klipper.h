#pragma once
#include "export/export_target.h"

namespace mm {

/// SET_SKEW, a bed mesh and z_thermal_adjust. Klipper: Skew_Correction, Bed_Mesh, Config_Reference and the
/// sources of these modules.
Exported toKlipper(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
