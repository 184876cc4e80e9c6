#include "uncertainty/task_verdict.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/units.h"

namespace mm {
namespace {

/// Of a value that nobody measured nothing conforms.
std::string verdictWord(const TaskVerdict& v) {
  if (v.measured || v.conformity == Conformity::kUndecided) return nameOf(v.conformity);
  return v.conformity == Conformity::kConforms ? "predicted to keep the limit"
                                               : "predicted to exceed the limit";
}

/// Figures with the digits of their standard uncertainty, of which two are given: "largest |E|: predicted to
/// keep the limit; 0.42 um, limit 1.2 um, standard uncertainty 0.10 um, accepted up to 1.04 um".
std::string judgementInWords(const TaskVerdict& v, double nominal, bool oneSided) {
  const double u = v.std / kMicrometre, limit = (v.limits.upper - nominal) / kMicrometre;
  const int decimals = u > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(u))), 0, 9) : 3;
  const auto um = [&](double value) { return format("%.*f um", decimals, (value - nominal) / kMicrometre); };
  std::string text = v.of + ": " + verdictWord(v) + "; ";
  text += oneSided ? um(v.value) + format(", limit %.3g um", limit)
                   : format("%+.*f um from nominal, tolerance +-%.3g um", decimals,
                            (v.value - nominal) / kMicrometre, limit);
  text += format(", standard uncertainty %.*f um, ", decimals, u);
  if (!v.acceptance.exists || (oneSided && v.acceptance.upper < nominal))
    return text + "which is too large for this tolerance: no value can conform";
  return text + (oneSided ? "accepted up to " : "accepted within +-") + um(v.acceptance.upper);
}

TaskVerdict judged(const QuantityUncertainty& q, double value, double tolerance, bool measured = false) {
  TaskVerdict v;
  v.of = q.quantity.name;
  v.value = value;
  v.std = q.std;
  v.measured = measured;
  v.limits.upper = q.quantity.nominal + tolerance;
  if (!q.quantity.oneSided) v.limits.lower = q.quantity.nominal - tolerance;
  v.conformity = judge(value, q.std, v.limits);
  v.probability = probabilityWithin(value, q.std, v.limits);
  v.acceptance = acceptanceZone(q.std, v.limits);
  v.inWords = judgementInWords(v, q.quantity.nominal, q.quantity.oneSided);
  return v;
}

/// The whole test, by the share of the trials in which every length is within what is permitted; with the
/// length that is nearest to failing. A task of one length is judged by its normal distribution.
TaskVerdict judgedLengths(const TaskUncertainty& result, const PermissibleError& permissible) {
  TaskVerdict worst;
  worst.probability = 2.0;
  for (const QuantityUncertainty& q : result.quantities) {
    if (!(q.quantity.length > 0.0)) continue;
    const TaskVerdict v = judged(q, q.mean, permissible.at(q.quantity.length / kMillimetre) * kMicrometre);
    if (v.probability < worst.probability) worst = v;
  }
  std::string whole;
  if (std::isfinite(result.passes)) {
    worst.of = "all lengths";
    worst.probability = result.passes;
    worst.conformity = result.passes >= kConformanceProbability         ? Conformity::kConforms
                       : result.passes <= 1.0 - kConformanceProbability ? Conformity::kDoesNotConform
                                                                        : Conformity::kUndecided;
    whole = format("; the test with every length three times would pass with a probability of %.1f %%",
                   100.0 * result.passes);
  }
  worst.inWords = "MPE = " + permissible.inWords() + " (L in mm): " + verdictWord(worst) + whole +
                  "; of all lengths nearest to failing: " + worst.inWords;
  return worst;
}

}  // namespace

const QuantityUncertainty* probingOf(const TaskUncertainty& result) {
  for (const QuantityUncertainty& q : result.quantities)
    if (q.quantity.name == kProbingForm) return &q;
  return nullptr;
}

std::vector<TestLength> testLengthsOf(const TaskUncertainty& result) {
  std::vector<TestLength> lengths;
  for (const QuantityUncertainty& q : result.quantities)
    if (q.quantity.length > 0.0)
      lengths.push_back({q.quantity.length / kMillimetre, (q.mean - q.quantity.nominal) / kMicrometre,
                         q.std / kMicrometre});
  return lengths;
}

std::vector<TaskVerdict> verdictsOf(const TaskUncertainty& result, const ToleranceAsked& asked) {
  std::vector<TaskVerdict> verdicts;
  const QuantityUncertainty& headline = result.quantities[result.headline];
  if (std::isfinite(asked.measured) && !std::isfinite(asked.tolerance))
    throw InputError("--measured-mm needs a tolerance: --tolerance-um");
  const bool measured = std::isfinite(asked.measured);
  if (std::isfinite(asked.tolerance))
    verdicts.push_back(
        judged(headline, measured ? asked.measured : headline.mean, asked.tolerance, measured));
  if (asked.permissible) {
    if (testLengthsOf(result).empty())
      throw InputError("--mpe is for lengths, of which --task '" + result.task +
                       "' has none; use --task iso10360-2 or distance:…, or --tolerance-um");
    verdicts.push_back(judgedLengths(result, *asked.permissible));
  }
  if (std::isfinite(asked.permissibleProbing)) {
    const QuantityUncertainty* probing = probingOf(result);
    if (probing == nullptr)
      throw InputError("--mpe-probing-um: --task '" + result.task +
                       "' has no probing error; use iso10360-2, on a machine that was calibrated with balls");
    verdicts.push_back(judged(*probing, probing->mean, asked.permissibleProbing * kMicrometre));
  }
  return verdicts;
}

}  // namespace mm
