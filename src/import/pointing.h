#pragma once
#include "import/import_format.h"

namespace mm {

/// TPoint data files: a caption, options (`:NODA`), the site, and a row a star until END: azimuth and
/// elevation of the star and of the telescope in degrees (four numbers), or right ascension and declination
/// of both and the sidereal time (fourteen).
bool isTPoint(const TextFile& file);
void readTPoint(ImportContext& context);

}  // namespace mm
