#pragma once
#include <string>

#include "calibration_file/calibration.h"
#include "export/representability.h"

namespace mm {

/// README.md of an export: what to install where and in which order, from where positions count, how one move
/// shows that the sign is right, what is carried, what was checked, and what is open.
/// @param motors the target's interpreter over the files.
std::string exportPage(const Calibration& calibration, const ExportTarget& target,
                       const NeededCorrection& needed, const Exported& exported,
                       const Representability& judged);

/// The whole export: its tables, README.md, representability.json and representability.txt; `judged.files`
/// lists all of them.
std::vector<ExportedFile> exportFolderOf(const Calibration& calibration, const ExportTarget& target,
                                         const NeededCorrection& needed, const Exported& exported,
                                         Representability& judged);

}  // namespace mm
