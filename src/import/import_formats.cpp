#include "import/ball_bar.h"
#include "import/gauge_lengths.h"
#include "import/import_format.h"
#include "import/pointing.h"
#include "import/positioning_table.h"
#include "import/probe_log.h"
#include "import/r_test.h"
#include "import/table_format.h"

namespace mm {

const std::vector<ImportFormat>& importFormats() {
  static const std::vector<ImportFormat> kFormats = {
      {"tpoint", "pointing of a mount, TPoint data file", isTPoint, readTPoint},
      {"klipper", "touches of a bed: PROBE_ACCURACY, probe at x,y, saved mesh", isKlipperLog, readKlipperLog},
      {"marlin", "touches of a bed: G29, G30, M48", isMarlinLog, readMarlinLog},
      {"ballbar", "circles of a ball bar, ISO 230-4", isBallBar, readBallBar},
      {"r-test", "rotary axes about a ball, dx, dy, dz", isRTest, readRTest},
      {"step-gauge", "step gauge or length bars along one axis, ISO 10360-2", isGaugeLengths,
       readGaugeLengths},
      {"iso230-2", "targets by runs, ISO 230-2", isPositioningTable, readPositioningTable},
      {"table", "one row a measurement, columns by name", [](const TextFile&) { return true; }, readAnyTable},
  };
  return kFormats;
}

}  // namespace mm
