#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "import/column_meaning.h"
#include "import/import_faults.h"
#include "session/motion.h"
#include "session/progress.h"
#include "session/session.h"

namespace mm {

struct ImportRequest {
  std::filesystem::path file;
  std::filesystem::path mapping;               // empty: none
  std::string format;                          // empty: by itself
  std::shared_ptr<const std::string> content;  // of the file; null: it is read from the disk
  std::string mappingText;                     // of a mapping that is not on the disk
};

/// A session made of somebody's file, with what was understood of it. Filled as far as it was understood when
/// the import is refused.
struct Imported {
  std::optional<Session> session;
  std::string format;  // name of the format
  std::string how;     // encoding, separators, units in words
  std::vector<UnderstoodColumn> columns;
  std::vector<std::string> notes;  // what was left out, assumed or made of the file, one line each
  std::vector<std::vector<std::string>> rows;  // the first as written, a cell a column; empty: no such table
  std::vector<std::string> head;               // first lines of the file
  std::vector<MappingLine> lacks;              // what a refused file asks the mapping for
  std::vector<MotionSample> motion;  // directions of travel to targets at which the machine stood still
};

/// Reads a file of measurements: the package's own columns, anybody's table, or one of `importFormats`.
/// @throw InputError, InputFaults naming file, line, field, value and the line to write into the mapping.
void importFile(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
                Imported& imported, const ProgressCallback& progress = {});

/// How many rows and lines of a file are shown.
inline constexpr std::size_t kRowsShown = 8, kLinesShown = 12;

/// What was understood, for people: format, a table of columns, notes.
std::string understoodText(const Imported& imported);
/// The first rows under the names of their columns; of a file without such a table its first lines.
std::string firstRowsText(const Imported& imported);

}  // namespace mm
