#include "compensation/apply_states.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/format.h"
#include "model/session_states.h"
#include "session/contacts_csv.h"
#include "session/csv_cells.h"
#include "session/csv_columns.h"

namespace mm {
namespace {

constexpr double kOneClock = 1e8;  // s: starts further apart were not told by one clock

/// Temperatures and covariates of a row: which cell belongs to which input of the calibration.
class OwnCells {
 public:
  OwnCells(const StatesCsv& csv, const Domain& domain) {
    std::vector<std::string_view> names;
    splitCells(csv.header, names);
    columns_ = parseCsvHeader({names.begin(), names.end()}, csv.session.machine, csv.session.source);
    for (const CsvColumn& c : columns_) {
      timed_ = timed_ || c.role == CsvRole::kTime;
      index_.push_back(c.role == CsvRole::kTemperature ? domain.findSensor(c.name)
                       : c.role == CsvRole::kCovariate ? domain.findCovariate(c.name)
                                                       : -1);
    }
  }

  bool timed() const { return timed_; }

  /// What stands in the row itself counts, also where several rows have one time.
  void read(const std::string& line, State& state) {
    splitCells(line, cells_);
    for (std::size_t i = 0; i < cells_.size() && i < columns_.size(); ++i) {
      if (index_[i] < 0 || cells_[i].empty()) continue;
      const char* begin = cells_[i].data() + (cells_[i].front() == '+' ? 1 : 0);
      double value = kNotMeasured;
      std::from_chars(begin, cells_[i].data() + cells_[i].size(), value);
      (columns_[i].role == CsvRole::kTemperature ? state.temperature : state.covariate)[index_[i]] = value;
    }
  }

 private:
  std::vector<CsvColumn> columns_;
  std::vector<int> index_;  // a column: sensor or covariate of the calibration, or -1
  std::vector<std::string_view> cells_;
  bool timed_ = false;
};

/// Moves all times of the rows to the clock of the calibrated session.
void onClockOf(const Calibration& calibration, Session& session) {
  const double offset = session.epoch - calibration.sessionEpoch;
  if (!(std::abs(offset) < kOneClock)) return;
  session.epoch = calibration.sessionEpoch;
  for (Observation& o : session.observations) o.time += offset;
  for (auto* logged : {&session.temperatures, &session.covariates})
    for (Series& series : *logged)
      for (double& time : series.time) time += offset;
}

void append(std::string& out, const std::string& line, const Correction& c) {
  const Eigen::Vector3d p = c.corrected.position * 1e3;
  out += line;
  out += p.allFinite() ? format(",%.9f,%.9f,%.9f,%.6g", p.x(), p.y(), p.z(), c.sigma * 1e6) : ",,,,";
  out += c.valid ? ",1\n" : ",0\n";
}

}  // namespace

AppliedStates applyStates(const std::filesystem::path& file, const Calibration& calibration,
                          const Compensator& compensator, std::string& out,
                          const ProgressCallback& progress) {
  StatesCsv csv = readStatesCsv(file, compensator.model().machine(), nullptr);
  const Domain& domain = compensator.model().domain();
  OwnCells own(csv, domain);
  if (own.timed()) onClockOf(calibration, csv.session);
  const SessionStates states(csv.session, domain);

  AppliedStates applied;
  applied.rows = states.size();
  Compensator::Workspace work;
  out += csv.header + "," + kAppliedColumns + "\n";
  for (std::size_t i = 0; i < states.size(); ++i) {
    State state = states[i];
    for (double& way : state.sinceReversal)
      if (std::isnan(way)) way = std::numeric_limits<double>::infinity();  // as of a machine that went on
    if (!own.timed()) state.time = kNotMeasured;
    own.read(csv.lines[i], state);
    const Correction c = compensator.apply(state, work);
    append(out, csv.lines[i], c);
    const std::string line = "line " + std::to_string(csv.session.observations[i].row) + ": ";
    applied.valid += c.valid;
    applied.untimed += c.tooOld;
    if (!c.valid && applied.firstReason.empty()) applied.firstReason = line + c.reason;
    if (c.valid && applied.firstNote.empty() && !c.note.empty()) applied.firstNote = line + c.note;
    if (c.valid) {
      applied.largestMove = std::max(applied.largestMove, c.displacement.norm());
      applied.largestSigma = std::max(applied.largestSigma, c.sigma);
    }
    if (progress && i % 8192 == 0) progress(static_cast<double>(i) / static_cast<double>(states.size()));
  }
  return applied;
}

}  // namespace mm
