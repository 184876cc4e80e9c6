#include "workbench/session_documents.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "design/point_set.h"
#include "estimation/noise_rows.h"
#include "machine/joint_units.h"
#include "report/json_parts.h"
#include "report/report_variables.h"
#include "session/session_summary.h"

namespace mm {
namespace {

constexpr double kSpeedStep = 1e-3;        // mm/s or deg/s
constexpr double kTimeStep = 1e-2;         // s
constexpr double kApproachStep = 1e-3;     // of a unit vector
constexpr double kTemperatureStep = 1e-3;  // degC
constexpr double kLoggedStep = 1e-6;       // of a covariate's own unit
constexpr std::size_t kCurvePoints = 1500;

Json jointJson(const Joint& j) {
  const JointUnit unit = readingUnit(j);
  return rangeJson(j.name, unit.symbol, j.lower / unit.factor, j.upper / unit.factor);
}

Json featureJson(const Feature& f) {
  return {{"name", f.name},
          {"ball", f.kind == FeatureKind::kBall},
          {"position_mm", roundedList(f.position / kMillimetre, kPlaceStep)},
          {"radius_mm", rounded(f.radius / kMillimetre, kPlaceStep)},
          {"known", f.known}};
}

/// The columns of a table, row after row.
class Columns {
 public:
  explicit Columns(std::size_t rows) : rows_(rows) {}

  /// A quantity. @param value of a row, in `unit`.
  template <typename Value>
  void add(const std::string& name, const std::string& unit, double step, Value&& value) {
    Json values = Json::array();
    bool known = false;
    for (std::size_t r = 0; r < rows_; ++r) {
      values.push_back(rounded(value(r), step));
      known = known || !values.back().is_null();
    }
    if (known) columns_.push_back({{"name", name}, {"unit", unit}, {"values", std::move(values)}});
  }

  /// One of several words. @param level of a row: its index, -1: none.
  template <typename Level>
  void addWords(const std::string& name, const std::vector<std::string>& words, Level&& level) {
    Json values = Json::array();
    for (std::size_t r = 0; r < rows_; ++r) {
      const int at = level(r);
      values.push_back(at < 0 ? Json(nullptr) : Json(at));
    }
    columns_.push_back({{"name", name}, {"unit", ""}, {"words", words}, {"values", std::move(values)}});
  }

  Json take() { return std::move(columns_); }

 private:
  std::size_t rows_;
  Json columns_ = Json::array();
};

/// The rows of a fit and where each came from.
struct Rows {
  const CalibrationResult& fit;
  std::vector<const Observation*> observation;
  std::vector<int> index;  // of the observation

  explicit Rows(const CalibrationResult& f) : fit(f) {
    for (const ResidualRow& row : f.problem->rows()) {
      index.push_back(row.observation);
      observation.push_back(&session().observations[static_cast<std::size_t>(row.observation)]);
    }
  }
  const Session& session() const { return fit.problem->session(); }
  std::size_t size() const { return observation.size(); }
  bool used(std::size_t r) const { return fit.problem->uses(index[r]); }
};

/// The residual as a deviation along each direction that enough rows tell of, as in the report.
void addAlong(Columns& columns, const Rows& rows, bool angular) {
  constexpr std::ptrdiff_t kFewest = 13;
  std::vector<int> used;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.used(r) && rows.fit.problem->rows()[r].angular == angular) used.push_back(static_cast<int>(r));
  Directions directions = directionsOf(linearise(*rows.fit.problem, rows.fit.x), used);
  dropUnmeasured(directions);
  const Machine& machine = rows.session().machine;
  for (std::size_t d = 0; d < directions.names.size(); ++d) {
    const int joint = machine.findJoint(directions.names[d]);
    const bool turns =
        joint >= 0 && machine.joints()[static_cast<std::size_t>(joint)].kind == JointKind::kRotary;
    if (turns != angular) continue;  // a length that a rotary joint causes has a lever
    const Eigen::VectorXd factors = directions.factors.col(static_cast<Eigen::Index>(d));
    const double largest = factors.cwiseAbs().maxCoeff(), unit = angular ? kArcsecond : kMicrometre;
    std::vector<double> along(rows.size(), kNotMeasured);
    for (std::size_t i = 0; i < used.size(); ++i)
      along[static_cast<std::size_t>(used[i])] =
          residualAlong(rows.fit.residuals[used[i]], factors[static_cast<Eigen::Index>(i)], largest) / unit;
    const auto told = [](double v) { return std::isfinite(v); };
    if (std::count_if(along.begin(), along.end(), told) < kFewest) continue;
    const bool approach = directions.names[d] == "approach";
    columns.add("residual along " + (approach ? "the approach" : directions.names[d]),
                angular ? "arcsec" : "um", kDeviationStep, [&](std::size_t r) { return along[r]; });
  }
}

void addJoints(Columns& columns, const Rows& rows) {
  const std::vector<Joint>& joints = rows.session().machine.joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const JointUnit unit = readingUnit(joints[j]);
    columns.add(joints[j].name, unit.symbol, kPlaceStep,
                [&](std::size_t r) { return rows.observation[r]->position[j] / unit.factor; });
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto travel = [&](std::size_t r) {
      const std::vector<double>& t = rows.observation[r]->travel;
      return j >= t.size() || t[j] == 0.0 ? -1 : t[j] > 0.0 ? 1 : 0;
    };
    bool known = false;
    for (std::size_t r = 0; r < rows.size() && !known; ++r) known = travel(r) >= 0;
    if (known) columns.addWords(joints[j].name + " travel direction", {"\u2212", "+"}, travel);
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const JointUnit unit = readingUnit(joints[j]);
    columns.add(joints[j].name + " speed", std::string(unit.symbol) + "/s", kSpeedStep, [&](std::size_t r) {
      const std::vector<double>& v = rows.observation[r]->velocity;
      return j < v.size() ? v[j] / unit.factor : kNotMeasured;
    });
  }
}

