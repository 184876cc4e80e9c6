#include "session/contacts_csv.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/numbered_names.h"
#include "base/text.h"
#include "session/assumed_travel.h"
#include "session/csv_cells.h"
#include "session/csv_row.h"
#include "session/feature_names.h"
#include "session/input_faults.h"
#include "session/row_clock.h"
#include "session/session_time.h"
#include "session/travel.h"

namespace mm {
namespace {

constexpr double kLargestTime = 3e9;    // s; with the epoch it still fits a ROS stamp
constexpr double kSmallestTime = -9e8;  // s

/// Turns the rows of one file into observations and series.
class CsvReader {
 public:
  /// The package's own columns.
  CsvReader(LineSource& lines, const std::filesystem::path& file, const Machine& machine,
            const Artifact* artifact, bool statesOnly)
      : lines_(lines), states_(machine), hasArtifact_(artifact != nullptr), statesOnly_(statesOnly) {
    begin(file, artifact);
    readHeader();
  }

  /// Somebody else's table.
  CsvReader(LineSource& lines, const TableForm& form, const std::filesystem::path& file,
            const Machine& machine, const Artifact* artifact)
      : lines_(lines),
        states_(machine),
        hasArtifact_(artifact != nullptr),
        statesOnly_(false),
        foreign_(true),
        form_(form) {
    begin(file, artifact);
    columns_ = form.columns;
    std::string_view line;
    while (lines_.number() < form.headerLine && lines_.next(line)) {
    }
    readColumns();
    for (const auto& [joint, value] : form.fixed) zeroUnlessColumn_[joint] = value;
  }

  StatesCsv read(const ProgressCallback& progress) {
    constexpr std::size_t kHopeless = 1000;  // faults
    std::string_view line;
    while (faults_.count() < kHopeless && lines_.next(line)) {
      if (trim(line).empty() || (foreign_ && isRemark(line))) continue;
      try {
        readRow(line);
      } catch (const InputError& e) {
        faults_.add(e.what());
      }
      if (progress && lines_.number() % 8192 == 0) progress(lines_.fraction());
    }
    faults_.throwIfAny();
    states_.session.setups = setups_.all();
    states_.session.placements = placements_.all();
    countTimeFromStart();
    if (progress) progress(1.0);
    return std::move(states_);
  }

  const std::vector<CsvColumn>& columns() const { return columns_; }
  std::vector<ColumnRange> ranges() { return std::move(ranges_); }
  std::vector<std::string> notes() { return std::move(notes_); }

 private:
  void begin(const std::filesystem::path& file, const Artifact* artifact) {
    Session& session = states_.session;
    session.source = file.string();
    session.rowFile = file.filename().string();
    if (artifact != nullptr) session.artifact = *artifact;
    features_.take(session.artifact, foreign_, form_.features);
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(states_.session.source + ":" + std::to_string(lines_.number()) + ": " + what);
  }

  void readHeader() {
    std::string_view line;
    do {
      if (!lines_.next(line))
        throw InputError(states_.session.source + ": is empty; the first line must name the columns");
    } while (line.find_first_not_of(" \t") == std::string_view::npos);
    states_.header = std::string(line);
    if (!splitCells(line, cells_)) fail("a quote is not closed, or text follows it");
    columns_ = parseCsvHeader({cells_.begin(), cells_.end()}, states_.session.machine,
                              states_.session.source + ":" + std::to_string(lines_.number()));
    readColumns();
  }

  void readColumns() {
    const auto has = [&](CsvRole role) {
      return std::any_of(columns_.begin(), columns_.end(),
                         [&](const CsvColumn& c) { return c.role == role; });
    };
    hasTime_ = has(CsvRole::kTime);
    hasDate_ = has(CsvRole::kDate);
    hasPlacement_ = has(CsvRole::kPlacement);
    ranges_.resize(columns_.size());
    if (!hasTime_ && !statesOnly_ && !foreign_) fail("column 'time_s' is missing");
    if (has(CsvRole::kFeature) && !hasArtifact_ && !statesOnly_)
      fail("column 'feature' needs an artifact that says what the features are; give one with --artifact");
    hasDeviation_ = has(CsvRole::kDeviation) || has(CsvRole::kDeviationStd) || has(CsvRole::kMeasured);
    const std::size_t joints = states_.session.machine.joints().size();
    zeroUnlessColumn_.assign(joints, 0.0);
    for (const CsvColumn& c : columns_) {
      if (c.role == CsvRole::kPosition) zeroUnlessColumn_[c.index] = kNotMeasured;
      if (c.role == CsvRole::kTemperature) states_.session.temperatures.push_back({c.name, c.unit, {}, {}});
      if (c.role == CsvRole::kCovariate) states_.session.covariates.push_back({c.name, c.unit, {}, {}});
    }
    temperatures_.resize(states_.session.temperatures.size());
    covariates_.resize(states_.session.covariates.size());
  }

