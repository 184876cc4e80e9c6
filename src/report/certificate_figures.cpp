#include "report/certificate_figures.h"

#include <algorithm>
#include <cmath>

#include "base/distributions.h"
#include "base/erase_if.h"
#include "base/format.h"
#include "base/quantity_words.h"
#include "base/text.h"
#include "base/units.h"
#include "effects/effect_words.h"
#include "report/certificate_facts.h"
#include "report/symbols_of.h"
#include "report/text_parts.h"
#include "report/uncertainty_output.h"

namespace mm {
namespace {

constexpr double kManyDegreesOfFreedom = 200.0;  // above it a Student's t is a normal distribution

/// Three significant digits, without an exponent.
std::string threeDigits(double value) {
  const double size = std::abs(value);
  return decimalText(value,
                     size > 0.0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(size))), 0, 9) : 2);
}

/// @param value, expanded in the unit.
StatedFigure figureWith(const std::string& of, const std::string& name, double value, double expanded,
                        const std::string& unit) {
  const int decimals = decimalsOf(expanded);
  return {of, name, decimalText(value, decimals), decimalText(expanded, decimals), unit};
}

StatedFigure figureAlone(const std::string& name, double value, const std::string& unit) {
  StatedFigure figure{{}, name, threeDigits(value), {}, unit};
  figure.note = "informative, without uncertainty";
  return figure;
}

/// Left out where it does not exist.
void addFigure(StatedGroup& group, const std::string& name, double value, const std::string& unit) {
  if (std::isfinite(value)) group.figures.push_back(figureAlone(name, value, unit));
}

StatedGroup parameterFigures(const Calibration& c) {
  const std::string uncertainty = parameterUncertainty(c);
  StatedGroup group{FigureOrigin::kEstimated, "Parameters of the machine", {}, uncertainty};
  const ErrorSymbols symbols = symbolsOf(c);
  const bool normal = !(c.degreesOfFreedom > 0.0) || c.degreesOfFreedom >= kManyDegreesOfFreedom;
  const std::string coverage =
      normal ? "0.95" : format("%.2f", 1.0 - 2.0 * studentTail(2.0, c.degreesOfFreedom));
  for (const Calibration::Value& v : c.values) {
    StatedFigure figure = figureWith(inWords(c.effects[static_cast<std::size_t>(v.effect)], symbols), v.name,
                                     v.value * v.toUnit, 2.0 * v.std * std::abs(v.toUnit), v.unit);
    figure.held = v.fixed;
    figure.coverage = coverage;
    figure.note = v.fixed                                    ? "held by a convention, without an uncertainty"
                  : uncertainty != StatedGroup().uncertainty ? "uncertainty: " + uncertainty
                                                             : "";
    if (v.fixed)
      figure.expanded.clear();
    else
      figure.distribution =
          normal ? "normal" : format("Student's t, %.0f degrees of freedom", c.degreesOfFreedom);
    group.figures.push_back(std::move(figure));
  }
  return group;
}

StatedGroup residualFigures(const Calibration& c) {
  const bool angular = angularOnly(c);
  const std::string unit = angular ? "arcsec" : "um";
  const double to = 1.0 / (angular ? kArcsecond : kMicrometre);
  StatedGroup group{FigureOrigin::kEstimated, "Residuals of the measurements", {}};
  addFigure(group, "RMS", (angular ? c.rmsAngular : c.rms) * to, unit);
  addFigure(group, "RMS at measurements that the fit did not use",
            (angular ? c.heldOutRmsAngular : c.heldOutRms) * to, unit);
  addFigure(group, "repeatability (" + c.repeatabilityFrom + ")", c.repeatability * to, unit);
  addFigure(group, "χ²/ν", c.chi2PerDof, "1");
  return group;
}

/// @param corrected whether the figures are those with the correction, which nobody measured.
StatedGroup sessionFigures(const CertifiedSession& s, bool corrected) {
  const double unit = s.angular ? kArcsecond : kMicrometre;
  StatedGroup group;
  group.origin = corrected ? FigureOrigin::kCalculated : FigureOrigin::kMeasured;
  group.title = corrected ? "The session with the correction applied to its readings"
                          : "Deviations of the machine as it is";
  addFigure(group, "RMS", (corrected ? s.corrected : s.uncorrected) / unit, s.angular ? "arcsec" : "um");
  for (const AxisPositioning& a : s.positioning) {
    const PositioningFigures& f = corrected ? a.calibrated.figures : a.measured.figures;
    const std::string axis = "axis " + a.name + ": ", in = a.rotary ? "arcsec" : "um";
    addFigure(group, axis + "A, accuracy of positioning", f.accuracy, in);
    addFigure(group, axis + "R, repeatability of positioning", f.repeatability, in);
    addFigure(group, axis + "E, systematic deviation of positioning", f.systematic, in);
    addFigure(group, axis + "B, reversal error", f.reversal, in);
    addFigure(group, axis + "M, mean deviation of positioning", f.meanRange, in);
  }
  return group;
}