void addTouch(Columns& columns, const Rows& rows) {
  const char* const names[] = {"approach x", "approach y", "approach z"};
  for (int k = 0; k < 3; ++k)
    columns.add(names[k], "1", kApproachStep,
                [&](std::size_t r) { return rows.observation[r]->approach[k]; });
  columns.add("laser reading", "mm", kPlaceStep,
              [&](std::size_t r) { return rows.observation[r]->laserReading / kMillimetre; });
  std::vector<std::string> features;
  for (const Feature& f : rows.session().artifact.features) features.push_back(f.name);
  if (!features.empty())
    columns.addWords("feature", features, [&](std::size_t r) { return rows.observation[r]->feature; });
  std::vector<std::string> components = {"x", "y", "z"};
  const auto component = [&](std::size_t r) {
    const Observation& o = *rows.observation[r];
    const int c = rows.fit.problem->rows()[r].component;
    return rows.session().outward(o) != 0 || c < 0 ? -1 : c;
  };
  const bool deviations =
      std::any_of(rows.observation.begin(), rows.observation.end(),
                  [](const Observation* o) { return o->kind == ObservationKind::kDeviation; });
  if (deviations) {
    components.clear();
    for (const Joint& j : rows.session().machine.joints()) components.push_back(j.name);
  }
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (component(r) >= 0) return columns.addWords("component", components, component);
}

void addLogged(Columns& columns, const Rows& rows) {
  const Session& session = rows.session();
  columns.add("time", "s", kTimeStep, [&](std::size_t r) {
    return session.timed(*rows.observation[r]) ? rows.observation[r]->time : kNotMeasured;
  });
  for (const Series& s : session.temperatures)
    columns.add("temperature " + s.name, "degC", kTemperatureStep,
                [&](std::size_t r) { return s.at(rows.observation[r]->time); });
  for (const Series& s : session.covariates)
    columns.add(s.name, s.unit, kLoggedStep, [&](std::size_t r) { return s.at(rows.observation[r]->time); });
  if (!session.setups.empty())
    columns.addWords("setup", session.setups, [&](std::size_t r) { return rows.observation[r]->setup; });
}

Json seriesJson(const std::vector<Series>& list, const std::string& unit) {
  return jsonList(list, [&](const Series& s) -> Json {
    const std::size_t shown = std::min(kCurvePoints, s.time.size());
    std::vector<std::size_t> samples;
    for (std::size_t n = 0; n < shown; ++n) samples.push_back(n * s.time.size() / shown);
    const double step = unit.empty() ? kLoggedStep : kTemperatureStep;
    return {{"name", s.name},
            {"unit", unit.empty() ? s.unit : unit},
            {"samples", s.time.size()},
            {"time_s", roundedList(samples, kTimeStep, [&](std::size_t i) { return s.time[i]; })},
            {"value", roundedList(samples, step, [&](std::size_t i) { return s.value[i]; })}};
  });
}

}  // namespace