  /// The cell times the column's factor. @param index of the column.
  double number(std::string_view cell, std::size_t index) {
    const CsvColumn& column = columns_[index];
    double value = 0.0;
    const bool read = foreign_ ? parseNumber(withoutUnit(cell, column.suffix), form_.decimalComma, value)
                               : parsePlainNumber(cell, value);
    if (!read)
      fail("column '" + column.header + "': '" + std::string(cell) + "' is not a finite number" +
           (form_.decimalComma ? " (with a decimal comma)" : "") +
           "; leave the cell empty where nothing was measured");
    ranges_[index].add(cell, value);
    return value * column.factor + column.offset;
  }

  /// Of a foreign table: empty cells at the end do not count; a line of words between the rows is none.
  bool fitCells(std::string_view line) {
    while (cells_.size() > columns_.size() && cells_.back().empty()) cells_.pop_back();
    const auto first = std::find_if(cells_.begin(), cells_.end(), [](auto c) { return !c.empty(); });
    if (first == cells_.end()) return false;
    const bool words = cells_.size() < columns_.size() && cells_.size() <= 2 &&
                       line.find_first_of("0123456789") == std::string_view::npos;
    if (words || (sumsUp(cells_) && !features_.has(*first))) {
      notes_.push_back("line " + std::to_string(lines_.number()) + " is no row and was left out: '" +
                       std::string(line.substr(0, 60)) + "'");
      return false;
    }
    return true;
  }

  void readRow(std::string_view line) {
    if (!splitCells(line, cells_, form_.separator)) fail("a quote is not closed, or text follows it");
    if (foreign_ && !fitCells(line)) return;
    if (cells_.size() != columns_.size())
      fail(std::to_string(cells_.size()) + " cells, but the header names " + std::to_string(columns_.size()) +
           " columns");
    Session& session = states_.session;
    const std::size_t joints = zeroUnlessColumn_.size();
    Observation o;
    o.row = lines_.number();
    if (hasPlacement_) o.placement = placements_[""];
    o.position = zeroUnlessColumn_;
    o.velocity.assign(joints, kNotMeasured);
    if (hasDeviation_) {
      o.deviation.assign(joints, kNotMeasured);
      o.deviationStd.assign(joints, kNotMeasured);
    }
    RowKinds kinds;
    const std::size_t before = faults_.count();
    const std::int64_t stamp = timeOf();
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const bool direction = columns_[i].role == CsvRole::kDirection;
      if (cells_[i].empty() || (foreign_ && !direction && meansNothing(cells_[i]))) continue;
      try {
        readCell(cells_[i], i, stamp, o, kinds);
      } catch (const InputError& e) {
        faults_.add(e.what());
      }
    }
    if (faults_.count() > before) return;
    if (foreign_) finishMeasured(o);
    if (form_.onlyFeature >= 0) o.feature = form_.onlyFeature, kinds.feature = true;
    if (statesOnly_) {
      states_.lines.emplace_back(line);
    } else if (kinds.logsOnly()) {
      return;
    } else if (const std::string fault = rowFault(o, kinds, session.machine); !fault.empty()) {
      fail(fault);
    }
    setKind(o, kinds);
    stamps_.push_back(stamp);
    session.observations.push_back(std::move(o));
  }

  /// What was measured minus the target is the deviation (ISO 230-2).
  void finishMeasured(Observation& o) const {
    for (const CsvColumn& c : columns_)
      if (c.role == CsvRole::kMeasured) o.deviation[c.index] -= o.position[c.index];
  }