std::string nameOfFigure(const QuantityUncertainty& q, bool wholeTest) {
  return wholeTest && q.quantity.name == "largest |E|"
             ? "largest |E| of a whole test, every length measured three times"
             : q.quantity.name;
}

StatedFigure figureOfQuantity(const QuantityUncertainty& q, bool wholeTest) {
  const double unit = q.quantity.oneSided ? kMicrometre : kMillimetre;
  StatedFigure figure = figureWith({}, nameOfFigure(q, wholeTest), q.mean / unit, 2.0 * q.std / unit,
                                   q.quantity.oneSided ? "um" : "mm");
  if (!q.quantity.oneSided) return figure;
  const int decimals = decimalsOf(2.0 * q.std / unit);
  figure.expanded.clear();
  figure.standard = decimalText(q.std / unit, decimalsOf(q.std / unit));
  const std::string lower = decimalText(q.lower / unit, decimals),
                    upper = decimalText(q.upper / unit, decimals);
  figure.interval = lower + " … " + upper;
  figure.note = "95 % between " + lower + " and " + upper;
  return figure;
}

std::string timesText(double ratio) { return format("%.*f times", ratio < 10.0 ? 1 : 0, ratio); }

/// Whether a task's points are on one line, where of the artifact its scale alone matters.
bool isAlongLine(const std::string& task) {
  return startsWith(task, "distance:") || startsWith(task, "iso230-2:");
}

/// "of its features", or "of b2, b7" where the others state it.
std::string whoseUncertainty(const std::vector<std::string>& names, std::size_t all) {
  if (names.empty() || names.size() == all) return "of its features";
  return "of " + joined(names, ", ");
}

}  // namespace

const char* nameOf(FigureOrigin origin) {
  static constexpr const char* kNames[] = {"estimated from the measurements", "measured",
                                           "calculated, not measured", "predicted, not measured"};
  return kNames[static_cast<std::size_t>(origin)];
}

std::string rangeText(double lower, double upper, const std::string& unit) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return "not recorded";
  return format("%.4g to %.4g", lower, upper) + (unit.empty() ? "" : " " + unit);
}

bool timesRecorded(const Domain& domain) { return domain.duration > 0.0; }

std::string driftText(const Domain& domain, const Wandering& drift) {
  const bool rotary = isRotary(domain, drift.direction);
  return "along " + (drift.direction == "approach" ? "the approach" : drift.direction) +
         format(": standard deviation %.2g %s", drift.std / (rotary ? kArcsecond : kMicrometre),
                rotary ? "arcsec" : "um") +
         (timesRecorded(domain) ? ", time constant " + durationInWords(drift.timeConstant)
                                : ", in the order of the measurements; no times were recorded");
}

StatedGroup taskFigures(const CertifiedTask& task) {
  const TaskUncertainty& r = task.result;
  const bool test = testLengthsOf(r).size() > 1;
  StatedGroup group{FigureOrigin::kPredicted, r.task, {figureOfQuantity(r.quantities[r.headline], test)}};
  for (std::size_t q = 0; q < r.quantities.size(); ++q)
    if (q != r.headline && !(test && r.quantities[q].quantity.length > 0.0))
      group.figures.push_back(figureOfQuantity(r.quantities[q], test));
  return group;
}

LengthTable lengthTable(const TaskUncertainty& task) {
  LengthTable table;
  if (testLengthsOf(task).size() < 2) return table;
  std::vector<TestLength> stated;
  for (const QuantityUncertainty& q : task.quantities) {
    if (q.quantity.name == "largest |E|") table.wholeTest = q.mean / kMicrometre;
    if (!(q.quantity.length > 0.0)) continue;
    LengthRow row;
    row.length = q.quantity.length / kMillimetre;
    const double expanded = 2.0 * q.std / kMicrometre;
    row.error = figureWith({}, q.quantity.name, (q.mean - q.quantity.nominal) / kMicrometre, expanded, "um");
    // Of the figures as they are printed, so that table and plot can be added up.
    const TestLength printed{row.length, std::stod(row.error.value), 0.5 * std::stod(row.error.expanded)};
    row.sum = std::abs(printed.error) + 2.0 * printed.std;
    row.sumText = decimalText(row.sum, decimalsOf(expanded));
    if (table.rows.empty() || row.sum > table.rows[table.largest].sum) table.largest = table.rows.size();
    table.rows.push_back(std::move(row));
    stated.push_back(printed);
  }
  table.least = permissibleFor(stated);
  return table;
}

