#pragma once
#include "export/export_target.h"

namespace mm {

/// Compensation value tables (.COM) and their assignment (.CMA). Technical Manual, nonlinear axis error
/// compensation.
Exported toHeidenhain(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