  /// Nanoseconds on the file's own clock.
  std::int64_t timeOf() {
    std::int64_t stamp = static_cast<std::int64_t>(stamps_.size());  // keeps the order of rows without a time
    if (foreign_ && !hasTime_ && !hasDate_) stamp = rows_ * 1000000000;  // a second apart
    ++rows_;
    if (hasTime_ || hasDate_) stamp = 0;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const CsvColumn& column = columns_[i];
      if (column.role != CsvRole::kTime && column.role != CsvRole::kDate) continue;
      if (cells_[i].empty()) fail("column '" + column.header + "' is empty");
      if (column.timeForm == TimeForm::kNumber && column.role == CsvRole::kTime) {
        const double time = number(cells_[i], i);
        if (time < kSmallestTime || time > kLargestTime)
          fail("column '" + column.header + "': " + std::string(cells_[i]) +
               " s is outside -9e8 … 3e9 s; is it in seconds?");
        stamp += std::llround(time * 1e9);
        continue;
      }
      const auto read = RowClock::read(column.timeForm, cells_[i]);
      if (!read)
        fail("column '" + column.header + "': '" + std::string(cells_[i]) + "' is not a " +
             (column.timeForm == TimeForm::kClock
                  ? "time of day (10:15:03)"
                  : "calendar time (2026-11-21T10:15:03, 21.11.2026 10:15:03)") +
             " as in the rows before; correct it, or leave the row out");
      ranges_[i].add(cells_[i]);
      stamp += *read;
      if (column.timeForm == TimeForm::kClock && !hasDate_) stamp = clock_.afterMidnight(stamp);
    }
    clock_.saw(stamp);
    return stamp;
  }

  void readCell(std::string_view cell, std::size_t index, std::int64_t stamp, Observation& o,
                RowKinds& kinds) {
    Session& session = states_.session;
    const CsvColumn& column = columns_[index];
    switch (column.role) {
      case CsvRole::kTime:
      case CsvRole::kDate:
        break;
      case CsvRole::kIgnored:
        ranges_[index].add(cell);
        break;
      case CsvRole::kDirection: {
        ranges_[index].add(cell);
        const double direction = directionOf(cell);
        if (direction == 0.0)
          fail("column '" + column.header + "': '" + std::string(cell) +
               "' is no direction; write + or - (up and down, forward and reverse, 1 and -1 are understood)");
        o.travel.resize(zeroUnlessColumn_.size(), 0.0);
        o.travel[column.index] = direction;
        o.velocity[column.index] = 0.0;  // read at standstill
        break;
      }
      case CsvRole::kPosition:
        o.position[column.index] = number(cell, index);
        break;
      case CsvRole::kVelocity:
        o.velocity[column.index] = number(cell, index);
        break;
      case CsvRole::kReading:
        o.laserReading = number(cell, index);
        break;
      case CsvRole::kFeature: {
        kinds.feature = true;
        ranges_[index].add(cell);
        o.feature = features_.find(cell);
        if (o.feature < 0 && !statesOnly_) fail(features_.fault(cell, session.artifact));
        break;
      }
      case CsvRole::kLength:
        kinds.length = true;
        o.length = number(cell, index);
        break;
      case CsvRole::kReference:
        kinds.reference = true;
        o.reference[column.index] = number(cell, index);
        break;
      case CsvRole::kMeasured:  // finishMeasured takes the target off
      case CsvRole::kDeviation:
        kinds.deviation = true;
        o.deviation[column.index] = number(cell, index);
        break;
      case CsvRole::kDeviationStd:
        o.deviationStd[column.index] = number(cell, index);
        if (o.deviationStd[column.index] <= 0.0)
          fail("column '" + column.header + "': " + std::string(cell) + " must be above 0");
        break;
      case CsvRole::kSetup:
        kinds.setup = true;
        ranges_[index].add(cell);
        o.setup = setups_[cell];
        break;
      case CsvRole::kPlacement:
        ranges_[index].add(cell);
        o.placement = placements_[cell];
        break;
      case CsvRole::kStylus:
        ranges_[index].add(cell);
        o.stylus = session.artifact.findStylus(std::string(cell));
        if (o.stylus < 0) fail(stylusFault(cell));
        break;
      case CsvRole::kTemperature:
        kinds.logged = true;
        temperatures_.add(column.index, stamp, number(cell, index));
        break;
      case CsvRole::kCovariate:
        kinds.logged = true;
        covariates_.add(column.index, stamp, number(cell, index));
        break;
    }
  }

