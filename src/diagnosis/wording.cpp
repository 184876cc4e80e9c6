#include "diagnosis/wording.h"

#include <cmath>
#include <cstdio>

#include "machine/units.h"

namespace mm {
namespace {

std::string listOf(const std::vector<CandidateResult>& missing) {
  std::string text;
  for (std::size_t i = 0; i < missing.size(); ++i)
    text += (i == 0 ? "" : i + 1 == missing.size() ? " and " : ", ") + missing[i].effect.yaml();
  return text;
}

}  // namespace

std::string shortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string nameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kInsufficientData:
      return "insufficient_data";
    case Verdict::kUnknownEffect:
      return "unknown_effect";
    case Verdict::kConfusable:
      return "confusable";
    case Verdict::kMissingEffect:
      return "missing_effect";
    default:
      return "explained";
  }
}

std::string sentenceOf(const Diagnosis& d, const std::vector<WhereItFails>& left) {
  const double unit = d.angular ? kArcsecond : kMicrometre;
  const std::string name = d.angular ? " arcsec" : " um";
  const auto rms = [&](double v) { return shortNumber(v / unit) + name; };
  const double before = d.angular ? d.base.figures.heldOutRmsAngular : d.base.figures.heldOutRms;
  std::string onLeft;
  for (const WhereItFails& w : left)
    if (w.pValue < 1e-3 && onLeft.size() < 60) onLeft += (onLeft.empty() ? "" : ", ") + w.variable;
  switch (d.verdict) {
    case Verdict::kUnknownEffect: {
      std::string text = "Structure is left that no effect of the catalogue explains";
      if (!onLeft.empty()) text += "; it depends on " + onLeft;
      if (!d.formulas.empty())
        text += "; the formula " + d.formulas[0].effect.text("formula") + " along " +
                d.formulas[0].effect.text("direction") + " lowers the held-out RMS from " +
                rms(d.formulas[0].heldOutBefore) + " to " + rms(d.formulas[0].heldOutAfter);
      if (!d.missing.empty())
        text += "; found on the way: " + listOf(d.missing) + ", which is not the whole answer";
      return text + ".";
    }
    case Verdict::kConfusable:
      return "Missing: " + listOf(d.missing) +
             ", but these data cannot tell at least one of them from another effect; the listed moves would.";
    case Verdict::kMissingEffect:
      return "Missing: " + listOf(d.missing) + "; held-out RMS " + rms(before) + " -> " +
             rms(d.missing.back().heldOutAfter) +
             (d.shapeLeft ? "; what is left depends on the same variables, so the shape differs from the "
                            "catalogue's: add them and diagnose again for a formula of the rest"
                          : "") +
             ".";
    case Verdict::kExplained: {
      std::string text =
          d.shapeLeft
              ? "Nothing is missing: no other effect is significant, and what is left depends on the "
                "variables of "
                "effects in the model, whose shape differs from the catalogue's"
              : "Nothing is missing: no effect is significant and no structure is left in the residual";
      if (d.base.repeatabilityFrom == "estimated")
        return text + " (the repeatability was not stated: estimated as " + rms(d.base.repeatability) + ").";
      if (d.base.figures.chi2PerDof > 1.5)
        return text + "; its scatter is " + shortNumber(std::sqrt(d.base.figures.chi2PerDof)) +
               " times the repeatability of " + rms(d.base.repeatability) +
               ": this is stated too small, or something acts that follows nothing that was logged; repeat "
               "one "
               "contact twenty times to tell which.";
      return text + ", which is at the repeatability of " + rms(d.base.repeatability) + ".";
    }
    default:
      return "The model cannot be fitted to this session.";
  }
}

}  // namespace mm