std::string sessionDocument(const Session& session, const std::string& shownAs) {
  const Artifact& artifact = session.artifact;
  const auto setAside = [&](const SetAside& a) { return setAsideText(session, a); };
  return jsonLine({{"name", shownAs},
                   {"machine", session.machine.name()},
                   {"urdf", session.machine.urdf()},
                   {"joints", jsonList(session.machine.joints(), jointJson)},
                   {"artifact",
                    {{"name", artifact.name},
                     {"pose_known", artifact.poseKnown},
                     {"tip_radius_mm", artifact.tipRadius / kMillimetre},
                     {"features", jsonList(artifact.features, featureJson)}}},
                   {"observations", session.observations.size()},
                   {"warning", session.warning},
                   {"loss", lossText(session)},
                   {"assumed", assumedText(session)},
                   {"set_aside", jsonList(session.setAside, setAside)},
                   {"point_set", pointSetObject(checkPointSet(session, nullptr))}});
}

std::string machineDocument(const Machine& machine) {
  return jsonLine({{"name", machine.name()},
                   {"urdf", machine.urdf()},
                   {"joints", jsonList(machine.joints(), jointJson)}});
}

std::string pointsDocument(const CalibrationResult& fit, const EarlierResiduals& earlier) {
  const Rows rows(fit);
  const auto person = [&](std::size_t r, double value) {
    if (!rows.used(r)) return kNotMeasured;
    return value / (fit.problem->rows()[r].angular ? kArcsecond : kMicrometre);
  };
  const bool angular = !std::isfinite(fit.figures.rms);
  const auto at = [](const Eigen::VectorXd& v, std::size_t r) { return v[static_cast<Eigen::Index>(r)]; };
  Columns columns(rows.size());
  const std::string unit = angular ? "arcsec" : "um";
  columns.add("residual", unit, kDeviationStep,
              [&](std::size_t r) { return person(r, at(fit.residuals, r)); });
  addAlong(columns, rows, angular);
  addJoints(columns, rows);
  addTouch(columns, rows);
  addLogged(columns, rows);
  std::vector<double> sigma, before;
  std::vector<Eigen::Vector3d> places;
  Json row = Json::array(), outlier = Json::array(), balls = Json::array();
  const bool paired = earlier.values.size() == fit.residuals.size();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Observation& o = *rows.observation[r];
    sigma.push_back(person(r, at(fit.sigma, r)));
    if (paired) before.push_back(person(r, at(earlier.values, r)));
    row.push_back(o.row);
    outlier.push_back(rows.used(r) && !(at(fit.weight, r) > 0.0) ? 1 : 0);
    const double reading = std::isfinite(o.laserReading) ? o.laserReading : 0.0;
    places.push_back(rows.session().machine.nominal(o.position.data(), reading).position / kMillimetre);
  }
  const auto along = [&](int k) {
    return roundedList(places, kPlaceStep, [k](const Eigen::Vector3d& place) { return place[k]; });
  };
  for (std::size_t f = 0; f < rows.session().artifact.features.size(); ++f) {
    const Feature& feature = rows.session().artifact.features[f];
    const int index = static_cast<int>(f), placement = rows.session().placementOf(index);
    const Eigen::Vector3d centre = fit.problem->featureInWorkpiece(index, placement, fit.x) / kMillimetre;
    if (feature.kind == FeatureKind::kBall && centre.allFinite())
      balls.push_back(ballJson(feature.name, centre, feature.radius / kMillimetre));
  }
  return jsonLine({{"unit", unit},
                   {"rows", rows.size()},
                   {"columns", columns.take()},
                   {"x_mm", along(0)},
                   {"y_mm", along(1)},
                   {"z_mm", along(2)},
                   {"sigma", roundedList(sigma, kFigureStep)},
                   {"row", std::move(row)},
                   {"outlier", std::move(outlier)},
                   {"before", orNull(paired, roundedList(before, kDeviationStep))},
                   {"before_name", earlier.name},
                   {"balls", std::move(balls)}});
}

WebAnswer ContactsDocument::of(const std::vector<Eigen::Vector3d>& contacts) {
  const bool sameSession =
      count_ > 0 && count_ <= contacts.size() && contacts.front() == first_ && contacts[count_ - 1] == last_;
  if (!sameSession) {
    list_.clear();
    count_ = 0;
    body_ = nullptr;
  }
  if (count_ < contacts.size() || !body_) {
    for (; count_ < contacts.size(); ++count_)
      list_ += (count_ > 0 ? "," : "") + roundedList(contacts[count_] / kMillimetre, kPlaceStep).dump();
    if (count_ > 0) {
      first_ = contacts.front();
      last_ = contacts[count_ - 1];
    }
    body_ = std::make_shared<const std::string>("{\"at_mm\":[" + list_ + "]}");
  }
  WebAnswer answer;
  answer.body = body_;
  return answer;
}

std::string heatDocument(const Session& session) {
  return jsonLine({{"temperatures", seriesJson(session.temperatures, "degC")},
                   {"covariates", seriesJson(session.covariates, "")}});
}

}  // namespace mm
