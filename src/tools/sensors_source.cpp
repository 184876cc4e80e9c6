#include "tools/sensors_source.h"

#include "base/error.h"
#include "base/names_of.h"
#include "base/text.h"
#include "base/units.h"
#include "estimation/network_samples.h"
#include "model/observed_domain.h"
#include "thermal/calculix_results.h"
#include "thermal/series.h"
#include "tools/session_input.h"

namespace mm {
namespace {

SensorCandidates fromCsv(const std::string& file, const std::string& targetName) {
  const SampledSeries series = readSeries(file);
  int target = 0;
  try {
    target = series.column(targetName);
  } catch (const InputError& e) {
    throw InputError(file + ": --target: " + e.what());
  }
  SensorCandidates candidates;
  candidates.displacement = series.values.col(target);
  candidates.micrometres = micrometresPerUnit(targetName);
  std::vector<int> columns;
  for (int c = 0; c < static_cast<int>(series.names.size()); ++c)
    if (c != target && !isTimeColumn(series.names[static_cast<std::size_t>(c)])) columns.push_back(c);
  if (columns.empty())
    throw InputError(file + ": there is no column beside '" + targetName +
                     "' and the time; add one column per sensor");
  candidates.temperatures.resize(series.values.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    candidates.names.push_back(series.names[static_cast<std::size_t>(columns[i])]);
    candidates.temperatures.col(static_cast<Eigen::Index>(i)) = series.values.col(columns[i]);
  }
  return candidates;
}

/// @param target `<set>_<x, y or z>_<m or mm>`: the mean displacement of a node set; the ending says which
/// unit of length the deck has, because its results do not.
SensorCandidates fromCalculix(const std::string& file, const std::string& target) {
  const CalculixResults results = readCalculixResults(file);
  SensorCandidates candidates;
  candidates.micrometres = micrometresPerUnit(target);
  candidates.temperatures = results.temperatures;
  for (const int node : results.nodes) candidates.names.push_back("node_" + std::to_string(node));
  std::vector<std::string> known;
  for (std::size_t s = 0; s < results.sets.size(); ++s)
    for (int direction = 0; direction < 3; ++direction)
      for (const char* unit : {"m", "mm"}) {
        known.push_back(results.sets[s] + '_' + "xyz"[direction] + '_' + unit);
        if (known.back() == target) candidates.displacement = results.mean[s].col(direction);
      }
  if (candidates.displacement.size() == 0)
    throw InputError(file + ": --target: '" + target + "' is not the displacement of a node set; " +
                     (known.empty() ? "none was printed (*NODE PRINT, NSET=<set>, then U)"
                                    : "there are, by the deck's unit of length: " + joined(known, ", ")));
  return candidates;
}

SensorCandidates fromBag(const std::string& file, const std::string& target, const std::string& space) {
  const Session session = loadSession(file, nullptr, space);
  std::string axis = target;
  if (axis.compare(0, 10, "deviation_") == 0) axis = axis.substr(10);
  for (const char* unit : {"_um", "_arcsec"})
    if (endsWith(axis, unit)) axis = axis.substr(0, axis.size() - std::string(unit).size());
  const Domain domain = observedDomain(session);
  const int joint = domain.findJoint(axis);
  if (joint < 0)
    throw InputError(file + ": --target: '" + target +
                     "' is not an axis of the machine; its axes: " + joined(allNames(domain.joints), ", "));
  if (domain.sensors.empty())
    throw InputError(file +
                     ": no temperature was logged; record /temperature/<sensor>, or import columns "
                     "<sensor>_degC");
  const Problem problem(session, Model(session.machine, domain, std::vector<EffectPtr>{}));
  const Linearisation at = linearise(problem, problem.start());
  const NetworkSamples samples =
      gatherNetworkSamples(at, at.residuals(), Eigen::VectorXd::Ones(problem.rowCount()), joint);
  SensorCandidates candidates;
  candidates.displacement = samples.mainError();
  candidates.micrometres = domain.joints[static_cast<std::size_t>(joint)].kind == JointKind::kLinear
                               ? 1.0 / kMicrometre
                               : 1.0 / kArcsecond;
  candidates.names = domain.sensors;
  candidates.temperatures = samples.temperatures;
  return candidates;
}

}  // namespace

std::string SensorCandidates::namesOf(const std::vector<int>& sensors, const std::string& between) const {
  std::vector<std::string> words;
  for (const int sensor : sensors) words.push_back(name(sensor));
  return joined(words, between);
}

SensorCandidates readSensorCandidates(const std::string& file, const std::string& target,
                                      const std::string& space) {
  if (endsWith(file, ".bag")) return fromBag(file, target, space);
  return endsWith(file, ".dat") ? fromCalculix(file, target) : fromCsv(file, target);
}

}  // namespace mm
