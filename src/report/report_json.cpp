#include <cmath>
#include <ctime>

#include "base/error.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "report/iso_tests_json.h"
#include "report/json.h"
#include "report/json_parts.h"
#include "report/quantiles.h"
#include "report/report_contents.h"
#include "report/text_parts.h"
#include "session/session_hash.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kHourStep = 1e-5;         // h: 0.04 s
constexpr double kTemperatureStep = 1e-4;  // degC: below the noise of any sensor

/// Five digits of the largest value.
double stepOf(const std::vector<double>& values) {
  double most = 0.0;
  for (const double v : values)
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  return most > 0.0 ? std::pow(10.0, std::floor(std::log10(most)) - 4.0) : 1.0;
}

Json figuresJson(const std::string& name, const std::string& note, const CalibrationResult* fit,
                 const ResidualFigures& f) {
  Json one;
  one["name"] = name;
  one["note"] = note;
  setFigures(one, f, true);
  one["chi2_per_dof"] = f.degreesOfFreedom > 0 ? number(f.chi2PerDof) : Json(nullptr);
  one["degrees_of_freedom"] = f.degreesOfFreedom;
  if (fit == nullptr) return one;
  one["outliers"] = fit->outliers.size();
  for (const bool angular : {false, true}) {
    const SizeOfResiduals size = sizeOfResiduals(*fit, angular);
    if (size.count == 0) continue;
    const double unit = angular ? kArcsecond : kMicrometre;
    const std::string suffix = angular ? "_arcsec" : "_um";
    one["max" + suffix] = number(size.max / unit);
    // of an RMS of independent normal residuals
    const double rms = angular ? f.rmsAngular : f.rms;
    const double share = static_cast<double>(f.degreesOfFreedom) / std::max(1, fit->problem->rowCount());
    one["rms_std" + suffix] = number(rms / unit / std::sqrt(2.0 * std::max(1.0, share * size.count)));
    one["count" + suffix] = size.count;
    for (const auto& [percent, value] : size.quantiles)
      if (percent == 95) one["q95" + suffix] = number(value / unit);
  }
  return one;
}

Json figures(const ReportContents& r) {
  Json out = Json::array();
  if (!r.diagnosis.base.problem) return out;
  const CalibrationResult& base = r.diagnosis.base;
  out.push_back(figuresJson("Nominal machine", "no effect in the model", r.nominal ? &*r.nominal : nullptr,
                            r.nominal ? r.nominal->figures : base.before));
  if (r.held)
    out.push_back(
        figuresJson("This calibration, values held",
                    "does it still hold here? Only the artifact's pose, free centres and zeros fitted",
                    &*r.held, r.held->figures));
  out.push_back(figuresJson("This calibration, refitted", "the same effects, values fitted to this session",
                            &base, base.figures));
  if (r.improved)
    out.push_back(figuresJson("With the named effects added", "what the diagnosis proposes", &*r.improved,
                              r.improved->figures));
  return out;
}

Json variablesJson(const std::vector<VariableView>& views) {
  Json out = Json::array();
  for (const VariableView& v : views) {
    Json one;
    one["name"] = v.name;
    one["unit"] = v.unit;
    one["category"] = v.category;
    one["labels"] = v.labels;
    one["direction"] = v.direction;
    one["share"] = number(v.share);
    one["p_value"] = number(v.pValue);
    one["observations"] = v.observations;
    std::vector<double> at, mean, error, improved;
    Json counts = Json::array();
    for (const VariableBin& b : v.bins) {
      at.push_back(b.at);
      mean.push_back(b.mean);
      error.push_back(b.standardError);
      improved.push_back(b.meanImproved);
      counts.push_back(b.count);
    }
    const double xStep = stepOf(v.x), yStep = stepOf(v.y);
    one["at"] = roundedList(at, stepOf(at));
    one["mean"] = roundedList(mean, yStep * 0.1);
    one["standard_error"] = roundedList(error, yStep * 0.01);
    one["improved"] = roundedList(improved, yStep * 0.1);
    one["count"] = std::move(counts);
    one["x"] = roundedList(v.x, xStep);
    one["y"] = roundedList(v.y, yStep);
    out.push_back(std::move(one));
  }
  return out;
}

