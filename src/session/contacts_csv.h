#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "session/progress.h"
#include "session/session.h"

namespace mm {

/// What import adds to `time_s`, in s: a bag knows no time zero. 2001-09-09 01:46:40 UTC.
inline constexpr std::int64_t kImportEpoch = 1000000000;

/// Reads a session from a CSV: one row a contact or a measurement by an independent instrument, columns by
/// name in any order with the unit in the name (mm, deg, um, arcsec, degC), empty cells not measured. Time
/// counts from the earliest row, in whole nanoseconds. A row without a measurement adds its temperatures and
/// covariates only.
/// @param artifact null: sessions of an independent instrument only. The session returned is prepared.
/// @throw InputError naming file, line, column and remedy.
Session readContactsCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress = {});

/// The rows of a CSV in the import format taken as states of the machine, whatever was measured there.
struct StatesCsv {
  Session session;  // observations in the order of the file, `feature` -1 where it is not in the artifact
  std::string header;
  std::vector<std::string> lines;  // as written, one an observation

  explicit StatesCsv(Machine machine) : session(std::move(machine)) {}  ///< of which the rows are states
};

/// A reading that was not measured is NaN; without a column `time_s` all rows are at the session's start.
/// @param artifact may be null. @throw InputError as above.
StatesCsv readStatesCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress = {});

}  // namespace mm
