#include "report/certificate_facts.h"

#include <cmath>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "report/certificate_figures.h"
#include "report/text_parts.h"
#include "verification/trend.h"

namespace mm {
namespace {

std::string statedInstead(const std::string& text, const std::string& instead) {
  return text + ", stated by the issuer; " + instead;
}

/// As it was typed where it is not the usual one.
StatedFact conditionFact(const char* name, double value, double usual, const char* form) {
  const std::string text = format(form, value);
  return {name, value == usual ? text : statedInstead(text, "usual: " + format(form, usual))};
}

StatedFact repeatabilityFact(const Calibration& k, const TaskConditions& given) {
  const bool angular = angularOnly(k);
  const auto text = [&](double v) {
    return format("%.3f %s", v / (angular ? kArcsecond : kMicrometre), angular ? "arcsec" : "um");
  };
  return {"Repeatability of the probe",
          given.repeatability < 0.0 ? text(k.repeatability) + ", of the calibration"
                                    : statedInstead(format("%.3f um", given.repeatability / kMicrometre),
                                                    "calibration: " + text(k.repeatability))};
}

/// Each sensor: what was stated, else the middle of its range.
void addTemperatures(const Domain& d, const TaskConditions& given, std::vector<StatedFact>& facts) {
  for (std::size_t s = 0; s < d.sensors.size(); ++s) {
    const double middle = 0.5 * (d.sensorLower[s] + d.sensorUpper[s]);
    const std::string usual = std::isfinite(middle)
                                  ? format("middle of the calibrated range: %.2f degC", middle)
                                  : std::string("not recorded in the calibration");
    std::string text = usual;
    for (const TaskConditions::Temperature& t : given.temperatures)
      if (t.sensor == d.sensors[s])
        text =
            statedInstead(format("%.2f degC", t.value) +
                              (t.std > 0.0 ? format(", standard uncertainty %.2g K", t.std) : std::string()),
                          usual);
    facts.push_back({"Temperature " + d.sensors[s], text});
  }
}

/// Positions and directions of axes, which only the issuer can state.
void addAxes(const Domain& d, const TaskConditions& given, std::vector<StatedFact>& facts) {
  for (const TaskConditions::JointValue& p : given.positions) {
    const bool rotary = isRotary(d, p.joint);
    facts.push_back({"Position of axis " + p.joint,
                     format("%.6g %s, stated by the issuer", p.value / (rotary ? kDegree : kMillimetre),
                            rotary ? "deg" : "mm")});
  }
  for (const TaskConditions::JointValue& t : given.travel)
    facts.push_back(
        {"Direction of travel of axis " + t.joint, statedInstead(t.value < 0.0 ? "-1" : "+1", "usual: +1")});
  if (given.approach.norm() > 0.0)
    facts.push_back(
        {"Direction of approach", format("%.4g, %.4g, %.4g, stated by the issuer", given.approach.x(),
                                         given.approach.y(), given.approach.z())});
}

/// Unit that the name of a covariate carries: "%" of "humidity_percent"; empty: none.
std::string covariateUnit(const std::string& name) {
  const std::size_t at = name.rfind('_');
  const std::string unit = at == std::string::npos ? std::string() : name.substr(at + 1);
  if (unit == "percent") return "%";
  for (const char* known : {"hPa", "kPa", "Pa", "bar", "degC", "K"})
    if (unit == known) return unit;
  return {};
}

bool anyKnownTemperature(const Domain& d) {
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    if (std::isfinite(d.sensorLower[s]) && std::isfinite(d.sensorUpper[s])) return true;
  return false;
}

}  // namespace

bool isKnown(const std::string& fact) {
  return !trim(fact).empty() && lower(std::string(trim(fact))) != "unknown";
}

bool isSimulated(const Calibration& k) { return k.sessionOrigin == "simulated"; }

std::string titleOf(const Certificate& c) {
  const CertificateFacts& f = c.facts;
  const bool complete = isKnown(f.laboratory) && isKnown(c.facts.serial) && isKnown(f.customer) &&
                        (isKnown(f.operatorName) || isKnown(f.authorisedBy)) && isKnown(f.traceability) &&
                        hasDate(c.calibration) && !isSimulated(c.calibration);
  return complete ? "Calibration certificate" : "Record of calibration";
}

std::string dateOfMeasurement(const Calibration& k) { return hasDate(k) ? measuredAt(k) : std::string(); }

std::vector<StatedFact> conditionsOfPrediction(const Certificate& c) {
  const Domain& d = c.calibration.domain;
  const TaskConditions &given = c.conditions, usual;
  std::vector<StatedFact> facts = {repeatabilityFact(c.calibration, given)};
  addTemperatures(d, given, facts);
  addAxes(d, given, facts);
  if (c.points > 0)
    facts.push_back(
        {"Points of each feature", statedInstead(std::to_string(c.points), "usual: as the task needs")});
  facts.push_back({"Time", std::isnan(given.time)
                               ? "end of the calibrated session"
                               : statedInstead(format("%.6g s of the calibrated session", given.time),
                                               "usual: its end")});
  facts.push_back(conditionFact("Time from point to point", given.interval, usual.interval, "%.3g s"));
  facts.push_back(conditionFact("Speed of approach", given.contactSpeed / kMillimetre,
                                usual.contactSpeed / kMillimetre, "%.3g mm/s"));
  facts.push_back(conditionFact("Margin beyond the calibrated ranges", 100.0 * given.margin,
                                100.0 * usual.margin, "%.3g %%"));
  const std::string quarter =
      format("a quarter of the volume's diagonal: %.4g mm", usualRemainderLength(d) / kMillimetre);
  facts.push_back(
      {"Length over which the unexplained error changes",
       std::isnan(given.remainderLength)
           ? quarter
           : statedInstead(format("%.4g mm", given.remainderLength / kMillimetre), "usual: " + quarter)});
  return facts;
}

std::vector<StatedFact> axisRanges(const Domain& d) {
  std::vector<StatedFact> ranges;
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    const JointUnit unit = readingUnit(d.joints[j]);
    ranges.push_back(
        {d.joints[j].name, rangeText(d.lower[j] / unit.factor, d.upper[j] / unit.factor, unit.symbol)});
  }
  return ranges;
}