  std::string stylusFault(std::string_view cell) const {
    std::vector<std::string> known;
    for (const Stylus& s : states_.session.artifact.styli) known.push_back(s.name);
    return "stylus '" + std::string(cell) + "' is not in the artifact file" +
           (known.empty()
                ? "; name it there: probe: {styli: [{name: " + std::string(cell) + ", tip_radius_mm: …}, …]}"
                : didYouMean(std::string(cell), known) + "; it names " + listOf(known));
  }

  void countTimeFromStart() {
    Session& session = states_.session;
    const std::int64_t zero = form_.absoluteTime ? 0 : kImportEpoch;
    session.epoch = static_cast<double>(zero) + secondsBetween(0, clock_.earliest());
    for (std::size_t i = 0; i < stamps_.size(); ++i)
      session.observations[i].time = secondsBetween(clock_.earliest(), stamps_[i]);
    temperatures_.fill(session.temperatures, clock_.earliest());
    covariates_.fill(session.covariates, clock_.earliest());
  }

  LineSource& lines_;
  StatesCsv states_;
  bool hasArtifact_, statesOnly_, foreign_ = false;
  TableForm form_;
  FaultList faults_;
  std::vector<ColumnRange> ranges_;
  std::vector<std::string> notes_;
  std::int64_t rows_ = 0;
  bool hasDate_ = false, hasTime_ = false, hasDeviation_ = false, hasPlacement_ = false;
  std::vector<CsvColumn> columns_;
  std::vector<std::string_view> cells_;
  std::vector<double>
      zeroUnlessColumn_;  // readings of a row before its cells: a joint without a column stays at 0
  FeatureNames features_;
  NumberedNames setups_, placements_;
  std::vector<std::int64_t> stamps_;  // of the observations, ns on the file's own clock
  RowClock clock_;
  LoggedSeries temperatures_, covariates_;
};

/// Whatever it was written in: a session must hold a measurement, and each laser contact its reading.
void finish(Session& session, const std::filesystem::path& file, const Artifact* artifact) {
  if (session.observations.empty())
    throw InputError(file.string() + ": no row holds a measurement (feature, reference or deviation)");
  if (artifact != nullptr && artifact->tipRadius == 0.0 && artifact->styli.empty() && session.hasLaser())
    for (const Observation& o : session.observations)
      if (o.kind == ObservationKind::kContact && std::isnan(o.laserReading))
        throw InputError(
            file.string() + ": line " + std::to_string(o.row) +
            ": reading_mm is empty: the beam missed, or was out of the laser's range; leave the row "
            "out (or state the artifact's tip_radius_mm, if a touch probe was used there)");
  session.prepare();
  assumeTravel(session);
}

}  // namespace

void ColumnRange::add(std::string_view cell) {
  if (count++ == 0) first = std::string(cell);
}

void ColumnRange::add(std::string_view cell, double value) {
  lower = std::min(count == 0 ? value : lower, value);
  upper = std::max(count == 0 ? value : upper, value);
  add(cell);
}

Session readContactsCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress) {
  std::vector<CsvColumn> columns;
  return readOwnTable(file, machine, artifact, columns, progress).session;
}

TableReading readOwnTable(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                          std::vector<CsvColumn>& columns, const ProgressCallback& progress) {
  LineReader lines(file);
  CsvReader reader(lines, file, machine, artifact, false);
  columns = reader.columns();
  Session session = reader.read(progress).session;
  finish(session, file, artifact);
  return {std::move(session), reader.ranges(), reader.notes()};
}

TableReading readTable(LineSource& lines, const TableForm& form, const std::filesystem::path& file,
                       const Machine& machine, const Artifact* artifact, const ProgressCallback& progress) {
  CsvReader reader(lines, form, file, machine, artifact);
  Session session = reader.read(progress).session;
  finish(session, file, artifact);
  return {std::move(session), reader.ranges(), reader.notes()};
}

StatesCsv readStatesCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress) {
  LineReader lines(file);
  StatesCsv states = CsvReader(lines, file, machine, artifact, true).read(progress);
  if (states.lines.empty()) throw InputError(file.string() + ": no row below the header");
  deriveTravel(states.session.observations, machine.jointCount());
  return states;
}

}  // namespace mm
