#pragma once
#include "export/export_page.h"
#include "export/representability.h"

namespace mm::test {

/// The folder that `mm export` writes, without the figures of what each effect leaves, which take the
/// longest.
inline std::vector<ExportedFile> folderWithoutFigures(const Calibration& calibration,
                                                      const ExportTarget& target,
                                                      const NeededCorrection& needed,
                                                      const Exported& exported) {
  Representability told;
  told.target = target.name;
  told.calibration = calibration.id;
  for (const ExportAxis& axis : needed.axes()) told.letters[axis.name] = axis.letter;
  told.sensors = exported.sensors;
  return exportFolderOf(calibration, target, needed, exported, told);
}

}  // namespace mm::test
