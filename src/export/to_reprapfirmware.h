#pragma once
#include "export/export_target.h"

namespace mm {

/// M556 and M425. RepRapFirmware: G-code dictionary, Move::AxisTransform.
Exported toReprapfirmware(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
