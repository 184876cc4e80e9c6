#include "session/contacts_csv.h"

#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/numbered_names.h"
#include "base/text.h"
#include "session/assumed_travel.h"
#include "session/csv_cells.h"
#include "session/input_faults.h"
#include "session/table_rows.h"
#include "session/time_stamp.h"
#include "session/travel_tracker.h"

namespace mm {
namespace {

constexpr double kLargestTime = 3e9;    // s; with the epoch it still fits a ROS stamp
constexpr double kSmallestTime = -9e8;  // s
const char* const kOpenQuote = "a quote is not closed, or text follows it";

/// Turns the rows of one file into observations and series.
class TableReader {
 public:
  /// @param states gets the lines of the rows, which are states of the machine; null: they are measurements.
  TableReader(const TextFile& file, const TableForm& form, const Machine& machine, const Artifact* artifact,
              StatesCsv* states)
      : file_(file),
        form_(form),
        states_(states),
        line_(form.headerLine),
        session_(machine),
        features_(artifact != nullptr ? *artifact : session_.artifact, form) {
    session_.source = file.path().string();
    session_.rowFile = file.path().filename().string();
    if (artifact != nullptr) session_.artifact = *artifact;
    readColumns(artifact != nullptr);
  }

  TableReading read(const ProgressCallback& progress) {
    constexpr std::size_t kHopeless = 1000;  // faults
    const auto& lines = file_.lines();
    while (faults_.count() < kHopeless && line_ < lines.size()) {
      const std::string_view line = lines[line_++];
      if (trim(line).empty() || (!form_.own && isRemark(line))) continue;
      CancelScope::check();
      collect([&] { readRow(line); });
      if (progress && line_ % 8192 == 0)
        progress(static_cast<double>(line_) / static_cast<double>(lines.size()));
    }
    faults_.throwIfAny();
    session_.setups = setups_.all();
    session_.placements = placements_.all();
    countTimeFromStart();
    if (progress) progress(1.0);
    return {std::move(session_), std::move(ranges_), std::move(notes_)};
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file_.place(line_) + what); }
  [[noreturn]] void fail(const CsvColumn& column, const std::string& what) const {
    fail("column '" + shownText(column.header) + "'" + what);
  }

  /// Faults of rows and cells are collected, so that they can be corrected at once.
  template <typename Read>
  void collect(const Read& read) {
    try {
      read();
    } catch (const InputError& e) {
      faults_.add(e.what());
    }
  }

  /// What no row can have is said once.
  void checkMeasured() const {
    if (form_.hasAny({CsvRole::kFeature})) return;
    if (form_.hasAny({CsvRole::kLength}))
      fail(
          "column 'feature' is missing: it names the point of the artifact file from which 'length_mm' was "
          "measured");
    if (!form_.hasAny({CsvRole::kReference, CsvRole::kDeviation, CsvRole::kMeasured}))
      fail(
          "no column holds a measurement; add 'feature' (balls that were touched), 'reference_x_mm' … (true "
          "positions), '" +
          columnName(CsvRole::kDeviation, 0, "", session_.machine) +
          "' … (true minus indicated) or 'length_mm'");
  }

  void readColumns(bool hasArtifact) {
    hasDate_ = form_.hasAny({CsvRole::kDate});
    hasTime_ = form_.hasAny({CsvRole::kTime}) || hasDate_;
    if (!hasTime_) session_.timesAssumed = kTimesInOrder;
    hasPlacement_ = form_.hasAny({CsvRole::kPlacement});
    hasDeviation_ = form_.hasAny({CsvRole::kDeviation, CsvRole::kDeviationStd, CsvRole::kMeasured});
    if (!hasTime_ && states_ == nullptr && form_.own) fail("column 'time_s' is missing");
    if (form_.hasAny({CsvRole::kFeature}) && !hasArtifact && states_ == nullptr)
      fail("column 'feature' needs an artifact that says what the features are; give one with --artifact");
    if (states_ == nullptr && form_.onlyFeature < 0) checkMeasured();
    ranges_.resize(form_.columns.size());
    zeroUnlessColumn_.assign(session_.machine.joints().size(), 0.0);
    for (const CsvColumn& c : form_.columns) {
      if (c.role == CsvRole::kPosition) zeroUnlessColumn_[c.index] = kNotMeasured;
      if (c.role == CsvRole::kTemperature) session_.temperatures.push_back({c.name, c.unit, {}, {}});
      if (c.role == CsvRole::kCovariate) session_.covariates.push_back({c.name, c.unit, {}, {}});
    }
    for (const auto& [joint, value] : form_.fixed) zeroUnlessColumn_[joint] = value;
  }

