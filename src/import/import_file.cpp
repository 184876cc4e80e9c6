#include "import/import_file.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "import/date_in_head.h"
#include "import/import_format.h"
#include "import/meaning.h"
#include "session/assumed_travel.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

/// The form of a table whose header is that of the package's own format, and whose rows are written so.
std::optional<TableForm> asOwnFormat(const TextFile& file, const Machine& machine) {
  constexpr int kLooked = 50;  // lines
  std::optional<TableForm> form;
  std::vector<std::string_view> cells;
  int looked = 0;
  for (const std::string_view line : file.lines()) {
    if (trim(line).empty()) continue;
    if (isRemark(line) || !splitCells(line, cells)) return std::nullopt;
    try {
      if (!form) form = ownForm(file, machine);
    } catch (const InputError&) {
      return std::nullopt;
    }
    for (std::size_t k = 0; looked > 0 && k < std::min(cells.size(), form->columns.size()); ++k)
      if (form->columns[k].role == CsvRole::kTime && parseCalendar(cells[k])) return std::nullopt;
    if (++looked == kLooked) break;
  }
  if (form && !form->hasAny({CsvRole::kTime})) return std::nullopt;
  return form;
}

std::string ownUnit(const CsvColumn& c) {
  if (c.role == CsvRole::kTemperature || c.role == CsvRole::kCovariate) return c.unit;
  if (factsOf(c.role).quantity == RoleQuantity::kNone) return "";
  return parseUnit(splitUnit(c.header).unitText, std::nullopt).value_or(Unit{}).symbol;
}

/// The first rows below the header, for people.
void showOwnRows(const TextFile& file, const TableForm& form, Imported& imported) {
  std::vector<std::string_view> cells;
  for (std::size_t n = form.headerLine; n < file.lines().size() && imported.rows.size() < kRowsShown; ++n) {
    const std::string_view line = file.lines()[n];
    if (trim(line).empty() || !splitCells(line, cells, form.separator)) continue;
    imported.rows.push_back(shownCells(cells, form.columns.size()));
  }
}

/// The motion to each reading of which a direction of travel was told, not assumed. How fast the machine came
/// was not recorded; a bag tells directions by the sign of a velocity.
std::vector<MotionSample> motionTold(const Session& session) {
  constexpr double kDirectionOnly = 1e-9;
  std::vector<MotionSample> motion;
  const auto assumed = [&](int j) {
    return std::any_of(session.assumed.begin(), session.assumed.end(),
                       [&](const AssumedInput& a) { return a.joint == session.machine.joints()[j].name; });
  };
  double before = -1.0;
  for (const Observation& o : session.observations) {
    MotionSample sample;
    sample.time = 0.5 * (before + o.time);
    before = o.time;
    sample.position = o.position;
    sample.velocity.assign(o.position.size(), 0.0);
    bool any = false;
    for (int j = 0; j < session.machine.jointCount(); ++j) {
      const bool told = (o.velocity[j] == 0.0 || std::isnan(o.velocity[j])) && !assumed(j);
      if (!told || o.travel[j] == 0.0) continue;
      sample.velocity[j] = kDirectionOnly * o.travel[j];
      any = true;
    }
    if (any) motion.push_back(std::move(sample));
  }
  return motion;
}

void readOwn(const TextFile& file, const TableForm& form, const Machine& machine, const Artifact* artifact,
             Imported& imported, const ProgressCallback& progress) {
  refuseTooWide(file, form.headerLine, form.columns.size());
  imported.format = "table";
  imported.how = "the package's own columns";
  for (const CsvColumn& c : form.columns) {
    UnderstoodColumn seen;
    seen.name = seen.key = c.header;
    seen.meaning = meaningText(meaningOf(c, machine), machine);
    seen.unit = ownUnit(c);
    seen.from = seen.unit.empty() ? "" : "header";
    imported.columns.push_back(std::move(seen));
  }
  showOwnRows(file, form, imported);
  TableReading reading = readTable(file, form, machine, artifact, progress);
  for (std::size_t i = 0; i < form.columns.size(); ++i) {
    const ColumnRange& r = reading.ranges[i];
    imported.columns[i].lower = r.lower;
    imported.columns[i].upper = r.upper;
    imported.columns[i].first = r.first;
  }
  imported.motion = motionTold(reading.session);
  imported.session = std::move(reading.session);
}

