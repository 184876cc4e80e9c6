#pragma once
#include "import/import_format.h"

namespace mm {

/// Console logs of printers that touch their bed. Klipper: PROBE_ACCURACY and `probe at x,y is z=`, a bed
/// mesh of printer.cfg; Marlin: `Bed X: Y: Z:` (G29, G30) and M48.
bool isKlipperLog(const TextFile& file);
bool isMarlinLog(const TextFile& file);
void readKlipperLog(ImportContext& context);
void readMarlinLog(ImportContext& context);

}  // namespace mm
