#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>

#include "base/error.h"
#include "base/format.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "base/utc_now.h"
#include "design/weak_directions.h"
#include "effects/effect_words.h"
#include "report/iso_tests_json.h"
#include "report/json_parts.h"
#include "report/report_contents.h"
#include "report/symbols_of.h"
#include "report/text_parts.h"
#include "session/session_hash.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

/// Five digits of the largest value.
double stepOf(const std::vector<double>& values) {
  double most = 0.0;
  for (const double v : values)
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  return most > 0.0 ? std::pow(10.0, std::floor(std::log10(most)) - 4.0) : 1.0;
}

/// The residuals of one kind, lengths or angles; null: there are none.
Json sizesOfKind(const CalibrationResult& fit, bool angular) {
  const ResidualFigures& f = fit.figures;
  const SizeOfResiduals size = sizeOfResiduals(fit, angular);
  if (size.count == 0) return nullptr;
  const double unit = unitOf(angular);
  const std::string suffix = "_" + nameOfUnit(angular);
  // of an RMS of independent normal residuals
  const double rms = angular ? f.rmsAngular : f.rms;
  const double share = static_cast<double>(f.degreesOfFreedom) / std::max(1, fit.problem->rowCount());
  Json json{{"max" + suffix, size.max / unit},
            {"rms_std" + suffix, rms / unit / std::sqrt(2.0 * std::max(1.0, share * size.count))},
            {"count" + suffix, size.count}};
  for (const auto& [percent, value] : size.quantiles)
    if (percent == 95) json["q95" + suffix] = value / unit;
  return json;
}

Json namedFigures(const std::string& name, const std::string& note, const ResidualFigures& f) {
  return jsonObject({{{"name", name}, {"note", note}},
                     figuresJson(f, true),
                     {{"chi2_per_dof", orNull(f.degreesOfFreedom > 0, f.chi2PerDof)},
                      {"degrees_of_freedom", f.degreesOfFreedom}}});
}

Json namedFit(const std::string& name, const std::string& note, const CalibrationResult& fit) {
  return jsonObject({namedFigures(name, note, fit.figures),
                     {{"outliers", fit.outliers.size()}},
                     sizesOfKind(fit, false),
                     sizesOfKind(fit, true)});
}

Json figures(const ReportContents& r) {
  constexpr const char* kNoEffect = "no effect in the model";
  const CalibrationResult& base = r.diagnosis.base;
  Json out = Json::array();
  if (!base.problem) return out;
  if (!r.calibrated()) {
    out.push_back(namedFit("The machine as it is", kNoEffect, base));
    return out;
  }
  out.push_back(r.nominal ? namedFit("Nominal machine", kNoEffect, *r.nominal)
                          : namedFigures("Nominal machine", kNoEffect, base.before));
  if (r.held)
    out.push_back(namedFit(
        "This calibration, values held",
        "is it still valid here? Only the artifact's pose, free centres and zeros are fitted", *r.held));
  out.push_back(
      namedFit("This calibration, refitted", "the same effects, values fitted to this session", base));
  if (r.improved)
    out.push_back(namedFit("With the named effects added", "what the diagnosis proposes", *r.improved));
  return out;
}

Json variableJson(const VariableView& v) {
  const Json at = jsonList(v.bins, &VariableBin::at);
  const double yStep = stepOf(v.y);
  return {{"name", v.name},
          {"unit", v.unit},
          {"category", v.category},
          {"labels", v.labels},
          {"direction", v.direction},
          {"share", v.share},
          {"p_value", v.pValue},
          {"observations", v.observations},
          {"at", roundedList(at, stepOf(at))},
          {"mean", roundedList(v.bins, yStep * 0.1, &VariableBin::mean)},
          {"standard_error", roundedList(v.bins, yStep * 0.01, &VariableBin::standardError)},
          {"improved", roundedList(v.bins, yStep * 0.1, &VariableBin::meanImproved)},
          {"count", jsonList(v.bins, &VariableBin::count)},
          {"x", roundedList(v.x, stepOf(v.x))},
          {"y", roundedList(v.y, yStep)}};
}

Json vectorsJson(const ResidualVectors& v, const Session& session) {
  if (v.places.empty()) return nullptr;
  using Place = ResidualVectors::Place;
  const auto feature = [&](const Place& p) {
    return p.feature >= 0 ? session.artifact.features[static_cast<std::size_t>(p.feature)].name
                          : std::string();
  };
  const auto state = [](const ResidualVectors::State& s) -> Json {
    const auto vector = [](const Eigen::Vector3d& one) { return roundedList(one, kDeviationStep); };
    return {{"name", s.name},
            {"vector_um", jsonList(s.vectors, vector)},
            {"value_um", roundedList(s.values, kDeviationStep)}};
  };
  const auto ball = [](const ResidualVectors::Ball& b) { return ballJson(b.name, b.centre, b.radius); };
  return {{"observations", v.observations},
          {"signed", v.signedValues},
          {"at_mm", jsonList(v.places, [](const Place& p) { return roundedList(p.at, kPlaceStep); })},
          {"row", jsonList(v.places, &Place::row)},
          {"feature", jsonList(v.places, feature)},
          {"outlier", jsonList(v.places, [](const Place& p) { return p.outlier ? 1 : 0; })},
          {"states", jsonList(v.states, state)},
          {"balls", jsonList(v.balls, ball)}};
}

