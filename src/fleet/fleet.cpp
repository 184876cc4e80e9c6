#include "fleet/fleet.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include "base/erase_if.h"
#include "base/error.h"
#include "base/nearest_name.h"
#include "fleet/sensor_health.h"
#include "verification/trend.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewestPoints = 5;  // of a series that is asked for a trend

/// A calibration that could not be read: of which model is not known.
bool modelUnknown(const FleetRecord& r) { return r.model.empty() && r.result.status != "done"; }

/// The model that is wanted by its whole path, else the one of most records; where several have as many, the
/// first by name.
std::string mostUsed(const std::vector<FleetRecord>& records, const std::string& wanted,
                     std::vector<std::string>& others) {
  std::map<std::string, int> count;
  for (const FleetRecord& r : records)
    if (!modelUnknown(r)) ++count[r.model];
  std::string best;
  int most = 0;
  for (const auto& [model, n] : count)
    if (n > most && (wanted.empty() || model.find(wanted) != std::string::npos)) {
      best = model;
      most = n;
    }
  if (const auto whole = count.find(wanted); whole != count.end() && !wanted.empty()) best = wanted;
  for (const auto& [model, n] : count)
    if (model != best) others.push_back(model);
  if (most == 0 && !wanted.empty())
    throw InputError("--model: no session has a model with '" + wanted + "' in its name; there are " +
                     listOf(others));
  return best;
}

/// Leaves the quantities that are asked for: series, and effects that diagnoses found.
void keepWanted(Fleet& fleet, const FleetOptions& options) {
  if (options.parameter.empty()) return;
  const auto other = [&](const std::string& name) {
    return name.find(options.parameter) == std::string::npos;
  };
  std::set<std::string> quantities;
  bool any = false;
  for (const FleetSeries& s : fleet.series) quantities.insert(s.quantity);
  for (FleetRecord& r : fleet.records) {
    std::vector<std::string>& found = r.result.found;
    quantities.insert(found.begin(), found.end());
    eraseIf(found, other);
    any = any || !found.empty();
  }
  eraseIf(fleet.series, [&](const FleetSeries& s) { return other(s.quantity); });
  if (fleet.series.empty() && !any)
    throw InputError("--parameter: no quantity has '" + options.parameter + "' in its name; there are " +
                     listOf({quantities.begin(), quantities.end()}));
}

/// Of each machine the coarsest resolution of its temperature sensors, K: of one sensor the smallest step
/// between two readings of a session, or between two sessions in which it did not move.
std::map<std::string, double> resolutions(const std::vector<FleetRecord>& records) {
  std::map<std::pair<std::string, std::string>, std::pair<double, std::set<double>>> ofSensor;
  for (const FleetRecord& record : records)
    for (const SensorHealth& h : record.result.sensors) {
      auto& [step, still] =
          ofSensor.try_emplace({record.machine, h.sensor}, HUGE_VAL, std::set<double>{}).first->second;
      if (std::isfinite(h.step)) step = std::min(step, h.step);
      if (h.span == 0.0 && std::isfinite(h.mean)) still.insert(h.mean);
    }
  std::map<std::string, double> ofMachine;
  for (auto& [name, known] : ofSensor) {
    auto& [step, still] = known;
    for (auto at = still.begin(); at != still.end() && std::next(at) != still.end(); ++at)
      if (*std::next(at) - *at > kSameReading) step = std::min(step, *std::next(at) - *at);
    double& coarsest = ofMachine[name.first];
    if (std::isfinite(step)) coarsest = std::max(coarsest, step);
  }
  return ofMachine;
}

}  // namespace

