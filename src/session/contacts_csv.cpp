#include "session/contacts_csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "base/error.h"
#include "base/nearest_name.h"
#include "session/assumed_travel.h"
#include "session/csv_columns.h"
#include "session/line_reader.h"
#include "session/session_time.h"
#include "session/travel.h"

namespace mm {
namespace {

constexpr double kLargestTime = 3e9;    // s; with the epoch it still fits a ROS stamp
constexpr double kSmallestTime = -9e8;  // s

/// What was written in one row, beside the observation itself.
struct RowKinds {
  bool feature = false, reference = false, deviation = false, logged = false, setup = false;
  int measured() const { return feature + reference + deviation; }
};

struct Logged {
  std::int64_t stamp;  // ns, the file's own clock
  double value;
};

/// Turns the rows of one file into observations and series.
class CsvReader {
 public:
  CsvReader(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
            bool statesOnly)
      : lines_(file), states_(machine), hasArtifact_(artifact != nullptr), statesOnly_(statesOnly) {
    Session& session = states_.session;
    session.source = file.string();
    session.rowFile = file.filename().string();
    if (artifact != nullptr) session.artifact = *artifact;
    for (std::size_t i = 0; i < session.artifact.features.size(); ++i)
      featureIndex_[session.artifact.features[i].name] = static_cast<int>(i);
    readHeader();
  }

  StatesCsv read(const ProgressCallback& progress) {
    std::string_view line;
    while (lines_.next(line)) {
      if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
      readRow(line);
      if (progress && lines_.number() % 8192 == 0) progress(lines_.fraction());
    }
    countTimeFromStart();
    if (progress) progress(1.0);
    return std::move(states_);
  }

 private:
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
    const auto has = [&](CsvRole role) {
      return std::any_of(columns_.begin(), columns_.end(),
                         [&](const CsvColumn& c) { return c.role == role; });
    };
    hasTime_ = has(CsvRole::kTime);
    if (!hasTime_ && !statesOnly_) fail("column 'time_s' is missing");
    if (has(CsvRole::kFeature) && !hasArtifact_ && !statesOnly_)
      fail("column 'feature' needs an artifact that says what the features are; give one with --artifact");
    hasDeviation_ = has(CsvRole::kDeviation) || has(CsvRole::kDeviationStd);
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

