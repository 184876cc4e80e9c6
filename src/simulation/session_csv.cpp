#include "simulation/session_csv.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <utility>
#include <vector>

#include "base/erase_if.h"
#include "base/units.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

using Cell = std::function<double(const Observation&)>;

/// Numeric columns, in order; a column in which nothing was measured is left out.
std::vector<std::pair<std::string, Cell>> columnsOf(const Session& session) {
  std::vector<std::pair<std::string, Cell>> columns = {
      {"time_s", [](const Observation& o) { return o.time; }}};
  const std::vector<Joint>& joints = session.machine.joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::string& name = joints[j].name;
    const JointUnit reading = readingUnit(joints[j]), error = errorUnit(joints[j]);
    columns.emplace_back(name + "_" + reading.symbol,
                         [=](const Observation& o) { return o.position[j] / reading.factor; });
    columns.emplace_back(name + "_velocity_" + reading.symbol + "_s",
                         [=](const Observation& o) { return o.velocity[j] / reading.factor; });
    columns.emplace_back("deviation_" + name + "_" + error.symbol, [=](const Observation& o) {
      return o.deviation.empty() ? kNotMeasured : o.deviation[j] / error.factor;
    });
  }
  columns.emplace_back("reading_mm", [](const Observation& o) { return o.laserReading / kMillimetre; });
  for (int k = 0; k < 3; ++k)
    columns.emplace_back(std::string("reference_") + "xyz"[k] + "_mm",
                         [=](const Observation& o) { return o.reference(k) / kMillimetre; });
  columns.emplace_back("length_mm", [](const Observation& o) { return o.length / kMillimetre; });
  for (const Series& s : session.temperatures)
    columns.emplace_back(s.name + "_degC", [&s](const Observation& o) { return s.at(o.time); });
  for (const Series& s : session.covariates)
    columns.emplace_back(s.name + "_" + s.unit, [&s](const Observation& o) { return s.at(o.time); });

  eraseIf(columns, [&](const auto& column) {
    return std::all_of(session.observations.begin(), session.observations.end(),
                       [&](const Observation& o) { return std::isnan(column.second(o)); });
  });
  return columns;
}

}  // namespace

std::string sessionCsv(const Session& session) {
  const auto columns = columnsOf(session);
  std::ostringstream out;
  out.precision(17);
  for (std::size_t c = 0; c < columns.size(); ++c) out << (c > 0 ? "," : "") << columns[c].first;
  const bool features = !session.artifact.features.empty(), setups = !session.setups.empty(),
             placements = !session.placements.empty(), styli = !session.artifact.styli.empty();
  out << (features ? ",feature" : "") << (setups ? ",setup" : "") << (placements ? ",placement" : "")
      << (styli ? ",stylus" : "") << '\n';
  for (const Observation& o : session.observations) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double value = columns[c].second(o);
      if (c > 0) out << ',';
      if (!std::isnan(value)) out << value;
    }
    if (features) out << ',' << (o.feature >= 0 ? session.artifact.features[o.feature].name : "");
    if (setups) out << ',' << (o.setup >= 0 ? session.setups[o.setup] : "");
    if (placements) out << ',' << session.placements[o.placement];
    if (styli) out << ',' << session.artifact.styli[o.stylus].name;
    out << '\n';
  }
  return out.str();
}

}  // namespace mm
