#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "import/column_meaning.h"
#include "session/motion.h"
#include "session/progress.h"
#include "session/session.h"

namespace mm {

struct ImportRequest {
  std::filesystem::path file;
  std::filesystem::path mapping;  // empty: none
  std::string format;             // empty: by itself
};

/// A session made of somebody's file, with what was understood of it. Filled as far as it was understood when
/// the import is refused.
struct Imported {
  std::optional<Session> session;
  std::string format;  // name of the format
  std::string how;     // encoding, separators, units in words
  std::vector<UnderstoodColumn> columns;
  std::vector<std::string> notes;    // what was left out, assumed or made of the file, one line each
  std::vector<MotionSample> motion;  // directions of travel to targets at which the machine stood still
};

/// Reads a file of measurements: the package's own columns, anybody's table, or one of `importFormats`.
/// @throw InputError, InputFaults naming file, line, field, value and the line to write into the mapping.
void importFile(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
                Imported& imported, const ProgressCallback& progress = {});

/// What was understood, for people: format, a table of columns, notes.
std::string understoodText(const Imported& imported);

}  // namespace mm