std::vector<StatedGroup> statedGroups(const Certificate& c) {
  std::vector<StatedGroup> groups = {parameterFigures(c.calibration), residualFigures(c.calibration)};
  eraseIf(groups, [](const StatedGroup& group) { return group.figures.empty(); });
  if (c.session) {
    groups.push_back(sessionFigures(*c.session, false));
    groups.push_back(sessionFigures(*c.session, true));
  }
  for (const CertifiedTask& task : c.tasks) {
    groups.push_back(taskFigures(task));
    const LengthTable table = lengthTable(task.result);
    if (table.rows.empty()) continue;
    StatedGroup lengths{FigureOrigin::kPredicted, task.result.task + ": error E of each length", {}};
    for (const LengthRow& row : table.rows) lengths.figures.push_back(row.error);
    groups.push_back(std::move(lengths));
  }
  return groups;
}

std::string parameterUncertainty(const Calibration& calibration) {
  return uncertaintyNotStated(calibration, {}, false).empty() ? StatedGroup().uncertainty
                                                              : "2 s of the fit; reference not included";
}

std::string modelLeaves(const Calibration& c) {
  const double left = timesRepeatability(c.repeatabilityFrom, c.chi2PerDof);
  if (!(left > 0.0))
    return "Whether the model leaves more than the repeatability is not known: this was estimated from its "
           "residuals";
  return "The model leaves " + timesText(left) + " the repeatability" +
         (left > kLeavesMore ? ": errors that this model does not describe remain" : "");
}

void decideConformity(Certificate& certificate) {
  const Calibration& c = certificate.calibration;
  for (CertifiedTask& task : certificate.tasks) {
    task.noConformity = uncertaintyNotStated(c, certificate.conditions, isAlongLine(task.result.task));
    if (const double left = timesRepeatability(c.repeatabilityFrom, c.chi2PerDof); left > kLeavesMore)
      task.noConformity.push_back("the model leaves " + timesText(left) + " the repeatability");
    for (const std::string& why : task.result.outside)
      task.noConformity.push_back("the calibration does not hold " + why);
    if (isSimulated(c)) task.noConformity.push_back("the session is simulated");
    if (!task.noConformity.empty()) task.verdicts.clear();
  }
}

std::string headOf(const CertifiedTask& task, const TaskVerdict& verdict) {
  if (verdict.measured) return "Of the measured value that the issuer states";
  return task.result.task == "iso10360-2" ? "ISO 10360-2 (predicted, no test was made)"
                                          : "Predicted, no test was made";
}

std::vector<std::string> uncertaintyNotStated(const Calibration& calibration,
                                              const TaskConditions& conditions, bool alongLine) {
  const bool scale = conditions.artifactScale > 0.0, radius = conditions.artifactRadius > 0.0;
  if (!calibration.artifact || calibration.artifact->features == 0) {
    if (scale) return {};
    return {std::string(calibration.artifact ? "the uncertainty of the independent instrument is not stated"
                                             : "the calibration file does not record its reference") +
            ": give its standard uncertainty with --artifact-scale-um-m"};
  }
  const CalibratedBy& a = *calibration.artifact;
  std::vector<std::string> places, radii;  // of which features it is not stated
  std::size_t known = 0, balls = 0;
  for (const FoundInArtifact& f : a.found) {
    known += f.free ? 0 : 1;
    balls += f.ball ? 1 : 0;
    if (!f.free && !(f.std.maxCoeff() > 0.0)) places.push_back(f.name);
    if (f.ball && !(f.radiusStd > 0.0)) radii.push_back(f.name);
  }
  const bool points = !a.found.empty() && balls == 0;
  std::vector<std::string> missing;
  const std::string artifact = "artifact '" + a.name + "': the uncertainty of the ";
  const bool scaleStatesIt = scale && (points || alongLine);
  if (!scaleStatesIt && (!(a.centreStd > 0.0) || !places.empty()))
    missing.push_back(artifact + "positions " + whoseUncertainty(places, known) + " is not stated: add " +
                      (points ? "'position_std_um: …' to their lines below 'points:'"
                              : "'centre_std_um: …' to their lines below 'balls:'") +
                      " in its YAML file and calibrate again" +
                      (points || alongLine ? ", or give --artifact-scale-um-m" : ""));
  if (!points && !radius && (!(a.radiusStd > 0.0) || !radii.empty()))
    missing.push_back(
        artifact + "radii " + whoseUncertainty(radii, balls) +
        " is not stated: add 'radius_std_um: …' to their lines below 'balls:' in its YAML file and "
        "calibrate again, or give --artifact-radius-um");
  return missing;
}

}  // namespace mm