Json vectorsJson(const ResidualVectors& v, const Session& session) {
  if (v.places.empty()) return nullptr;
  Json out;
  out["observations"] = v.observations;
  out["signed"] = v.signedValues;
  Json at = Json::array(), rows = Json::array(), names = Json::array(), outliers = Json::array();
  for (const ResidualVectors::Place& p : v.places) {
    at.push_back(roundedList(p.at, kPlaceStep));
    rows.push_back(p.row);
    names.push_back(p.feature >= 0 ? session.artifact.features[static_cast<std::size_t>(p.feature)].name
                                   : std::string());
    outliers.push_back(p.outlier ? 1 : 0);
  }
  out["at_mm"] = std::move(at);
  out["row"] = std::move(rows);
  out["feature"] = std::move(names);
  out["outlier"] = std::move(outliers);
  out["states"] = Json::array();
  for (const ResidualVectors::State& s : v.states) {
    Json state, vectors = Json::array();
    for (const Eigen::Vector3d& one : s.vectors) vectors.push_back(roundedList(one, kDeviationStep));
    state["name"] = s.name;
    state["vector_um"] = std::move(vectors);
    state["value_um"] = roundedList(s.values, kDeviationStep);
    out["states"].push_back(std::move(state));
  }
  out["balls"] = Json::array();
  for (const ResidualVectors::Ball& b : v.balls)
    out["balls"].push_back(Json{{"name", b.name},
                                {"centre_mm", roundedList(b.centre, kPlaceStep)},
                                {"radius_mm", rounded(b.radius, kPlaceStep)}});
  return out;
}

/// Balls and points: where the file has them beside where the session found them, in the artifact's frame
/// where that is the workpiece's, else found alone.
Json featuresJson(const ReportContents& r) {
  Json out = Json::array();
  const Artifact& artifact = r.session->artifact;
  for (const FoundFeature& f : r.features) {
    if (!(f.std.maxCoeff() > 0.0) && !(f.radiusStd > 0.0)) continue;  // nothing was asked
    const Feature& file = artifact.features[static_cast<std::size_t>(artifact.findFeature(f.name))];
    const bool comparable = artifact.poseKnown && file.position.allFinite();
    const auto place = [](const Eigen::Vector3d& at, double unit) {
      Json values = Json::array();
      for (const double v : at) values.push_back(number(v / unit));
      return values;
    };
    out.push_back(Json{{"name", f.name},
                       {"nominal_mm", comparable ? place(file.position, kMillimetre) : Json(nullptr)},
                       {"actual_mm", place(f.position, kMillimetre)},
                       {"std_um", place(f.std, kMicrometre)},
                       {"nominal_radius_mm", f.ball ? number(file.radius / kMillimetre) : Json(nullptr)},
                       {"radius_mm", f.ball ? number(f.radius / kMillimetre) : Json(nullptr)},
                       {"radius_std_um", number(f.radiusStd / kMicrometre)}});
  }
  return out;
}

/// When the session began, where its stamps are those of a clock: an import and a simulation have none.
Json measuredJson(const ReportContents& r) {
  constexpr double kEarliest = 1.2e9;  // s; readings from before 2008 have the made-up date of an import
  const auto now = static_cast<double>(std::time(nullptr));
  if (!(r.session->epoch > kEarliest) || r.session->epoch > now + 86400.0) return nullptr;
  const auto seconds = static_cast<std::time_t>(r.session->epoch);
  std::tm utc{};
  char text[32];
  if (gmtime_r(&seconds, &utc) == nullptr || std::strftime(text, sizeof(text), "%FT%TZ", &utc) == 0)
    return nullptr;
  return text;
}

