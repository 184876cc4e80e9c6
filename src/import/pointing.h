#pragma once
#include "import/import_format.h"

namespace mm {

/// TPoint data files: a caption, options (`:NODA`), the site, and a row a star until END: azimuth and
/// elevation of the star and of the telescope in degrees (four numbers), or right ascension and declination
/// of both and the sidereal time (fourteen).
bool isTPoint(const TextFile& file);
void readTPoint(ImportContext& context);

/// INDI's alignment database: recognised, and refused with the reason.
bool isIndi(const TextFile& file);
void readIndi(ImportContext& context);

}  // namespace mm
