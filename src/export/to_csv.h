#pragma once
#include "export/export_target.h"

namespace mm {

/// The eighteen component errors of three linear axes as tables, with the kinematic chain. ISO 230-1, 3.4.
Exported toCsv(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