Json thermalJson(const ThermalTest& test) {
  Json axes = Json::array(), temperatures = Json::array();
  for (const AxisThermal& a : test.axes) {
    Json courses = Json::array();
    for (const ThermalCourse& c : a.courses)
      courses.push_back({{"at", rounded(c.at, kPlaceStep)},
                         {"hours", roundedList(c.hours, kHourStep)},
                         {"measured", roundedList(c.measured, kDeviationStep)},
                         {"left", roundedList(c.left, kDeviationStep)},
                         {"measured_range", rounded(c.measuredRange, kFigureStep)},
                         {"left_range", rounded(c.leftRange, kFigureStep)}});
    axes.push_back({{"axis", a.axis},
                    {"unit", a.rotary ? "arcsec" : "um"},
                    {"position_unit", a.rotary ? "deg" : "mm"},
                    {"measured_range", rounded(a.measuredRange, kFigureStep)},
                    {"left_range", rounded(a.leftRange, kFigureStep)},
                    {"courses", std::move(courses)}});
  }
  for (const TemperatureCourse& c : test.temperatures)
    temperatures.push_back({{"sensor", c.sensor},
                            {"hours", roundedList(c.hours, kHourStep)},
                            {"temperature", roundedList(c.temperature, kTemperatureStep)}});
  return {{"axes", std::move(axes)}, {"temperatures", std::move(temperatures)}};
}

/// What each thermal_network of the model learned, in words.
Json networkSummaries(const Model& model) {
  Json out = Json::array();
  for (const EffectPtr& effect : model.effects())
    if (const LearnedNetwork* learned = effect->network())
      out.push_back({{"in_words", inWords(effect->spec())}, {"summary", learned->summary}});
  return out;
}

/// Nominal value of each parameter, SI: zero, or what the catalogue takes for absolute quantities (a mount).
/// Empty where the model cannot be made again.
Eigen::VectorXd nominalValues(const Calibration& c) {
  try {
    const Eigen::VectorXd start = modelOf(c).start();
    return start.size() == static_cast<Eigen::Index>(c.values.size()) ? start : Eigen::VectorXd();
  } catch (const Error&) {
    return {};
  }
}

/// What was added, with the values of the full refit.
Json addedJson(const ReportContents& r) {
  Json out = Json::array();
  if (!r.improved) return out;
  const Model& model = r.improved->problem->model();
  for (std::size_t e = r.calibration.effects.size(); e < model.effects().size(); ++e) {
    Json one;
    one["effect"] = effectJson(model.effects()[e]->spec());
    one["in_words"] = inWords(model.effects()[e]->spec());
    one["values"] = Json::array();
    for (int k = 0; k < model.effects()[e]->parameterCount(); ++k) {
      const int i = model.offset(static_cast<int>(e)) + k;
      const Parameter& p = model.parameter(i);
      one["values"].push_back(Json{{"name", p.name},
                                   {"value", number(r.improved->x[i] * p.toUnit)},
                                   {"std", number(r.improved->std(i) * std::abs(p.toUnit))},
                                   {"unit", p.unit}});
    }
    out.push_back(std::move(one));
  }
  return out;
}

Json outliersWithNames(const CalibrationResult& r) {
  Json out = Json::array();
  for (const Outlier& o : r.outliers) {
    const ResidualRow& row = r.problem->rows()[static_cast<std::size_t>(o.row)];
    const Observation& at = r.problem->session().observations[static_cast<std::size_t>(row.observation)];
    Json one;
    one["row"] = at.row;
    one["time_s"] = number(at.time);
    one["feature"] =
        at.feature >= 0
            ? Json(r.problem->session().artifact.features[static_cast<std::size_t>(at.feature)].name)
            : Json(nullptr);
    one["residual"] = number(o.residual / (row.angular ? kArcsecond : kMicrometre));
    one["unit"] = row.angular ? "arcsec" : "um";
    one["sigmas"] = number(o.residual / r.sigma[o.row]);
    out.push_back(std::move(one));
  }
  return out;
}