std::vector<StatedFact> covariateRanges(const Domain& d) {
  std::vector<StatedFact> ranges;
  for (std::size_t v = 0; v < d.covariates.size(); ++v)
    ranges.push_back({d.covariates[v],
                      rangeText(d.covariateLower[v], d.covariateUpper[v], covariateUnit(d.covariates[v]))});
  return ranges;
}

std::string decisionRule(const Certificate& c) {
  bool asked = false, decided = false;
  for (const CertifiedTask& t : c.tasks) {
    asked = asked || t.asked;
    decided = decided || !t.verdicts.empty();
  }
  if (!decided)
    return asked ? "No statement of conformity is made; each task says why."
                 : "No specification was stated; no statement of conformity is made.";
  return std::string(
             "Decision rule: ISO 14253-1:2017; conformity or nonconformity is stated, or predicted, where "
             "its probability, considering the uncertainty, is 95 % or more; otherwise neither is proven.") +
         (isKnown(c.facts.traceability)
              ? ""
              : " The traceability of the reference is not stated: the statement holds "
                "relative to its stated values.");
}

std::string scopeOfResults(const Calibration& k) {
  const bool referred = k.domain.artifactExpansion != 0.0 && anyKnownTemperature(k.domain);
  return std::string(
             "The results relate only to the item calibrated. They are valid within these ranges; changes "
             "of the machine after the calibration are not covered.") +
         (referred ? format(" Lengths refer to %.0f degC.", kReferenceTemperature) : std::string());
}

}  // namespace mm