/// Balls and points: where the file has them beside where the session found them, in the artifact's frame
/// where that is the workpiece's, else found alone.
Json foundJson(const ReportContents& r) {
  Json out = Json::array();
  const Artifact& artifact = r.session->artifact;
  for (const FoundFeature& f : r.features) {
    if (!(f.std.maxCoeff() > 0.0) && !(f.radiusStd > 0.0)) continue;  // nothing was asked
    const Feature& file = artifact.features[static_cast<std::size_t>(artifact.findFeature(f.name))];
    const bool comparable = artifact.poseKnown && file.position.allFinite();
    const auto place = [](const Eigen::Vector3d& at, double unit) {
      return Json(Eigen::Vector3d(at / unit));
    };
    out.push_back({{"name", f.name},
                   {"nominal_mm", orNull(comparable, place(file.position, kMillimetre))},
                   {"actual_mm", place(f.position, kMillimetre)},
                   {"std_um", place(f.std, kMicrometre)},
                   {"nominal_radius_mm", orNull(f.ball, file.radius / kMillimetre)},
                   {"radius_mm", orNull(f.ball, f.radius / kMillimetre)},
                   {"radius_std_um", f.radiusStd / kMicrometre}});
  }
  return out;
}

/// When the session began, where its stamps are those of a clock: an import and a simulation have none.
Json measuredJson(const ReportContents& r) {
  constexpr double kEarliest = 1.2e9;  // s; readings from before 2008 have the made-up date of an import
  const auto now = static_cast<double>(std::time(nullptr));
  if (!(r.session->epoch > kEarliest) || r.session->epoch > now + 86400.0) return nullptr;
  return utcText(r.session->epoch);
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
  const ErrorSymbols symbols = symbolsOf(*r.improved);
  for (std::size_t e = r.calibration.effects.size(); e < model.effects().size(); ++e) {
    Json values = Json::array();
    for (int k = 0; k < model.effects()[e]->parameterCount(); ++k) {
      const int i = model.offset(static_cast<int>(e)) + k;
      const Parameter& p = model.parameter(i);
      values.push_back(parameterJson(p.name, r.improved->x[i] * p.toUnit,
                                     r.improved->std(i) * std::abs(p.toUnit), p.unit));
    }
    out.push_back(jsonObject({effectInWords(model.effects()[e]->spec(), symbols), {{"values", values}}}));
  }
  return out;
}

Json outliersWithNames(const CalibrationResult& r) {
  return jsonList(r.outliers, [&](const Outlier& o) -> Json {
    const ResidualRow& row = r.problem->rows()[static_cast<std::size_t>(o.row)];
    const Session& session = r.problem->session();
    const Observation& at = session.observations[static_cast<std::size_t>(row.observation)];
    const auto feature = static_cast<std::size_t>(at.feature);
    return {{"row", at.row},
            {"time_s", at.time},
            {"feature", at.feature >= 0 ? Json(session.artifact.features[feature].name) : Json()},
            {"residual", o.residual / unitOf(row.angular)},
            {"unit", nameOfUnit(row.angular)},
            {"sigmas", o.residual / r.sigma[o.row]}};
  });
}

Json addedProfileJson(const AddedProfile& p) {
  const auto point = [](const ProfileCurve::Point& c) -> Json {
    return Json::array({c.at[0], c.value, c.std});
  };
  return {{"in_words", p.inWords},
          {"direction", p.direction},
          {"unit", p.curve.unit},
          {"variables", Json::array({p.variable})},
          {"units", Json::array({p.variableUnit})},
          {"curve", jsonList(p.curve.points, point)},
          {"x", roundedList(p.x, stepOf(p.x))},
          {"y", roundedList(p.y, stepOf(p.y))}};
}

/// What there is without a diagnosis: the residuals' noise, and where the nominal machine fails.
Json nothingDiagnosed(const Diagnosis& d) {
  return jsonObject({diagnosisJson(d), {{"verdict", nullptr}, {"sentence", nullptr}}});
}

Json rotationsJson(const ReportContents& r) {
  return jsonList(r.rotations, [](const RotationPair& p) -> Json {
    return {{"joint", p.measured.joint},
            {"setup", p.measured.setup},
            {"measured", rotationJson(p.measured)},
            {"left", rotationJson(p.left)}};
  });
}

Json curveJson(const ConvergenceCurve& c) {
  return {{"name", c.name}, {"unit", nameOfUnit(c.angular)}, {"generation", c.generation}, {"rms", c.rms}};
}

}  // namespace