  /// The cell times the column's factor. @param index of the column.
  double number(std::string_view cell, std::size_t index) {
    const CsvColumn& column = form_.columns[index];
    double value = 0.0;
    const bool read = form_.own ? parsePlainNumber(cell, value)
                                : parseNumber(withoutUnit(cell, column.suffix), form_.decimalComma, value);
    if (!read)
      fail(column, ": '" + shownText(cell) + "' is not a finite number" +
                       (form_.decimalComma ? " (with a decimal comma)" : "") +
                       "; leave the cell empty where nothing was measured");
    ranges_[index].add(cell, value);
    return value * column.factor + column.offset;
  }

  /// Of a foreign table: empty cells at the end do not count; a line of words between the rows is none.
  bool fitCells(std::string_view line) {
    while (cells_.size() > form_.columns.size() && cells_.back().empty()) cells_.pop_back();
    const auto first = std::find_if(cells_.begin(), cells_.end(), [](auto c) { return !c.empty(); });
    if (first == cells_.end()) return false;
    const bool words = cells_.size() < form_.columns.size() && cells_.size() <= 2 &&
                       line.find_first_of("0123456789") == std::string_view::npos;
    if (words || (sumsUp(cells_) && features_.find(*first) < 0)) {
      notes_.push_back("line " + std::to_string(line_) + " is not a data row and was skipped: '" +
                       shownText(trim(line)) + "'");
      return false;
    }
    return true;
  }

  void readRow(std::string_view line) {
    if (!splitCells(line, cells_, form_.separator)) fail(kOpenQuote);
    if (!form_.own && !fitCells(line)) return;
    if (cells_.size() != form_.columns.size())
      fail(std::to_string(cells_.size()) + " cells, but the header names " +
           std::to_string(form_.columns.size()) + " columns");
    Observation o;
    o.row = static_cast<std::int64_t>(line_);
    if (hasPlacement_) o.placement = placements_[""];
    o.position = zeroUnlessColumn_;
    o.velocity.assign(o.position.size(), kNotMeasured);
    if (hasDeviation_) o.deviation = o.deviationStd = o.velocity;
    RowKinds kinds;
    const std::size_t before = faults_.count();
    const std::int64_t stamp = timeOf();
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const bool direction = form_.columns[i].role == CsvRole::kDirection;
      if (cells_[i].empty() || (!form_.own && !direction && meansNothing(cells_[i]))) continue;
      collect([&] { readCell(cells_[i], i, stamp, o, kinds); });
    }
    if (faults_.count() > before) return;
    for (const CsvColumn& c :
         form_.columns)  // what was measured minus the target is the deviation (ISO 230-2)
      if (c.role == CsvRole::kMeasured) o.deviation[c.index] -= o.position[c.index];
    if (form_.onlyFeature >= 0) o.feature = form_.onlyFeature, kinds.feature = true;
    if (states_ != nullptr)
      states_->lines.emplace_back(line);
    else if (kinds.logsOnly())
      return;
    else if (const std::string fault = rowFault(o, kinds, session_.machine); !fault.empty())
      fail(fault);
    setKind(o, kinds);
    stamps_.push_back(stamp);
    session_.observations.push_back(std::move(o));
  }

