#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "import/column_mapping.h"
#include "import/import_faults.h"
#include "import/import_file.h"
#include "session/text_file.h"

namespace mm {

/// All that a format needs to make a session.
struct ImportContext {
  const TextFile& file;
  const ColumnMapping& mapping;
  const Machine& machine;
  const Artifact* artifact;  // null: none was given
  ImportFaults& faults;
  Imported& imported;
  std::vector<std::pair<int, double>> fixed = {};  // joints without a column, as the mapping says: m or rad

  void refuse(const std::string& what) const { faults.add(file.path().string() + ": " + what); }  ///< a fault
  /// A fault of one line (from 1).
  void refuse(std::size_t line, const std::string& what) const { faults.add(file.place(line) + what); }
  /// A line that the mapping lacks, for the sentence of the fault that it mends.
  std::string ask(const std::string& key, const std::string& value) const { return faults.ask(key, value); }
  void note(const std::string& text) const { imported.notes.push_back(text); }  ///< one line
};

/// A kind of file that is recognised by itself.
struct ImportFormat {
  const char* name;  // of --format
  const char* what;  // in a few words
  bool (*recognises)(const TextFile& file);
  void (*read)(ImportContext& context);  // fills imported.session, or adds faults
};

/// In the order in which they are tried; `table` takes what no other recognises.
const std::vector<ImportFormat>& importFormats();

/// TPoint data files: a caption, options (`:NODA`), the site, and a row a star until END: azimuth and
/// elevation of the star and of the telescope in degrees (four numbers), or right ascension and declination
/// of both and the sidereal time (fourteen).
bool isTPoint(const TextFile& file);
void readTPoint(ImportContext& context);
/// Console logs of printers that touch their bed. Klipper: PROBE_ACCURACY and `probe at x,y is z=`, a bed
/// mesh of printer.cfg; Marlin: `Bed X: Y: Z:` (G29, G30) and M48.
bool isKlipperLog(const TextFile& file);
bool isMarlinLog(const TextFile& file);
void readKlipperLog(ImportContext& context);
void readMarlinLog(ImportContext& context);
/// ISO 230-4: circles of a ball bar, angle (or time) and radius (or its deviation).
bool isBallBar(const TextFile& file);
void readBallBar(ImportContext& context);
/// R-test and five-axis pivots: the rotary axes turn about a ball, and where it seems to go is read, dx, dy
/// and dz in the frame `workpiece`.
bool isRTest(const TextFile& file);
void readRTest(ImportContext& context);
/// ISO 10360-2: faces of a step gauge, or length bars, along one linear joint: calibrated and indicated
/// lengths.
bool isGaugeLengths(const TextFile& file);
void readGaugeLengths(ImportContext& context);
/// ISO 230-2: targets by runs, in one or both directions of approach; deviations or measured positions.
/// Either a line a target and a column a run (`1+`, `1-`, `Run 2 ↓`), or as the standard prints it, a column
/// a target.
bool isPositioningTable(const TextFile& file);
void readPositioningTable(ImportContext& context);
/// Anybody's table: one row a measurement, columns by name.
void readAnyTable(ImportContext& context);

/// Makes a session ready: order, checks, assumed directions of travel; and the motions that tell a bag of the
/// directions of readings at standstill. @throw InputError as Session::prepare.
void finishImport(ImportContext& context, Session session);

/// A session without rows, from this file. @param byHead it begins at the date in the head of the file, where
/// there is one; false: its times say when.
Session emptySession(const ImportContext& context, bool byHead = true);

/// A row of this machine with nothing measured yet: joints at the mapping's `fixed` or 0. @param time s.
Observation blankRow(const ImportContext& context, ObservationKind kind, std::size_t line, double time);

/// Index of a setup, made when it is new.
int setupIndex(Session& session, const std::string& name);

/// The cells of a row: as many as there are columns.
std::vector<std::string> shownCells(const std::vector<std::string_view>& cells, std::size_t columns);

/// Whether one of the first lines has one of these words, `ball bar|iso 230-4` in small letters.
bool headHas(const TextFile& file, std::string_view words);

}  // namespace mm
