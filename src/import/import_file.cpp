#include "import/import_file.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "import/import_format.h"
#include "import/meaning.h"
#include "session/assumed_travel.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

/// A table whose header is that of the package's own format, and whose rows are written so.
bool isOwnFormat(const std::filesystem::path& file, const Machine& machine) {
  LineReader lines(file);
  std::string_view line;
  std::vector<std::string_view> cells;
  std::vector<CsvColumn> columns;
  constexpr int kLooked = 50;
  for (int i = 0; i < kLooked && lines.next(line);) {
    if (trim(line).empty()) continue;
    ++i;
    std::string remark;
    if (takeRemark(line, remark) || !splitCells(line, cells)) return false;
    if (columns.empty()) {
      try {
        columns = parseCsvHeader({cells.begin(), cells.end()}, machine, "");
      } catch (const InputError&) {
        return false;
      }
      if (std::none_of(columns.begin(), columns.end(),
                       [](const CsvColumn& c) { return c.role == CsvRole::kTime; }))
        return false;
      continue;
    }
    for (std::size_t k = 0; k < std::min(cells.size(), columns.size()); ++k)
      if (columns[k].role == CsvRole::kTime && parseCalendar(cells[k])) return false;
  }
  return !columns.empty();
}

std::string ownUnit(const CsvColumn& c) {
  if (c.role == CsvRole::kFeature || c.role == CsvRole::kSetup || c.role == CsvRole::kPlacement ||
      c.role == CsvRole::kStylus)
    return "";
  if (c.role == CsvRole::kTemperature || c.role == CsvRole::kCovariate) return c.unit;
  return parseUnit(splitUnit(c.header).unitText, std::nullopt).value_or(Unit{}).symbol;
}

void readOwn(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
             Imported& imported, const ProgressCallback& progress) {
  imported.format = "table";
  imported.how = "the package's own columns";
  std::vector<CsvColumn> columns;
  TableReading reading = readOwnTable(request.file, machine, artifact, columns, progress);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const ColumnRange& r = reading.ranges[i];
    UnderstoodColumn seen;
    seen.name = columns[i].header;
    seen.meaning = meaningText(meaningOf(columns[i], machine), machine);
    seen.unit = ownUnit(columns[i]);
    seen.from = seen.unit.empty() ? "" : "header";
    seen.first = r.first;
    seen.lower = r.lower;
    seen.upper = r.upper;
    imported.columns.push_back(std::move(seen));
  }
  imported.session = std::move(reading.session);
}

const ImportFormat& formatNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const ImportFormat& f : importFormats()) {
    if (name == f.name) return f;
    names.emplace_back(f.name);
  }
  throw InputError("--format: '" + name + "' is not known (" + listOf(names) + ")" + didYouMean(name, names));
}

std::string rangeText(const UnderstoodColumn& c) {
  return std::isnan(c.lower) ? "" : format("%.6g … %.6g", c.lower, c.upper);
}

/// A character of several bytes is one column on the screen.
std::size_t shownWidth(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width) {
  const std::size_t shown = shownWidth(text);
  return text + std::string(shown < width ? width - shown : 0, ' ');
}

}  // namespace

void importFile(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
                Imported& imported, const ProgressCallback& progress) {
  ColumnMapping mapping;
  if (!request.mapping.empty()) mapping = loadColumnMapping(request.mapping);
  const std::string wanted = !request.format.empty() ? request.format : mapping.format;
  const ImportFormat* chosen = wanted.empty() ? nullptr : &formatNamed(wanted);
  if (mapping.source.empty() && (wanted.empty() || wanted == "table") && isOwnFormat(request.file, machine)) {
    readOwn(request, machine, artifact, imported, progress);
    return;
  }
  const TextFile file(request.file);
  for (const ImportFormat& f : importFormats())
    if (chosen == nullptr && f.recognises(file)) chosen = &f;
  imported.format = chosen->name;
  FaultList faults;
  ImportContext context{file, mapping, machine, artifact, faults, imported};
  chosen->read(context);
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
  if (rows.size() > 1) {
    std::vector<std::size_t> widths(rows[0].size(), 0);
    for (const auto& row : rows)
      for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], shownWidth(row[k]));
    for (const auto& row : rows) {
      std::string line;
      for (std::size_t k = 0; k < row.size(); ++k) line += padded(row[k], widths[k] + 2);
      text += "  " +
              std::string(line.begin(), line.begin() + static_cast<long>(line.find_last_not_of(' ') + 1)) +
              "\n";
    }
  }
  for (const std::string& note : imported.notes) text += "note: " + note + "\n";
  return text;
}

void finishImport(ImportContext& context, Session session) {
  if (session.observations.empty()) {
    context.faults.add(context.file.path().string() + ": no row holds a measurement");
    return;
  }
  session.prepare();
  assumeTravel(session);
  const auto assumed = [&](int j) {
    return std::any_of(session.assumed.begin(), session.assumed.end(),
                       [&](const AssumedInput& a) { return a.joint == session.machine.joints()[j].name; });
  };
  double before = -1.0;
  for (const Observation& o : session.observations) {
    // How fast the machine came to the target was not recorded; a bag tells directions by the sign of a
    // velocity.
    constexpr double kDirectionOnly = 1e-9;
    MotionSample sample;
    sample.time = 0.5 * (before + o.time);
    before = o.time;
    sample.position = o.position;
    sample.velocity.assign(o.position.size(), 0.0);
    bool any = false;
    for (int j = 0; j < session.machine.jointCount(); ++j) {
      const bool told = o.velocity[j] == 0.0 || (std::isnan(o.velocity[j]) && !assumed(j));
      if (!told || o.travel[j] == 0.0) continue;
      sample.velocity[j] = kDirectionOnly * o.travel[j];
      any = true;
    }
    if (any) context.imported.motion.push_back(std::move(sample));
  }
  context.imported.session = std::move(session);
}

Session emptySession(const ImportContext& context) {
  Session session(context.machine);
  session.source = context.file.path().string();
  session.rowFile = context.file.path().filename().string();
  session.epoch = static_cast<double>(kImportEpoch);
  if (context.artifact != nullptr) session.artifact = *context.artifact;
  return session;
}

}  // namespace mm
