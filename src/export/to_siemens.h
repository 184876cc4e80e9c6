#pragma once
#include "export/export_target.h"

namespace mm {

/// Tables $AN_CEC of the interpolatory compensation: each axis by each axis. SINUMERIK Function Manual
/// Extended Functions, K3.
Exported toSiemens(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