  double number(std::string_view cell, const CsvColumn& column) const {
    const char* begin = cell.data();
    if (cell.size() > 1 && *begin == '+' && cell[1] != '-') ++begin;
    double value = 0.0;
    const auto [end, error] = std::from_chars(begin, cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
      fail("column '" + column.header + "': '" + std::string(cell) +
           "' is not a finite number; leave the cell empty where nothing was measured");
    return value * column.factor;
  }

  void readRow(std::string_view line) {
    if (!splitCells(line, cells_)) fail("a quote is not closed, or text follows it");
    if (cells_.size() != columns_.size())
      fail(std::to_string(cells_.size()) + " cells, but the header names " + std::to_string(columns_.size()) +
           " columns");
    Session& session = states_.session;
    const std::size_t joints = zeroUnlessColumn_.size();
    Observation o;
    o.row = lines_.number();
    o.position = zeroUnlessColumn_;
    o.velocity.assign(joints, kNotMeasured);
    if (hasDeviation_) {
      o.deviation.assign(joints, kNotMeasured);
      o.deviationStd.assign(joints, kNotMeasured);
    }
    RowKinds kinds;
    const std::int64_t stamp = timeOf();
    for (std::size_t i = 0; i < cells_.size(); ++i)
      if (!cells_[i].empty()) readCell(cells_[i], columns_[i], stamp, o, kinds);
    if (statesOnly_) {
      states_.lines.emplace_back(line);
    } else if (!checkRow(o, kinds)) {
      return;
    }
    finishKind(o, kinds);
    stamps_.push_back(stamp);
    session.observations.push_back(std::move(o));
  }

  /// Nanoseconds on the file's own clock.
  std::int64_t timeOf() {
    std::int64_t stamp = static_cast<std::int64_t>(stamps_.size());  // keeps the order of rows without a time
    if (hasTime_) {
      for (std::size_t i = 0; i < columns_.size(); ++i) {
        if (columns_[i].role != CsvRole::kTime) continue;
        if (cells_[i].empty()) fail("column 'time_s' is empty");
        const double time = number(cells_[i], columns_[i]);
        if (time < kSmallestTime || time > kLargestTime)
          fail("column 'time_s': " + std::string(cells_[i]) +
               " s is outside -9e8 … 3e9 s; is it in seconds?");
        stamp = std::llround(time * 1e9);
      }
    }
    earliest_ = any_ ? std::min(earliest_, stamp) : stamp;
    any_ = true;
    return stamp;
  }

  void readCell(std::string_view cell, const CsvColumn& column, std::int64_t stamp, Observation& o,
                RowKinds& kinds) {
    Session& session = states_.session;
    switch (column.role) {
      case CsvRole::kTime:
        break;
      case CsvRole::kPosition:
        o.position[column.index] = number(cell, column);
        break;
      case CsvRole::kVelocity:
        o.velocity[column.index] = number(cell, column);
        break;
      case CsvRole::kReading:
        o.laserReading = number(cell, column);
        break;
      case CsvRole::kFeature: {
        kinds.feature = true;
        key_.assign(cell);
        const auto found = featureIndex_.find(key_);
        if (found != featureIndex_.end())
          o.feature = found->second;
        else if (!statesOnly_)
          failFeature();
        break;
      }
      case CsvRole::kReference:
        kinds.reference = true;
        o.reference[column.index] = number(cell, column);
        break;
      case CsvRole::kDeviation:
        kinds.deviation = true;
        o.deviation[column.index] = number(cell, column);
        break;
      case CsvRole::kDeviationStd:
        o.deviationStd[column.index] = number(cell, column);
        if (o.deviationStd[column.index] <= 0.0)
          fail("column '" + column.header + "': " + std::string(cell) + " must be above 0");
        break;
      case CsvRole::kSetup: {
        kinds.setup = true;
        const auto entry = setupIndex_.emplace(std::string(cell), static_cast<int>(session.setups.size()));
        if (entry.second) session.setups.emplace_back(cell);
        o.setup = entry.first->second;
        break;
      }
      case CsvRole::kTemperature:
        kinds.logged = true;
        temperatures_[column.index].push_back({stamp, number(cell, column)});
        break;
      case CsvRole::kCovariate:
        kinds.logged = true;
        covariates_[column.index].push_back({stamp, number(cell, column)});
        break;
    }
  }

  [[noreturn]] void failFeature() const {
    std::vector<std::string> names;
    for (const Feature& f : states_.session.artifact.features) names.push_back(f.name);
    fail("feature '" + key_ + "' is not in artifact '" + states_.session.artifact.name + "'" +
         didYouMean(key_, names));
  }

  /// False for a row that only logs temperatures or covariates.
  bool checkRow(const Observation& o, const RowKinds& kinds) const {
    if (kinds.measured() > 1)
      fail("a row holds one of feature, reference_*_mm and deviation_*; leave the others empty");
    if (kinds.measured() == 0) {
      if (kinds.logged) return false;
      fail("nothing was measured: feature, reference and deviation are all empty or have no column");
    }
    if (kinds.feature && kinds.setup) fail("'setup' belongs to rows with a reference or a deviation");
    for (std::size_t j = 0; j < o.position.size(); ++j)
      if (std::isnan(o.position[j]))
        fail("the reading of joint '" + states_.session.machine.joints()[j].name + "' is empty");
    return true;
  }

  void finishKind(Observation& o, const RowKinds& kinds) const {
    o.kind = kinds.deviation   ? ObservationKind::kDeviation
             : kinds.reference ? ObservationKind::kPosition
                               : ObservationKind::kContact;
    if (o.kind == ObservationKind::kDeviation) return;
    o.deviation.clear();
    o.deviationStd.clear();
  }

  void countTimeFromStart() {
    Session& session = states_.session;
    session.epoch = static_cast<double>(kImportEpoch) + secondsBetween(0, earliest_);
    for (std::size_t i = 0; i < stamps_.size(); ++i)
      session.observations[i].time = secondsBetween(earliest_, stamps_[i]);
    fillSeries(temperatures_, session.temperatures);
    fillSeries(covariates_, session.covariates);
  }

  void fillSeries(std::vector<std::vector<Logged>>& logged, std::vector<Series>& series) const {
    const auto earlier = [](const Logged& a, const Logged& b) { return a.stamp < b.stamp; };
    for (std::size_t i = 0; i < series.size(); ++i) {
      if (!std::is_sorted(logged[i].begin(), logged[i].end(), earlier))
        std::stable_sort(logged[i].begin(), logged[i].end(), earlier);
      for (const Logged& l : logged[i]) {
        series[i].time.push_back(secondsBetween(earliest_, l.stamp));
        series[i].value.push_back(l.value);
      }
      std::vector<Logged>().swap(logged[i]);
    }
  }

  LineReader lines_;
  StatesCsv states_;
  bool hasArtifact_, statesOnly_;
  bool hasTime_ = false, hasDeviation_ = false, any_ = false;
  std::vector<CsvColumn> columns_;
  std::vector<std::string_view> cells_;
  std::string key_;
  std::vector<double>
      zeroUnlessColumn_;  // readings of a row before its cells: a joint without a column stays at 0
  std::unordered_map<std::string, int> featureIndex_, setupIndex_;
  std::vector<std::int64_t> stamps_;  // of the observations, ns on the file's own clock
  std::int64_t earliest_ = 0;
  std::vector<std::vector<Logged>> temperatures_, covariates_;
};

}  // namespace

Session readContactsCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress) {
  Session session = CsvReader(file, machine, artifact, false).read(progress).session;
  if (session.observations.empty())
    throw InputError(file.string() + ": no row holds a measurement (feature, reference or deviation)");
  if (artifact != nullptr && artifact->tipRadius == 0.0 && session.hasLaser())
    for (const Observation& o : session.observations)
      if (o.kind == ObservationKind::kContact && std::isnan(o.laserReading))
        throw InputError(
            file.string() + ": line " + std::to_string(o.row) +
            ": reading_mm is empty: the beam missed, or was out of the laser's range; leave the row "
            "out (or state the artifact's tip_radius_mm, if a touch probe was used there)");
  session.prepare();
  assumeTravel(session);
  return session;
}

StatesCsv readStatesCsv(const std::filesystem::path& file, const Machine& machine, const Artifact* artifact,
                        const ProgressCallback& progress) {
  StatesCsv states = CsvReader(file, machine, artifact, true).read(progress);
  if (states.lines.empty()) throw InputError(file.string() + ": no row below the header");
  deriveTravel(states.session.observations, machine.jointCount());
  return states;
}

}  // namespace mm
