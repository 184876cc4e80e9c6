#pragma once
#include "export/export_target.h"

namespace mm {

/// Stored pitch error compensation, parameters 3620 to 3624, and backlash, 1851. Fanuc parameter manual.
Exported toFanuc(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