ColumnMapping mappingOf(const ImportRequest& request) {
  if (!request.mappingText.empty()) return parseColumnMapping(request.mappingText, "mapping");
  return request.mapping.empty() ? ColumnMapping() : loadColumnMapping(request.mapping);
}

const ImportFormat& formatNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const ImportFormat& f : importFormats()) {
    if (name == f.name) return f;
    names.emplace_back(f.name);
  }
  throw InputError("--format: '" + shownText(name) + "' is not known (" + listOf(names) + ")" +
                   didYouMean(name, names));
}

std::string rangeText(const UnderstoodColumn& c) {
  return std::isnan(c.lower) ? "" : format("%.6g … %.6g", c.lower, c.upper);
}

/// A character of several bytes is one column on the screen.
std::size_t shownWidth(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

/// Rows of as many cells each under one another, with two blanks before each line.
std::string alignedText(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows[0].size(), 0);
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], shownWidth(row[k]));
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k)
      line += row[k] + std::string(widths[k] - shownWidth(row[k]) + 2, ' ');
    text += "  " + line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

/// Readings of joints without a column, m or rad.
std::vector<std::pair<int, double>> fixedReadings(const ColumnMapping& mapping, const Machine& machine,
                                                  ImportFaults& faults) {
  std::vector<std::pair<int, double>> fixed;
  for (const auto& [name, value] : mapping.fixed) {
    const NameAndUnit split = splitUnit(name);
    const int j = jointOf(machine, split.stem);
    const auto kind = j >= 0 ? unitKindOf(machine, j) : UnitKind::kLength;
    const auto unit = parseUnit(split.unitText, kind);
    if (j >= 0 && unit)
      fixed.emplace_back(j, value * unit->factor);
    else
      faults.add(mapping.source + ": fixed: '" + shownText(name) +
                 "' is not <joint>_<unit> of this machine (" + jointNames(machine) + "); e.g. fixed: {" +
                 machine.joints().front().name + "_mm: 12.5}");
  }
  return fixed;
}

}  // namespace

const std::vector<ImportFormat>& importFormats() {
  static const std::vector<ImportFormat> kFormats = {
      {"tpoint", "pointing data of a telescope mount, TPoint data file", isTPoint, readTPoint},
      {"klipper", "bed probing of a printer: PROBE_ACCURACY, probe at x,y, saved mesh", isKlipperLog,
       readKlipperLog},
      {"marlin", "bed probing of a printer: G29, G30, M48", isMarlinLog, readMarlinLog},
      {"ballbar", "circles of a ball bar, ISO 230-4", isBallBar, readBallBar},
      {"r-test", "R-test of rotary axes with a ball, dx, dy, dz", isRTest, readRTest},
      {"step-gauge", "step gauge or length bars along one axis, ISO 10360-2", isGaugeLengths,
       readGaugeLengths},
      {"iso230-2", "targets and runs, ISO 230-2", isPositioningTable, readPositioningTable},
      {"table", "one measurement per row, named columns", [](const TextFile&) { return true; }, readAnyTable},
  };
  return kFormats;
}

