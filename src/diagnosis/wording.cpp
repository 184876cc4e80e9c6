#include "diagnosis/wording.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "diagnosis/verdict.h"

namespace mm {
namespace {

double unitOf(bool angular) { return angular ? kArcsecond : kMicrometre; }
std::string nameOfUnit(bool angular) { return angular ? "arcsec" : "um"; }
std::string length(double value, bool angular) {
  return shortNumber(value / unitOf(angular)) + " " + nameOfUnit(angular);
}
bool positive(double value) { return std::isfinite(value) && value > 0.0; }

/// "2.06 ± 0.06 um (k = 2)"
std::string withFactor(const std::string& text) {
  return text.find("±") == std::string::npos ? text : text + " (k = 2)";
}

std::string alongWords(const Diagnosis& d, const std::string& direction) {
  return direction == "approach"   ? "along the approach"
         : isAngular(d, direction) ? "of " + direction
                                   : "along " + direction;
}

/// "held-out RMS 0.93 -> 0.32 um": without what was found, and with all of it, both by one definition.
std::string heldOutWords(const Diagnosis& d) {
  double before = d.heldOutBefore, after = d.heldOut;
  if (!positive(before) && !d.missing.empty()) before = d.missing.front().heldOutBefore;
  if (!positive(before) && !d.profiles.empty()) before = d.profiles.front().heldOutBefore;
  if (!positive(after) && !d.missing.empty()) after = d.missing.back().heldOutAfter;
  if (!positive(after) && !d.profiles.empty()) after = d.profiles.back().heldOutAfter;
  if (!positive(before) || !positive(after)) return {};
  return "held-out RMS " + shortNumber(before / unitOf(d.angular)) + " -> " + length(after, d.angular);
}

/// What was named predicts what it was not fitted to no better than the model without it did.
std::string noBetterWords(const Diagnosis& d) {
  if (!positive(d.heldOutBefore) || !positive(d.heldOut) || d.heldOut < d.heldOutBefore) return {};
  return " But measurements that were held out are predicted no better: what was named may hold for this "
         "session alone.";
}

/// Rivals that further data of the same kinds would tell from the named one.
std::vector<const Confusable*> openRivals(const CandidateResult& c) {
  std::vector<const Confusable*> open;
  for (const Confusable& rival : c.confusableWith)
    if (!rival.same && rival.notRecorded.empty()) open.push_back(&rival);
  return open;
}

bool isOpen(const CandidateResult& c) { return !openRivals(c).empty(); }

/// "backlash of x, 2.06 ± 0.06 um (k = 2), odds about 1000 to 1"
std::string surely(const CandidateResult& c, bool angular) {
  const std::string size = withFactor(sizeInWords(c, angular));
  return foundInWords(c) + (size.empty() ? "" : ", " + size) + ", odds " + oddsInWords(c.odds);
}

/// "either backlash of x (2.06 ± 0.06 um, k = 2; odds 3 to 2) or speed lag (1 to 3)"
std::string eitherOr(const CandidateResult& c, bool angular) {
  std::string size = sizeInWords(c, angular);
  if (size.find("±") != std::string::npos) size += ", k = 2";
  std::string text = "either " + foundInWords(c) + " (" + size + (size.empty() ? "" : "; ") + "odds " +
                     oddsInWords(c.odds) + ")";
  for (const Confusable* rival : openRivals(c))
    text += " or " + inWords(rival->effect) + " (" + oddsInWords(rival->odds) + ")";
  return text;
}

std::string capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string missingSentence(const Diagnosis& d) {
  std::string sure, open;
  for (const CandidateResult& c : d.missing) {
    std::string& text = isOpen(c) ? open : sure;
    text += (text.empty() ? "" : "; ") + (isOpen(c) ? eitherOr(c, d.angular) : surely(c, d.angular));
  }
  const std::string heldOut = heldOutWords(d);
  std::string text = sure.empty() ? "" : "Missing: " + sure;
  if (open.empty()) return text + (heldOut.empty() ? "" : "; " + heldOut) + "." + noBetterWords(d);
  if (!sure.empty()) text += ". Beside it ";
  text += (sure.empty() ? capital(open) : open) + ": these data do not separate them";
  if (!d.nextMeasurement.empty()) text += "; the listed moves would";
  return text + (heldOut.empty() ? "" : ". " + capital(heldOut)) + "." + noBetterWords(d);
}

/// Where a named effect is the same as another, or another that was not recorded may be in its place.
std::string rivalRemarks(const CandidateResult& c) {
  std::string text;
  std::vector<EffectSpec> frames = {c.effect};
  std::vector<std::string> inputs;
  for (const Confusable& rival : c.confusableWith) {
    if (rival.same) frames.push_back(rival.effect);
    const bool told = std::find(inputs.begin(), inputs.end(), rival.notRecorded) != inputs.end();
    if (!rival.same && !rival.notRecorded.empty() && !told) inputs.push_back(rival.notRecorded);
  }
  if (frames.size() > 1)
    text += " " + capital(listInWords(frames)) + " are the same error expressed in " +
            (frames.size() == 2 ? "two" : "several") +
            " frames: no measurement on this machine separates them.";
  for (const std::string& input : inputs) {
    std::vector<EffectSpec> hidden;
    for (const Confusable& rival : c.confusableWith)
      if (!rival.same && rival.notRecorded == input) hidden.push_back(rival.effect);
    text += " " + capital(listInWords(hidden)) + " cannot be excluded: " + inputInWords(input) +
            " was not recorded.";
  }
  return text;
}

/// Inputs that were made up and on which a named cause, or a rival of one, rests.
std::string assumptions(const Diagnosis& d) {
  std::string text;
  for (const MissingInput& input : d.missingInputs) {
    if (input.assumed.empty()) continue;
    const auto concerned = [&](const EffectSpec& effect) {
      return std::find(input.effects.begin(), input.effects.end(), effect) != input.effects.end();
    };
    const bool matters = std::any_of(d.missing.begin(), d.missing.end(), [&](const CandidateResult& c) {
      return concerned(c.effect) || std::any_of(c.confusableWith.begin(), c.confusableWith.end(),
                                                [&](const Confusable& r) { return concerned(r.effect); });
    });
    if (matters) text += " " + capital(inputInWords(input.input)) + " was assumed " + input.assumed + ".";
  }
  return text;
}

std::string remarks(const Diagnosis& d) {
  std::string text;
  for (const CandidateResult& c : d.missing)
    text += rivalRemarks(c) + (c.looksTheSame.empty() ? "" : " " + c.looksTheSame);
  return text + assumptions(d);
}

/// "up to 1.41 ± 0.20 um (k = 2) at x = -16 mm"
std::string peakOf(const Diagnosis& d, const ProfileResult& p) {
  const std::size_t n = p.variables.size();
  const std::vector<double>* peak = nullptr;
  for (const std::vector<double>& point : p.curve)
    if (point.size() == n + 2 && std::isfinite(point[n]) &&
        (peak == nullptr || std::abs(point[n]) > std::abs((*peak)[n])))
      peak = &point;
  if (peak == nullptr) return {};
  std::string text = "up to " +
                     withFactor(expanded((*peak)[n], (*peak)[n + 1], nameOfUnit(isAngular(d, p.direction)))) +
                     " at ";
  for (std::size_t i = 0; i < n; ++i) {
    const std::string unit = i < p.units.size() ? p.units[i] : "";
    text += (i == 0 ? "" : ", ") + (p.variables[i] == "t" ? "time" : p.variables[i]) + " = " +
            shortNumber((*peak)[i]) + (unit.empty() || unit == "1" ? "" : " " + unit);
  }
  return text;
}

/// "Missing: backlash of x, … ; backlash of y, …."
std::string surelyAll(const Diagnosis& d) {
  std::string text;
  for (const CandidateResult& c : d.missing) text += (text.empty() ? "" : "; ") + surely(c, d.angular);
  return text + ".";
}

std::string unknownSentence(const Diagnosis& d) {
  std::string text;
  // what has a name comes first where it does more
  const bool namedFirst =
      !d.missing.empty() && (d.profiles.empty() || d.missing.front().gain > d.profiles.front().gain);
  if (namedFirst) text = "Missing: " + surelyAll(d) + " Beside it ";
  for (std::size_t i = 0; i < d.profiles.size(); ++i) {
    const ProfileResult& p = d.profiles[i];
    if (i == 0)
      text += namedFirst ? "an error " : "An error ";
    else
      text += " And one ";
    text += alongWords(d, p.direction) + " that depends on " + variablesInWords(p);
    if (i == 0) text += ", and that no effect of the catalogue explains";
    const std::string peak = peakOf(d, p);
    text += ": " + (peak.empty() ? "" : peak + ", ") + "odds " + oddsInWords(p.odds);
    if (i + 1 == d.profiles.size())
      if (const std::string heldOut = heldOutWords(d); !heldOut.empty()) text += "; " + heldOut;
    text += ".";
  }
  if (d.profiles.empty()) {
    constexpr double kSignificant = 1e-3;  // chance, corrected for the number of variables asked
    std::vector<std::string> on;
    for (const WhereItFails& w : d.where)
      if (w.pValue < kSignificant && on.size() < 3) on.push_back(w.variable);
    text += std::string(namedFirst ? "structure" : "Structure") +
            " is left that no effect of the catalogue explains";
    for (std::size_t i = 0; i < on.size(); ++i) text += (i == 0 ? "; it depends on " : ", ") + on[i];
    text += ".";
  }
  for (const FormulaResult& f : d.formulas)
    text += " The formula " + inWords(f.effect) + " describes it as well.";
  if (!d.missing.empty() && !namedFirst) text += " Found on the way: " + surelyAll(d);
  return text + (d.profiles.empty()       ? " Look for its cause."
                 : d.profiles.size() == 1 ? " Add it as a profile, or look for its cause."
                                          : " Add them as profiles, or look for their causes.");
}

/// "0.3 um (declared)"
std::string repeatabilityWords(const Diagnosis& d) {
  return length(d.base.repeatability, d.angular) + " (" +
         (d.base.repeatabilityFrom == "repeated" ? "from repeated measurements" : d.base.repeatabilityFrom) +
         ")";
}

std::string noiseWords(const Diagnosis& d) {
  return withFactor(
      expanded(d.noise / unitOf(d.angular), d.noiseStd / unitOf(d.angular), nameOfUnit(d.angular)));
}

std::string artifactSentence(const Diagnosis& d, const ArtifactScatter& scatter) {
  const std::string what = scatter.what == "centres" ? "positions" : "radii";
  return "No effect and no structure is left" +
         (positive(d.noise) ? " in the noise of " + noiseWords(d) : std::string()) + ", but the balls' " +
         scatter.what + " scatter by " + length(scatter.std, d.angular) + " about the " + what +
         " in the artifact file: that is wrong, or the machine errs as this session cannot show. Calibrate "
         "the "
         "artifact, or turn it by 90 degrees and measure it again: its own errors turn with it, those of the "
         "machine do not.";
}

std::string driftingQuantity(const DriftResult& drift) {
  return drift.direction == "approach" ? "the error along the approach" : drift.direction;
}

std::string scatterInWords(const Diagnosis& d, const DriftResult& drift) {
  return driftingQuantity(drift) + " scatters by " + length(drift.quickStd, isAngular(d, drift.direction)) +
         " RMS from one " + (drift.ofThePlace ? "place" : "measurement") + " to the next";
}

std::string scatterSentence(const Diagnosis& d) {
  const std::string nothing =
      d.variations.empty() ? "No effect and no structure is left" : "No other cause is left";
  if (const ArtifactScatter* of = beyondTheFile(d)) return artifactSentence(d, *of);
  if (const DriftResult* of = beyondTheRepeatability(d))
    return nothing + ", but " + scatterInWords(d, *of) + ", " +
           shortNumber(of->quickStd / d.base.repeatability) + " times the repeatability of " +
           repeatabilityWords(d) +
           (of->ofThePlace
                ? ": the runs agree, so it follows the place or the direction of travel, as no effect of the "
                  "catalogue does."
                : ": an influence acts that follows nothing recorded, or one that changes within less than "
                  "the distance of these positions.") +
           " Measure at positions closer together.";
  const std::string twenty = d.angular ? "Point at one target twenty times" : "Touch one point twenty times";
  const std::string scatter = positive(d.noise) ? "the scatter of " + noiseWords(d) : "the scatter";
  if (d.base.repeatabilityFrom.empty() || d.base.repeatabilityFrom == "estimated" ||
      !positive(d.base.repeatability))
    return nothing + " in " + scatter + ", but the repeatability is not known. " + twenty +
           (d.angular ? " in the same session, then diagnose again."
                      : ", then diagnose again with their standard deviation as --repeatability-um.");
  const double times = positive(d.noise) ? d.noise / d.base.repeatability
                                         : std::sqrt(std::max(0.0, d.base.figures.chi2PerDof));
  return nothing + ", but " + scatter + " is " + shortNumber(times) + " times the repeatability of " +
         repeatabilityWords(d) +
         (d.base.repeated.from == "runs" && d.base.repeatabilityFrom == "repeated"
              ? ": the runs agree, so it follows the place, from one position to the next. Measure at "
                "positions closer together, and at unequal distances."
              : ": either that is stated too small, or an influence acts that follows nothing recorded. " +
                    twenty + " to find out which.");
}

/// " Backlash of x is not the same everywhere: …"
std::string variationSentence(const Diagnosis& d) {
  std::string text;
  for (const Variation& v : d.variations) {
    text += v.along.empty() ? " But " + inWords(v.effect) + " does not have the shape of the model alone: "
                            : " But " + inWords(v.effect) + " is not the same everywhere: along " + v.along +
                                  " it differs from its one size by ";
    text += withFactor(expanded(v.rms / unitOf(d.angular), v.std / unitOf(d.angular),
                                nameOfUnit(d.angular) + " RMS")) +
            (v.along.empty() ? " are left of it" : "");
    std::string which = ", which ";  // the likelier first
    const auto formula = [&] {
      if (v.formula.type.empty()) return;
      text += which + v.formula.yaml() + " follows";
      which = ", or ";
    };
    const bool causeFirst = !v.instead.empty() && v.instead.front().probability > 0.5;
    if (!causeFirst) formula();
    for (const Alternative& a : v.instead) {
      text += which + inWords(a.effect) + " explains, odds " + oddsInWords(a.probability);
      which = ", or ";
    }
    if (causeFirst) formula();
    text += ".";
  }
  return text;
}

std::string explainedSentence(const Diagnosis& d) {
  if (!d.variations.empty())
    return "No other cause is missing, with noise of " + noiseWords(d) + "." + variationSentence(d);
  // Who reads that nothing is missing does not read on, and the drift may be as large as the noise.
  const bool drifts = !d.drift.empty();
  std::string text = drifts ? "No effect and no structure is left but drift"
                            : "Nothing is missing: no effect and no structure is left";
  if (positive(d.noise)) text += (drifts ? " and noise of " : " but noise of ") + noiseWords(d);
  if (positive(d.base.repeatability)) text += ", at the repeatability of " + repeatabilityWords(d);
  return text + ".";
}

std::string driftSentence(const Diagnosis& d) {
  std::string text;
  const DriftResult* told = d.verdict == Verdict::kScatter ? beyondTheRepeatability(d) : nullptr;
  for (const DriftResult& drift : d.drift)
    if (&drift != told) text += (text.empty() ? " Drift: " : "; ") + driftInWords(d, drift);
  return text.empty() ? text : text + ".";
}

}  // namespace

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
    case Verdict::kScatter:
      return "scatter";
    default:
      return "explained";
  }
}