std::string reportTitle(const ReportContents& r) {
  std::string title = std::filesystem::path(r.calibration.machineName).stem().string();
  if (const Json measured = measuredJson(r); measured.is_string())
    title += ", " + measured.get<std::string>().substr(0, 10);
  double lower = kNotMeasured, upper = kNotMeasured;
  for (const InputCoverage& input : r.pointSet.inputs) {
    if (!input.temperature) continue;
    lower = std::fmin(lower, input.lower);
    upper = std::fmax(upper, input.upper);
  }
  if (std::isfinite(lower))
    title += upper - lower < 0.05 ? format(", %.1f °C", lower) : format(", %.1f to %.1f °C", lower, upper);
  return title;
}

std::string reportSentence(const ReportContents& r) {
  return r.calibrated() ? r.diagnosis.sentence : "The machine as it is, without a calibration.";
}

Json parametersJson(const Calibration& c) {
  Json out = Json::array();
  const ErrorSymbols symbols = symbolsOf(c);
  const Eigen::VectorXd nominal = nominalValues(c);
  for (std::size_t e = 0; e < c.effects.size(); ++e) {
    Json values = Json::array();
    for (std::size_t i = 0; i < c.values.size(); ++i) {
      const Calibration::Value& v = c.values[i];
      if (v.effect != static_cast<int>(e)) continue;
      const double at = nominal.size() > 0 ? nominal[static_cast<Eigen::Index>(i)] : kNotMeasured;
      values.push_back({{"nominal", at * v.toUnit},
                        {"name", v.name},
                        {"meaning", meaningOf(c.effects[e], v.name)},
                        {"value", v.value * v.toUnit},
                        {"std", orNull(!v.fixed, v.std * std::abs(v.toUnit))},
                        {"unit", v.unit},
                        {"held", v.fixed}});
    }
    out.push_back(jsonObject({effectInWords(c.effects[e], symbols), {{"values", values}}}));
  }
  return out;
}

std::string reportJson(const ReportContents& r) {
  const Calibration& c = r.calibration;
  const Diagnosis& d = r.diagnosis;
  const CalibrationResult& base = d.base;
  const bool fitted = base.problem != nullptr, compared = !c.sessionHash.empty();
  const bool angular = fitted ? d.angular : angularOnly(c);
  return jsonLine({{"title", reportTitle(r)},
                   {"session", r.sessionPath},
                   {"session_warning", r.session->warning},
                   {"calibration", orNull(r.calibrated(), r.calibrationPath)},
                   {"sentence", reportSentence(r)},
                   {"tests", testsJson(r.tests)},
                   {"calibration_id", c.id},
                   {"calibrated", c.created},
                   {"same_session", compared ? Json(c.sessionHash == sessionHash(*r.session)) : Json()},
                   {"created", r.created},
                   {"measured", measuredJson(r)},
                   {"serial", r.serial},
                   {"operator", r.operatorName},
                   {"software", c.software},
                   {"machine", c.machineName},
                   {"method", c.method},
                   {"seed", c.seed},
                   {"residuals", fitted ? Json(base.problem->rowCount()) : Json()},
                   {"left_out", fitted ? base.problem->leftOut().size() : 0},
                   {"unit", nameOfUnit(angular)},
                   {"noise", orNull(fitted, base.repeatability / unitOf(angular))},
                   {"command", orNull(r.calibrated(), addCommand(d, r.sessionPath, r.calibrationPath))},
                   {"moves_command", orNull(r.calibrated(), movesCommand(r.sessionPath, r.calibrationPath))},
                   {"figures", figures(r)},
                   {"diagnosis", r.calibrated() ? diagnosisJson(d) : nothingDiagnosed(d)},
                   {"variables", jsonList(r.variables, variableJson)},
                   {"vectors", vectorsJson(r.vectors, *r.session)},
                   {"positioning", positioningJson(r.positioning)},
                   {"circles", circlesJson(r.circles)},
                   {"diagonals", diagonalsJson(r.diagonals)},
                   {"rotations", rotationsJson(r)},
                   {"lengths", lengthsJson(r.lengths)},
                   {"features", foundJson(r)},
                   {"thermal", thermalJson(r.thermal, r.session->machine)},
                   {"networks", fitted ? networkSummaries(base.problem->model()) : Json::array()},
                   {"ledger", ledgerJson(c.ledger, angular, symbolsOf(c))},
                   {"parameters", parametersJson(c)},
                   {"weak", fitted ? jsonList(weakDirections(base), &WeakDirection::inWords) : Json::array()},
                   {"profiles", jsonList(r.profiles, addedProfileJson)},
                   {"added", addedJson(r)},
                   {"identifiability",
                    fitted ? identifiabilityJson(*base.problem, base.identifiability, base.x) : Json()},
                   {"point_set", pointSetObject(r.pointSet)},
                   {"curves", jsonList(r.curves, curveJson)},
                   {"outliers", fitted ? outliersWithNames(base) : Json::array()}});
}

}  // namespace mm
