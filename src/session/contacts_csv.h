#pragma once
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "session/csv_columns.h"
#include "session/progress.h"
#include "session/session.h"
#include "session/text_file.h"

namespace mm {

/// What import adds to `time_s`, in s: a bag knows no time zero. 2001-09-09 01:46:40 UTC.
inline constexpr std::int64_t kImportEpoch = 1000000000;

/// How a table is written, and what its columns hold.
struct TableForm {
  bool own = false;  // the package's own: cells exactly as the format has them, no line that is no row
  char separator = ',';
  bool decimalComma = false;
  std::size_t headerLine = 0;  // rows begin below it
  std::vector<CsvColumn> columns;
  std::map<std::string, std::string> features;  // names in the file -> names in the artifact
  std::vector<std::pair<int, double>> fixed;    // joints without a column that did not stand at 0: m or rad
  int onlyFeature = -1;                         // touched in each row, where no column says so
  bool absoluteTime = false;                    // times count from 1970-01-01 UTC

  bool hasAny(std::initializer_list<CsvRole> roles) const;  ///< a column of one of them
};

/// Of a table in the package's own columns: one row a contact or a measurement by an independent instrument,
/// columns by name in any order with the unit in the name (mm, deg, um, arcsec, degC), empty cells not
/// measured. Time counts from the earliest row, in whole nanoseconds. A row without a measurement adds its
/// temperatures and covariates only. @throw InputError naming file, line, column and remedy.
TableForm ownForm(const TextFile& file, const Machine& machine);

/// What was read of one column, in the unit of the file.
struct ColumnRange {
  std::string first;  // as written
  double lower = kNotMeasured, upper = kNotMeasured;
  std::size_t count = 0;

  void add(std::string_view cell);                ///< a text
  void add(std::string_view cell, double value);  ///< of a row
};

struct TableReading {
  Session session;
  std::vector<ColumnRange> ranges;  // one a column
  std::vector<std::string> notes;   // lines that were left out
};

/// Reads the rows of a table into a session that is prepared. Of a table that is not the package's own, rows
/// without a column of times are in their order (Session::timesAssumed), and cells `nan`, `n/a`, `-` and the
/// like are not measured.
/// @param artifact null: sessions of an independent instrument only.
/// @throw InputError naming file, line, column and remedy; InputFaults where there are several.
TableReading readTable(const TextFile& file, const TableForm& form, const Machine& machine,
                       const Artifact* artifact, const ProgressCallback& progress = {});

/// The rows of a CSV in the import format taken as states of the machine, whatever was measured there.
struct StatesCsv {
  Session session;  // observations in the order of the file, `feature` -1 where it is not in the artifact
  std::string header;
  std::vector<std::string> lines;  // as written, one an observation
};

/// A reading that was not measured is NaN; without a column `time_s` all rows are at the session's start.
/// @param artifact may be null. @throw InputError as above.
StatesCsv readStatesCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress = {});

}  // namespace mm