void importFile(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
                Imported& imported, const ProgressCallback& progress) {
  const ColumnMapping mapping = mappingOf(request);
  const std::string wanted = !request.format.empty() ? request.format : mapping.format;
  const ImportFormat* chosen = wanted.empty() ? nullptr : &formatNamed(wanted);
  const TextFile file = request.content ? TextFile(request.file, *request.content) : TextFile(request.file);
  const std::size_t shown = std::min(kLinesShown, file.lines().size());
  for (std::size_t n = 0; n < shown; ++n) imported.head.emplace_back(file.lines()[n]);
  if (mapping.source.empty() && (wanted.empty() || wanted == "table"))
    if (const auto form = asOwnFormat(file, machine))
      return readOwn(file, *form, machine, artifact, imported, progress);
  for (const ImportFormat& f : importFormats())
    if (chosen == nullptr && f.recognises(file)) chosen = &f;
  imported.format = chosen->name;
  ImportFaults faults;
  ImportContext context{file, mapping, machine, artifact, faults, imported};
  context.fixed = fixedReadings(mapping, machine, faults);
  faults.throwIfAny();  // what is read at wrong places would only bring faults that are none
  chosen->read(context);
  imported.lacks = faults.lines();
  faults.throwIfAny();
  if (progress) progress(1.0);
}

std::string understoodText(const Imported& imported) {
  std::string text =
      "format        " + imported.format + (imported.how.empty() ? "" : ": " + imported.how) + "\n";
  std::vector<std::vector<std::string>> rows = {{"column", "is", "unit", "range", "first"}};
  for (const UnderstoodColumn& c : imported.columns)
    rows.push_back({c.name, c.meaning,
                    c.unit + (c.from.empty() || c.from == "header" ? "" : " (" + c.from + ")"), rangeText(c),
                    c.first});
  if (rows.size() > 1) text += alignedText(rows);
  for (const std::string& note : imported.notes) text += "note: " + note + "\n";
  return text;
}

std::string firstRowsText(const Imported& imported) {
  std::vector<std::vector<std::string>> rows = imported.rows;
  if (rows.empty())
    for (const std::string& line : imported.head) rows.push_back({line});
  else
    rows.insert(rows.begin(), allNames(imported.columns));
  return rows.empty() ? "" : "first rows\n" + alignedText(rows);
}

void finishImport(ImportContext& context, Session session) {
  if (session.observations.empty()) return context.refuse("no row holds a measurement");
  session.prepare();
  assumeTravel(session);
  context.imported.motion = motionTold(session);
  context.imported.session = std::move(session);
}

std::vector<std::string> shownCells(const std::vector<std::string_view>& cells, std::size_t columns) {
  std::vector<std::string> shown(columns);
  for (std::size_t i = 0; i < std::min(columns, cells.size()); ++i) shown[i] = cells[i];
  return shown;
}

bool headHas(const TextFile& file, std::string_view words) {
  constexpr std::size_t kHead = 15;  // lines
  for (std::size_t i = 0; i < std::min(kHead, file.lines().size()); ++i) {
    const std::string line = lower(file.lines()[i]);
    for (const std::string_view word : wordsIn(words, "|"))
      if (line.find(word) != std::string::npos) return true;
  }
  return false;
}

int setupIndex(Session& session, const std::string& name) {
  const auto at = std::find(session.setups.begin(), session.setups.end(), name);
  const auto index = static_cast<int>(at - session.setups.begin());
  if (at == session.setups.end()) session.setups.push_back(name);
  return index;
}

Observation blankRow(const ImportContext& context, ObservationKind kind, std::size_t line, double time) {
  const auto joints = static_cast<std::size_t>(context.machine.jointCount());
  Observation o;
  o.kind = kind;
  o.row = static_cast<std::int64_t>(line);
  o.time = time;
  o.position.assign(joints, 0.0);
  o.velocity.assign(joints, kNotMeasured);
  o.travel.assign(joints, 0.0);
  if (kind == ObservationKind::kDeviation) {
    o.deviation.assign(joints, kNotMeasured);
    o.deviationStd.assign(joints, kNotMeasured);
  }
  for (const auto& [joint, reading] : context.fixed) o.position[static_cast<std::size_t>(joint)] = reading;
  return o;
}

Session emptySession(const ImportContext& context, bool byHead) {
  Session session(context.machine);
  session.source = context.file.path().string();
  session.rowFile = context.file.path().filename().string();
  session.epoch = static_cast<double>(kImportEpoch);
  if (byHead) session.epoch = dateInHead(context).value_or(session.epoch);
  if (context.artifact != nullptr) session.artifact = *context.artifact;
  return session;
}

}  // namespace mm
