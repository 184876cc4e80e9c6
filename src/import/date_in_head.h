#pragma once
#include <optional>

#include "import/import_format.h"

namespace mm {

/// The date of measurement that the first lines of a file state: `Datum: 27.11.2026`, `Date,2026-11-27
/// 10:15`, `gemessen am 27.11.2026`; month or day first with slashes as the mapping's `date` says, where both
/// may be. Notes what was read. @return s since 1970, of a day alone its midnight (UTC); nothing: none is
/// stated.
std::optional<double> dateInHead(const ImportContext& context);

}  // namespace mm