  /// Nanoseconds on the file's own clock.
  std::int64_t timeOf() {
    std::int64_t stamp = static_cast<std::int64_t>(stamps_.size());  // keeps the order of rows without a time
    if (!form_.own) stamp = rows_ * 1000000000;                      // a second apart
    if (hasTime_) stamp = 0;
    ++rows_;
    for (std::size_t i = 0; i < form_.columns.size(); ++i) {
      const CsvColumn& column = form_.columns[i];
      if (column.role != CsvRole::kTime && column.role != CsvRole::kDate) continue;
      if (cells_[i].empty()) fail(column, " is empty");
      if (column.timeForm == TimeForm::kNumber && column.role == CsvRole::kTime) {
        const double time = number(cells_[i], i);
        if (time < kSmallestTime || time > kLargestTime)
          fail(column, ": " + shownText(cells_[i]) + " s is outside -9e8 … 3e9 s; is it in seconds?");
        stamp += std::llround(time * 1e9);
        continue;
      }
      const auto read = parseTime(column.timeForm, cells_[i]);
      if (!read)
        fail(column, ": '" + shownText(cells_[i]) + "' is not a " +
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

  /// Where the number of a column goes; null: it holds none of the row itself.
  static double* numberOf(const CsvColumn& column, Observation& o, RowKinds& kinds) {
    switch (column.role) {
      case CsvRole::kPosition:
        return &o.position[column.index];
      case CsvRole::kVelocity:
        return &o.velocity[column.index];
      case CsvRole::kReading:
        return &o.laserReading;
      case CsvRole::kLength:
        kinds.length = true;
        return &o.length;
      case CsvRole::kReference:
        kinds.reference = true;
        return &o.reference[column.index];
      case CsvRole::kMeasured:  // readRow takes the target off
      case CsvRole::kDeviation:
        kinds.deviation = true;
        return &o.deviation[column.index];
      case CsvRole::kDeviationStd:
        return &o.deviationStd[column.index];
      default:
        return nullptr;
    }
  }

  void readCell(std::string_view cell, std::size_t index, std::int64_t stamp, Observation& o,
                RowKinds& kinds) {
    const CsvColumn& column = form_.columns[index];
    if (column.role == CsvRole::kTime || column.role == CsvRole::kDate) return;
    if (double* value = numberOf(column, o, kinds)) {
      *value = number(cell, index);
      if (column.role == CsvRole::kDeviationStd && *value <= 0.0)
        fail(column, ": " + shownText(cell) + " must be above 0");
    } else if (column.role == CsvRole::kTemperature || column.role == CsvRole::kCovariate) {
      kinds.logged = true;
      (column.role == CsvRole::kTemperature ? temperatures_ : covariates_)
          .add(static_cast<std::size_t>(column.index), stamp, number(cell, index));
    } else {
      ranges_[index].add(cell);
      readWord(column, cell, o, kinds);
    }
  }

  void readWord(const CsvColumn& column, std::string_view cell, Observation& o, RowKinds& kinds) {
    if (column.role == CsvRole::kDirection) {
      const double direction = directionOf(cell);
      if (direction == 0.0)
        fail(column, ": '" + shownText(cell) +
                         "' is not a direction; write + or - (up and down, forward and reverse, 1 and -1 are "
                         "understood)");
      o.travel.resize(zeroUnlessColumn_.size(), 0.0);
      o.travel[column.index] = direction;
      o.velocity[column.index] = 0.0;  // read at standstill
    } else if (column.role == CsvRole::kFeature) {
      kinds.feature = true;
      o.feature = features_.find(cell);
      if (o.feature < 0 && states_ == nullptr) fail(features_.fault(cell));
    } else if (column.role == CsvRole::kSetup) {
      kinds.setup = true;
      o.setup = setups_[cell];
    } else if (column.role == CsvRole::kPlacement) {
      o.placement = placements_[cell];
    } else if (column.role == CsvRole::kStylus) {
      o.stylus = session_.artifact.findStylus(std::string(cell));
      if (o.stylus < 0) fail(stylusFault(cell));
    }
  }

  std::string stylusFault(std::string_view cell) const {
    const std::vector<std::string> known = allNames(session_.artifact.styli);
    return "stylus '" + shownText(cell) + "' is not in the artifact file" +
           (known.empty()
                ? "; name it there: probe: {styli: [{name: " + shownText(cell) + ", tip_radius_mm: …}, …]}"
                : didYouMean(std::string(cell), known) + "; it names " + listOf(known));
  }

  void countTimeFromStart() {
    const std::int64_t zero = form_.absoluteTime ? 0 : kImportEpoch;
    session_.epoch = static_cast<double>(zero) + secondsBetween(0, clock_.earliest());
    for (std::size_t i = 0; i < stamps_.size(); ++i)
      session_.observations[i].time = secondsBetween(clock_.earliest(), stamps_[i]);
    temperatures_.fill(session_.temperatures, clock_.earliest());
    covariates_.fill(session_.covariates, clock_.earliest());
  }

  const TextFile& file_;
  const TableForm& form_;
  StatesCsv* states_;
  std::size_t line_;  // that is read, from 1
  Session session_;
  FeatureNames features_;
  FaultList faults_;
  std::vector<ColumnRange> ranges_;
  std::vector<std::string> notes_;
  std::int64_t rows_ = 0;
  bool hasDate_ = false, hasTime_ = false, hasDeviation_ = false, hasPlacement_ = false;
  std::vector<std::string_view> cells_;
  // readings of a row before its cells: a joint without a column stays at 0
  std::vector<double> zeroUnlessColumn_;
  NumberedNames setups_, placements_;
  std::vector<std::int64_t> stamps_;  // of the observations, ns on the file's own clock
  RowClock clock_;
  LoggedSeries temperatures_, covariates_;
};

/// Whatever it was written in: a session must hold a measurement, and each laser contact its reading.
void finish(Session& session, const Artifact* artifact) {
  if (session.observations.empty())
    throw InputError(session.source +
                     ": no row holds a measurement (feature, length, reference or deviation)");
  if (artifact != nullptr && artifact->tipRadius == 0.0 && artifact->styli.empty() && session.hasLaser())
    for (const Observation& o : session.observations)
      if (o.kind == ObservationKind::kContact && std::isnan(o.laserReading))
        throw InputError(
            session.source + ": line " + std::to_string(o.row) +
            ": reading_mm is empty: the beam missed, or was out of the laser's range; leave the row out (or "
            "state the artifact's tip_radius_mm, if a touch probe was used there)");
  session.prepare();
  assumeTravel(session);
}

}  // namespace

bool TableForm::hasAny(std::initializer_list<CsvRole> roles) const {
  return std::any_of(columns.begin(), columns.end(), [&](const CsvColumn& c) {
    return std::find(roles.begin(), roles.end(), c.role) != roles.end();
  });
}

void ColumnRange::add(std::string_view cell) {
  if (count++ == 0) first = std::string(cell);
}

void ColumnRange::add(std::string_view cell, double value) {
  lower = std::min(count == 0 ? value : lower, value);
  upper = std::max(count == 0 ? value : upper, value);
  add(cell);
}

TableForm ownForm(const TextFile& file, const Machine& machine) {
  TableForm form;
  form.own = true;
  const auto& lines = file.lines();
  const auto header = std::find_if(lines.begin(), lines.end(), [](std::string_view line) {
    return line.find_first_not_of(" \t") != std::string_view::npos;
  });
  if (header == lines.end())
    throw InputError(file.path().string() + ": is empty; the first line must name the columns");
  form.headerLine = static_cast<std::size_t>(header - lines.begin()) + 1;
  std::vector<std::string_view> names;
  if (!splitCells(*header, names)) throw InputError(file.place(form.headerLine) + kOpenQuote);
  form.columns = parseCsvHeader({names.begin(), names.end()}, machine,
                                file.path().string() + ":" + std::to_string(form.headerLine));
  return form;
}

TableReading readTable(const TextFile& file, const TableForm& form, const Machine& machine,
                       const Artifact* artifact, const ProgressCallback& progress) {
  TableReading reading = TableReader(file, form, machine, artifact, nullptr).read(progress);
  finish(reading.session, artifact);
  return reading;
}

StatesCsv readStatesCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress) {
  const TextFile text(file);
  const TableForm form = ownForm(text, machine);
  StatesCsv states{Session(machine), std::string(text.lines()[form.headerLine - 1]), {}};
  states.session = TableReader(text, form, machine, artifact, &states).read(progress).session;
  if (states.lines.empty()) throw InputError(file.string() + ": no row below the header");
  deriveTravel(states.session.observations, machine.jointCount(), true);
  return states;
}

}  // namespace mm
