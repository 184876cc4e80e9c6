#pragma once
#include "export/export_target.h"

namespace mm {

/// Compensation value lists: leadscrew (bilateral), cross and plane compensation. TF5200 Axis compensation.
Exported toBeckhoff(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
