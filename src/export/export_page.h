#pragma once
#include <string>

#include "calibration_file/calibration.h"
#include "export/representability.h"

namespace mm {

/// The whole export: its tables, README.md, representability.json and representability.txt; `judged.files`
/// lists all of them.
std::vector<ExportedFile> exportFolderOf(const Calibration& calibration, const ExportTarget& target,
                                         const NeededCorrection& needed, const Exported& exported,
                                         Representability& judged);

}  // namespace mm