std::vector<FleetSeries> seriesOf(const std::vector<FleetRecord>& records) {
  std::map<std::tuple<std::string, std::string>, FleetSeries> all;  // quantity, machine
  std::map<std::string, double> resolution = resolutions(records);
  std::map<std::string, double> ordinal;  // of records without a date
  for (const FleetRecord& record : records) {
    double day = daysOf(record.date);
    if (!std::isfinite(day)) day = ordinal[record.machine]++;
    const auto add = [&](SeriesKind kind, const std::string& quantity, const std::string& unit, double value,
                         double std) {
      if (!std::isfinite(value) || !std::isfinite(std)) return;
      FleetSeries& s = all[{quantity, record.machine}];
      s.kind = kind;
      s.machine = record.machine;
      s.quantity = quantity;
      s.unit = unit;
      if (kind == SeriesKind::kSensor && unit == "K") s.resolution = resolution[record.machine];
      s.points.push_back({day, value, std});
      s.dates.push_back(record.date);
    };
    if (record.result.converged) {
      for (const FleetParameter& p : record.result.parameters)
        if (!p.fixed && p.std > 0.0)
          add(SeriesKind::kParameter, p.name + " of " + p.effect, p.unit, p.value, p.std);
      add(SeriesKind::kFigure, "held-out RMS", record.result.angular ? "urad" : "um",
          record.result.heldOutRms, 0.0);
    }
    for (const SensorHealth& h : record.result.sensors) {
      add(SeriesKind::kSensor, "offset of sensor " + h.sensor, "K", h.offset, 0.0);
      if (h.noise > 0.0)
        add(SeriesKind::kSensor, "noise of sensor " + h.sensor, "ln K",
            std::log(std::isfinite(h.step) ? std::max(h.noise, h.step) : h.noise), 0.0);
    }
  }
  std::vector<FleetSeries> list;
  for (auto& [key, series] : all) list.push_back(std::move(series));
  return list;
}

Fleet fleetOf(std::vector<FleetRecord> records, const FleetOptions& options) {
  Fleet fleet;
  fleet.alarm = options.alarm;
  fleet.model = mostUsed(records, options.model, fleet.otherModels);
  std::set<std::string> machines;
  for (FleetRecord& r : records) {
    if (r.model != fleet.model && !modelUnknown(r)) continue;
    machines.insert(r.machine);
    const bool done = r.result.status == "done";
    ++(done ? fleet.done : fleet.failed);
    fleet.open += done && !r.result.converged;
    (done ? fleet.records : fleet.failures).push_back(std::move(r));
  }
  std::stable_sort(fleet.records.begin(), fleet.records.end(),
                   [](const FleetRecord& a, const FleetRecord& b) {
                     return std::tie(a.machine, a.date) < std::tie(b.machine, b.date);
                   });
  fleet.machines = {machines.begin(), machines.end()};
  fleet.series = seriesOf(fleet.records);
  keepWanted(fleet, options);
  // half of the chance of a false alarm is for the values, half for what the diagnoses found; within each
  // every question has the same share, whether it is shown or not
  double values = sisterQuestions(fleet);
  for (const FleetSeries& s : fleet.series)
    if (s.points.size() >= kFewestPoints) ++values;
  const double recurrences = recurrenceQuestions(fleet), half = recurrences > 0.0 ? 0.5 : 1.0;
  fleet.questions = std::max(1.0, values + recurrences);
  const double alpha = half * options.alarm / std::max(1.0, values);
  findTrends(fleet, alpha);
  findSisters(fleet, alpha);
  findRecurrences(fleet, half * options.alarm / std::max(1.0, recurrences));
  findBadSensors(fleet);
  condense(fleet);
  eraseIf(fleet.findings,
          [&](const Finding& f) { return f.quantity.find(options.parameter) == std::string::npos; });
  std::stable_sort(fleet.findings.begin(), fleet.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.p < b.p; });
  if (options.machine.empty()) return fleet;
  if (machines.count(options.machine) == 0)
    throw InputError("--machine: there is no machine '" + options.machine + "'" +
                     didYouMean(options.machine, fleet.machines) + " (machines are " +
                     listOf(fleet.machines) + ")");
  const auto others = [&](const auto& item) { return item.machine != options.machine; };
  eraseIf(fleet.series, others);
  eraseIf(fleet.findings, others);
  eraseIf(fleet.records, others);
  eraseIf(fleet.failures, others);
  return fleet;
}

Fleet loadFleet(const std::string& folder, const FleetOptions& options) {
  const ResultsFolder results(folder);
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    throw InputError(folder +
                     ": is not a folder; name the one that mm batch -o wrote, or one of calibrations");
  Fleet fleet;
  if (fs::is_regular_file(results.database(), ignored)) {
    const FleetDatabase tables(results.database(), Database::Use::kRead);
    std::vector<FleetRecord> records = tables.records();
    const long waiting = tables.count("waiting");
    if (records.empty())
      throw InputError(folder + ": no job has ended yet (" + std::to_string(waiting) +
                       " wait); run mm batch with the manifest");
    fleet = fleetOf(std::move(records), options);
    fleet.waiting = waiting;
  } else {
    fleet = fleetOf(storeRecords(folder), options);
  }
  fleet.source = folder;
  return fleet;
}

}  // namespace mm