Json curvesJson(const std::vector<ConvergenceCurve>& curves) {
  Json out = Json::array();
  for (const ConvergenceCurve& c : curves)
    out.push_back(Json{{"name", c.name},
                       {"unit", c.angular ? "arcsec" : "um"},
                       {"generation", c.generation},
                       {"rms", c.rms}});
  return out;
}

}  // namespace

Json parametersJson(const Calibration& c) {
  Json out = Json::array();
  const Eigen::VectorXd nominal = nominalValues(c);
  for (std::size_t e = 0; e < c.effects.size(); ++e) {
    Json one;
    one["effect"] = effectJson(c.effects[e]);
    one["in_words"] = inWords(c.effects[e]);
    one["values"] = Json::array();
    for (std::size_t i = 0; i < c.values.size(); ++i) {
      const Calibration::Value& v = c.values[i];
      if (v.effect != static_cast<int>(e)) continue;
      Json value;
      value["nominal"] =
          nominal.size() > 0 ? number(nominal[static_cast<Eigen::Index>(i)] * v.toUnit) : Json(nullptr);
      value["name"] = v.name;
      value["value"] = number(v.value * v.toUnit);
      value["std"] = v.fixed ? Json(nullptr) : number(v.std * std::abs(v.toUnit));
      value["unit"] = v.unit;
      value["held"] = v.fixed;
      one["values"].push_back(std::move(value));
    }
    out.push_back(std::move(one));
  }
  return out;
}

std::string reportJson(const ReportContents& r) {
  const Calibration& c = r.calibration;
  const Diagnosis& d = r.diagnosis;
  const bool fitted = d.base.problem != nullptr;
  const bool angular = fitted ? d.angular : !std::isfinite(c.rms) && std::isfinite(c.rmsAngular);
  Json out;
  out["session"] = r.sessionPath;
  out["session_warning"] = r.session->warning;
  out["calibration"] = r.calibrationPath;
  out["calibration_id"] = c.id;
  out["calibrated"] = c.created;
  out["same_session"] =
      c.sessionHash.empty() ? Json(nullptr) : Json(c.sessionHash == sessionHash(*r.session));
  out["created"] = r.created;
  out["measured"] = measuredJson(r);
  out["serial"] = r.serial;
  out["operator"] = r.operatorName;
  out["software"] = c.software;
  out["machine"] = c.machineName;
  out["method"] = c.method;
  out["seed"] = c.seed;
  out["residuals"] = fitted ? Json(d.base.problem->rowCount()) : Json(nullptr);
  out["left_out"] = fitted ? d.base.problem->leftOut().size() : 0;
  out["unit"] = angular ? "arcsec" : "um";
  out["noise"] = fitted ? number(d.base.repeatability / (angular ? kArcsecond : kMicrometre)) : Json(nullptr);
  out["command"] = addCommand(d, r.sessionPath, r.calibrationPath);
  out["moves_command"] = movesCommand(r.sessionPath, r.calibrationPath);
  out["figures"] = figures(r);
  out["diagnosis"] = Json::parse(diagnoseJson(d));
  out["variables"] = variablesJson(r.variables);
  out["vectors"] = vectorsJson(r.vectors, *r.session);
  out["positioning"] = positioningJson(r.positioning);
  out["circles"] = circlesJson(r.circles);
  out["features"] = featuresJson(r);
  out["thermal"] = thermalJson(r.thermal);
  out["networks"] = fitted ? networkSummaries(d.base.problem->model()) : Json::array();
  out["ledger"] = ledgerJson(c.ledger, angular);
  out["parameters"] = parametersJson(c);
  out["added"] = addedJson(r);
  out["identifiability"] =
      fitted ? identifiabilityJson(*d.base.problem, d.base.identifiability, d.base.x) : Json(nullptr);
  out["point_set"] = Json::parse(pointSetJson(r.pointSet));
  out["curves"] = curvesJson(r.curves);
  out["outliers"] = fitted ? outliersWithNames(d.base) : Json::array();
  return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace mm
