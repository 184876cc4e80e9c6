#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <optional>

#include "base/error.h"
#include "base/json_text.h"
#include "estimation/genetic_subset.h"
#include "thermal/sensor_selection.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/interrupt.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/sensors_picture.h"
#include "tools/sensors_source.h"
#include "tools/session_input.h"

namespace mm {
namespace {

struct SensorsOptions {
  std::string csv, target, picture, positions, space;
  SelectionSettings selection;
  double accuracyUm = 0.0;
  std::string estimator = "ksg", correction = "none", range = "common", choose;
  std::vector<int> bins{30, 30};
  bool json = false;
  OutputFiles files;
};

/// `subset` of SENSORS, which returns one set, as a search that returns the best it met.
std::vector<std::vector<int>> searchSubsets(int sensors, int size, int keep, std::uint64_t seed,
                                            const SetScore& score,
                                            const std::function<void(double)>& progress) {
  std::map<std::vector<int>, double> met;
  SubsetSettings settings;
  settings.population = 200;
  settings.generations = 120;
  settings.seed = seed;
  GeneticControl control;
  control.progress = [&](const GeneticProgress& p) {
    progress(static_cast<double>(p.generation) /
             static_cast<double>(std::max<std::size_t>(1, p.generations)));
  };
  bestSubset(
      static_cast<std::size_t>(sensors), static_cast<std::size_t>(size),
      [&](const std::vector<std::size_t>& chosen) {
        const std::vector<int> set(chosen.begin(), chosen.end());
        return met[set] = score(set);
      },
      settings, control);
  std::vector<std::pair<double, std::vector<int>>> order;
  for (const auto& [set, value] : met) order.emplace_back(-value, set);
  std::sort(order.begin(), order.end());
  std::vector<std::vector<int>> best;
  for (std::size_t i = 0; i < std::min(order.size(), static_cast<std::size_t>(keep)); ++i)
    best.push_back(order[i].second);
  return best;
}

SelectionSettings settingsOf(const SensorsOptions& options, double micrometres) {
  SelectionSettings settings = options.selection;
  const std::map<std::string, InformationEstimator> estimators{
      {"ksg", InformationEstimator::kKsg},
      {"histogram", InformationEstimator::kHistogram},
      {"correlation", InformationEstimator::kCorrelation}};
  const std::map<std::string, BiasCorrection> corrections{{"none", BiasCorrection::kNone},
                                                          {"miller_madow", BiasCorrection::kMillerMadow},
                                                          {"shuffle", BiasCorrection::kShuffle},
                                                          {"circular_shift", BiasCorrection::kCircularShift}};
  settings.information.estimator = estimators.at(options.estimator);
  settings.information.correction = corrections.at(options.correction);
  settings.information.commonRange = options.range == "common";
  settings.information.temperatureBins = options.bins[0];
  settings.information.displacementBins = options.bins[1];
  settings.information.seed = settings.seed;
  settings.search = searchSubsets;
  settings.accuracy = options.accuracyUm / micrometres;
  const std::map<std::string, SetChoice> choices{{"prediction", SetChoice::kPrediction},
                                                 {"held_out", SetChoice::kHeldOut},
                                                 {"information", SetChoice::kInformation}};
  const std::string usual = options.estimator == "ksg" ? "prediction" : "information";
  settings.choice = choices.at(options.choose.empty() ? usual : options.choose);
  if (options.correction != "none" && options.estimator != "histogram")
    throw InputError("--correction " + options.correction +
                     " applies to --estimator histogram only, not to " + options.estimator + "; omit it");
  return settings;
}

Json selectionJson(const SensorSelection& selection, const SensorCandidates& candidates) {
  const auto name = [&](int sensor) { return candidates.name(sensor); };
  const auto names = [&](const std::vector<int>& sensors) { return jsonList(sensors, name); };
  const auto single = [&](const SensorScore& s) -> Json {
    return {{"sensor", name(s.sensor)},
            {"mutual_information_nat", s.information},
            {"correlation", s.correlation}};
  };
  const auto set = [&](const SensorSet& s) -> Json {
    return {{"sensors", names(s.sensors)},
            {"mutual_information_nat", s.information},
            {"cv_rms_um", s.heldOutRms * candidates.micrometres},
            {"other_duties_rms_um", s.dutyRms * candidates.micrometres}};
  };
  const auto together = [&](const auto& equivalent) -> Json {
    return {{"sensor", name(equivalent.first)}, {"drift_together", names(equivalent.second)}};
  };
  std::vector<SensorSet> sets = selection.sets;
  std::stable_sort(sets.begin(), sets.end(),
                   [](const SensorSet& a, const SensorSet& b) { return a.heldOutRms < b.heldOutRms; });
  return {{"single", jsonList(selection.singles, single)},
          {"sets", jsonList(sets, set)},
          {"recommended", names(selection.sets[selection.recommended].sensors)},
          {"equivalent", jsonList(selection.equivalent, together)},
          {"left_out", names(selection.constant)}};
}

void printText(const SensorSelection& selection, const SensorCandidates& candidates,
               const std::string& target) {
  const SensorSet& best = selection.sets[selection.recommended];
  std::printf("Measure %s: held-out error of %s %.3g um.\n\n", candidates.namesOf(best.sensors).c_str(),
              target.c_str(), best.heldOutRms * candidates.micrometres);
  std::printf("%-28s %12s %12s\n", "single sensor", "information", "correlation");
  const std::size_t shown = std::min<std::size_t>(10, selection.singles.size());
  for (std::size_t i = 0; i < shown; ++i)
    std::printf("%-28s %8.3f nat %12.4f\n", candidates.name(selection.singles[i].sensor).c_str(),
                selection.singles[i].information, selection.singles[i].correlation);
  if (shown < selection.singles.size()) std::printf("  and %zu more\n", selection.singles.size() - shown);
  double most = 1e-9;
  for (const SensorSet& set : selection.sets) most = std::max(most, set.information);
  std::printf("\n%-4s %12s %-22s %12s  %s\n", "m", "information", "", "held out", "set");
  for (std::size_t m = 0; m < selection.sets.size(); ++m) {
    const SensorSet& set = selection.sets[m];
    const std::string bar(static_cast<std::size_t>(std::max(0.0, 20.0 * set.information / most)), '#');
    std::printf("%-4zu %8.3f nat %-22s %9.3g um  %s%s%s\n", m + 1, set.information, bar.c_str(),
                set.heldOutRms * candidates.micrometres, candidates.namesOf(set.sensors).c_str(),
                m == selection.recommended ? "  <- recommended" : "",
                selection.exhaustive[m] ? "" : "  (searched)");
  }
  for (const auto& [sensor, others] : selection.equivalent)
    std::printf("%s drifts together with these, which would do as well: %s\n",
                candidates.name(sensor).c_str(), candidates.namesOf(others, ", ").c_str());
  std::fflush(stdout);
}

void runSensors(SensorsOptions& options) {
  options.files.input({options.csv, options.positions});
  options.files.output("--picture", options.picture, FileKind::kPicture);
  options.files.check();
  const SensorCandidates candidates = readSensorCandidates(options.csv, options.target, options.space);
  const SelectionSettings settings = settingsOf(options, candidates.micrometres);
  std::optional<Eigen::MatrixXd> positions;
  if (!options.positions.empty()) positions = readSensorPositions(options.positions, candidates.names);
  SensorSelection selection;
  try {
    ProgressBar bar("sensors");
    selection = selectSensors(candidates.temperatures, candidates.displacement, settings,
                              [&](double fraction, const std::string& stage) {
                                bar.show(fraction, stage);
                                return !Interrupt::asked();
                              });
  } catch (const InputError& e) {
    throw InputError(options.csv + ": " + e.what());
  }
  Interrupt::check();
  for (int s : selection.constant)
    warn(options.csv + ": column '" + candidates.name(s) + "' does not vary and is not used");
  if (!options.picture.empty())
    options.files.write(options.picture, sensorsPicture(selection, candidates, positions, options.target));
  if (options.json)
    std::cout << jsonText(selectionJson(selection, candidates)) << '\n';
  else
    printText(selection, candidates, options.target);
}

}  // namespace

void addSensorsCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] =
      addCommand<SensorsOptions>(app, exitStatus, runSensors, "sensors",
                                 "Select the temperature sensors that best predict a displacement");
  command
      .add_option(
          "series", options.csv,
          "CSV with a header and one sample per row in order of time; a session bag; or the .dat file of a "
          "CalculiX run")
      ->required();
  command
      .add_option("--target", options.target,
                  "displacement: of a CSV the column (its suffix _um, _mm or _m gives the unit), of a bag "
                  "the axis, of a CalculiX run node set, direction and length unit, e.g. NOSE_x_m")
      ->required();
  standardOption(command, "--max", options.selection.largestSize, wholeNumberWithin(1, 64), "largest set");
  standardOption(command, "--estimator", options.estimator,
                 CLI::IsMember({"ksg", "histogram", "correlation"}), "estimator of the mutual information");
  standardOption(command, "--bins", options.bins, wholeNumberWithin(2, 10000),
                 "N,M: number of bins of temperature and of displacement (histogram)")
      ->delimiter(',')
      ->expected(2);
  standardOption(command, "--range", options.range, CLI::IsMember({"common", "sensor"}),
                 "temperature range of the bins: common to all sensors, or one for each sensor");
  standardOption(command, "--correction", options.correction,
                 CLI::IsMember({"none", "miller_madow", "shuffle", "circular_shift"}),
                 "bias correction of the histogram");
  checkedOption(
      command, "--choose", options.choose, CLI::IsMember({"prediction", "held_out", "information"}),
      "criterion: prediction: error expected for other duty cycles and for held-out blocks of time "
      "(default for ksg); held_out: information and held-out error; information: information alone, as "
      "published (default for histogram and correlation)");
  checkedOption(command, "--accuracy-um", options.accuracyUm, numberWithin(0.0, 1e9, "um"),
                "recommend the smallest set whose held-out error is within this value");
  standardOption(command, "--blocks", options.selection.blocks, wholeNumberWithin(2, 1000),
                 "number of time blocks in the cross-validation");
  standardOption(command, "--gap", options.selection.gap, wholeNumberWithin(0, 100000),
                 "number of samples on either side of a block that are not used");
  seedOption(command, options.selection.seed);
  declareNamespace(command, options.space);
  command.add_option("--picture", options.picture,
                     "write an SVG of sensor positions, and of information and held-out error against the "
                     "number of sensors");
  command
      .add_option("--positions", options.positions,
                  "CSV with the sensor positions for --picture: sensor,x_mm,y_mm,z_mm")
      ->needs("--picture");
  command.add_flag("--json", options.json, "for programs");
  options.files.declare(command);
  command.footer(
      "Columns named t, time or time_<unit> are times; all others except the target are candidate sensors.\n"
      "Example:  mm sensors housing.csv --target nose_um --max 2");
}

}  // namespace mm