std::string sentenceOf(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::kUnknownEffect:
      return unknownSentence(d) + remarks(d);
    case Verdict::kConfusable:
    case Verdict::kMissingEffect:
      return missingSentence(d) + remarks(d);
    case Verdict::kScatter:
      return scatterSentence(d) + variationSentence(d) + driftSentence(d);
    case Verdict::kExplained:
      return explainedSentence(d) + driftSentence(d);
    default:
      return "The model cannot be fitted to this session: measure more, or take effects out of the model.";
  }
}

std::string whyNotApart(const Confusable& rival) {
  if (rival.same)
    return "the same error expressed in another frame: no measurement on this machine separates them";
  if (rival.notRecorded.empty()) return {};
  return "cannot be excluded: " + inputInWords(rival.notRecorded) + " was not recorded";
}

std::string driftInWords(const Diagnosis& d, const DriftResult& drift) {
  if (drift.quick) return scatterInWords(d, drift);
  std::string text =
      driftingQuantity(drift) + " drifts by " + length(drift.std, isAngular(d, drift.direction)) + " RMS";
  if (positive(drift.timeConstant)) text += " with a time constant of " + durationInWords(drift.timeConstant);
  if (!drift.perhaps.empty()) {
    const DriftResult::Perhaps& first = drift.perhaps.front();
    return text + "; perhaps " + inWords(first.effect) + ", odds " + oddsInWords(first.odds);
  }
  const bool temperatures = d.base.problem && !d.base.problem->session().temperatures.empty();
  return text + (temperatures ? " and follows no recorded temperature" : " and follows nothing recorded");
}

std::string driftAdvice(const DriftResult& drift) {
  if (drift.quick)
    return "measure at positions closer together, and one position twenty times: it follows the position, or "
           "nothing that is recorded";
  // a quarter of the time constant: between two references the drift then changes by less than its own size
  const std::string every =
      positive(drift.timeConstant) ? "every " + durationInWords(drift.timeConstant / 4.0) : "at intervals";
  if (drift.perhaps.empty())
    return "measure the same reference again " + every +
           ", or record the temperatures of what carries the probe";
  return "measure the same places at other temperatures, out of step with time; until then the same "
         "reference again " +
         every;
}

std::string listInWords(const std::vector<EffectSpec>& effects, std::size_t shown) {
  const std::size_t count = effects.size() > shown + 1 ? shown : effects.size();
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += (i == 0 ? "" : i + 1 == effects.size() ? " and " : ", ") + inWords(effects[i]);
  if (count < effects.size()) text += " and " + std::to_string(effects.size() - count) + " more";
  return text;
}

}  // namespace mm
