#include "diagnosis/noise_words.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "diagnosis/verdict.h"
#include "diagnosis/wording.h"

namespace mm {
namespace {

/// "0.3 um (declared)"
std::string repeatabilityWords(const Diagnosis& d) {
  return errorInWords(d.base.repeatability, d.angular) + " (" +
         (d.base.repeatabilityFrom == "repeated" ? "from repeated measurements" : d.base.repeatabilityFrom) +
         ")";
}

std::string noiseWords(const Diagnosis& d) {
  return withFactor(
      expanded(d.noise / unitOf(d.angular), d.noiseStd / unitOf(d.angular), nameOfUnit(d.angular)));
}

/// What may be said of all causes: that none is left is said only where each is improbable.
std::string nothingLeft(const Diagnosis& d) {
  if (!d.possible.empty())
    return d.variations.empty() ? "No effect is established" : "No other cause is established";
  return d.variations.empty() ? "No effect and no structure is left" : "No other cause is left";
}

std::string artifactSentence(const Diagnosis& d, const ArtifactScatter& scatter) {
  const std::string what = scatter.what == "centres" ? "positions" : "radii";
  return nothingLeft(d) + (positive(d.noise) ? " in the noise of " + noiseWords(d) : std::string()) +
         ", but the balls' " + scatter.what + " scatter by " + sizeOfScatter(scatter) + " about the " + what +
         " in the artifact file: either the file is wrong, or the machine has an error that this session "
         "cannot show. Calibrate the artifact, or turn it by 90 degrees and measure it again: its own errors "
         "turn with it, those of the machine do not.";
}

std::string driftingQuantity(const DriftResult& drift) {
  return drift.direction == "approach" ? "the error along the approach" : drift.direction;
}

std::string scatterInWords(const Diagnosis& d, const DriftResult& drift) {
  return driftingQuantity(drift) + " scatters by " +
         errorInWords(drift.quickStd, isAngular(d, drift.direction)) + " RMS from one " +
         (drift.ofThePlace ? "place" : "measurement") + " to the next";
}

/// What tells the repeatability, in the words of how this session was measured: nobody touches with a
/// tracker.
std::string repeatTwentyTimes(const Diagnosis& d) {
  if (d.angular) return "Point at one target twenty times";
  const bool touched = !d.base.problem || [&] {
    const auto& all = d.base.problem->session().observations;
    return std::any_of(all.begin(), all.end(),
                       [](const Observation& o) { return o.kind == ObservationKind::kContact; });
  }();
  return touched ? "Touch one point twenty times" : "Measure one position twenty times";
}

}  // namespace

std::string sizeOfScatter(const ArtifactScatter& scatter) {
  const bool angular = scatter.angular;
  if (!(scatter.stdStd > 0.0)) return errorInWords(scatter.std, angular) + " RMS";
  return withFactor(expanded(scatter.std / unitOf(angular), scatter.stdStd / unitOf(angular),
                             nameOfUnit(angular) + " RMS"));
}

std::string errorsOfPositions(const ArtifactScatter& scatter) {
  const std::string& table = scatter.correctedBy.type;
  return "graduation errors of its scale, or errors that change within less than these distances; " +
         (table.empty() ? "there are too many for a table: measure at 64 or fewer"
                        : "correct them by a " + table + ", or measure at positions closer together");
}

std::string outliersInWords(const Diagnosis& d) {
  const OutliersSetAside& o = d.outliers;
  return std::to_string(o.readings) + (o.readings == 1 ? " reading was" : " readings were") +
         " set aside as outliers, up to " + errorInWords(o.largest, d.angular) +
         (o.inCommon.empty() ? "; with --keep-outliers they are asked, too"
                             : ", all " + o.inCommon +
                                   ": something moved or jumped there; diagnose again with --keep-outliers");
}

std::string scatterSentence(const Diagnosis& d) {
  const std::string nothing = nothingLeft(d);
  if (!d.outliers.inCommon.empty())
    return nothing + (positive(d.noise) ? " in the noise of " + noiseWords(d) : std::string()) + ", but " +
           outliersInWords(d) + ".";
  if (const ArtifactScatter* of = beyondTheFile(d)) return artifactSentence(d, *of);
  if (const ArtifactScatter* of = ofAnAxis(d))
    return nothing + (positive(d.noise) ? " in the noise of " + noiseWords(d) : std::string()) + ", but " +
           of->inWords + ".";
  if (const DriftResult* of = beyondTheRepeatability(d))
    return nothing + ", but " + scatterInWords(d, *of) + ", " +
           shortNumber(of->quickStd / d.base.repeatability) + " times the repeatability of " +
           repeatabilityWords(d) +
           (of->ofThePlace
                ? ": the runs agree, so it depends on the position or the direction of travel in a way that "
                  "no effect of the catalogue does."
                : ": an influence acts that is unrelated to anything recorded, or that changes over less "
                  "than "
                  "the distance between these positions.") +
           " Measure at positions closer together.";
  const std::string twenty = repeatTwentyTimes(d);
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
              ? ": the runs agree, so it depends on the position. Measure at positions closer together and "
                "unequally spaced."
              : ": either that is stated too small, or an influence acts that is unrelated to anything "
                "recorded. " +
                    twenty + " to decide between the two.");
}

/// " Backlash of x is not the same everywhere: …"
std::string variationSentence(const Diagnosis& d) {
  std::string text;
  for (const Variation& v : d.variations) {
    text += v.along.empty() ? " But " + inWords(v.effect) + " does not have exactly the shape of its model: "
                            : " But " + inWords(v.effect) +
                                  " is not uniform: " + (v.along == kTime ? "in the course of " : "along ") +
                                  v.along + " it deviates from a single value by ";
    text += withFactor(expanded(v.rms / unitOf(d.angular), v.std / unitOf(d.angular),
                                nameOfUnit(d.angular) + " RMS")) +
            (v.along.empty() ? " of it remain" : "");
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
    return std::string(d.possible.empty() ? "No other cause is missing" : "No other cause is established") +
           ", with noise of " + noiseWords(d) + "." + variationSentence(d);
  // Who reads that nothing is missing does not read on, and the drift may be as large as the noise.
  const bool drifts = !d.drift.empty();
  const std::string beside = d.possible.empty() ? " but " : " beside ";
  std::string text = (!drifts && d.possible.empty() ? "Nothing is missing: no effect and no structure is left"
                                                    : nothingLeft(d)) +
                     (drifts ? beside + "drift" : "");
  if (positive(d.noise)) text += (drifts ? " and noise of " : beside + "noise of ") + noiseWords(d);
  constexpr double kFar = 5.0;  // times: what was declared is another noise than that of these measurements
  if (positive(d.base.repeatability))
    text += (positive(d.noise) && kFar * d.noise < d.base.repeatability ? ", far below the repeatability of "
                                                                        : ", at the repeatability of ") +
            repeatabilityWords(d);
  return text + "." + (d.outliers.readings > 0 ? " " + outliersInWords(d) + "." : "");
}

std::string possibleSentence(const Diagnosis& d) {
  std::vector<std::string> told;  // those that no variation tells
  std::string shownBy;            // of the first
  for (const PossibleCause& p : d.possible) {
    const auto instead = [&](const Alternative& a) { return a.effect == p.effect; };
    if (std::none_of(d.variations.begin(), d.variations.end(), [&](const Variation& v) {
          return std::any_of(v.instead.begin(), v.instead.end(), instead);
        })) {
      if (told.empty()) shownBy = p.shownBy;
      told.push_back(inWords(p.effect) + " (odds " + oddsInWords(p.odds) + ")");
    }
  }
  if (told.empty()) return {};
  return " " + capitalized(enumerated(told)) + " cannot be excluded." +
         (shownBy.empty() ? "" : " To decide, measure: " + shownBy);
}

std::string driftSentence(const Diagnosis& d) {
  std::string text;
  const DriftResult* told = d.verdict == Verdict::kScatter ? beyondTheRepeatability(d) : nullptr;
  for (const DriftResult& drift : d.drift)
    if (&drift != told) text += (text.empty() ? " Drift: " : "; ") + driftInWords(d, drift);
  return text.empty() ? text : text + ".";
}

std::string remainderSentence(const Diagnosis& d) {
  constexpr double kMost = 3.0;  // times the noise: nine tenths of the mean square are something else
  if (!positive(d.heldOut) || !positive(d.noise) || d.heldOut < kMost * d.noise) return {};
  std::vector<std::string> known;
  for (const DriftResult& drift : d.drift) known.push_back(driftInWords(d, drift));
  for (const ArtifactScatter& of : d.artifactScatter)
    if (of.what == "form")
      known.push_back("the form of the balls scatters by " + sizeOfScatter(of));
    else if (of.what != kDatum)
      known.push_back((jointOf(of).empty() ? "the balls' " : "") + of.what + " scatter by " +
                      sizeOfScatter(of));
  return " What remains is " + shortNumber(d.heldOut / d.noise) + " times the noise: " + joined(known, "; ") +
         (known.empty() ? "its cause is not known; add what was found, then diagnose again." : ".");
}

std::string driftInWords(const Diagnosis& d, const DriftResult& drift) {
  if (drift.quick) return scatterInWords(d, drift);
  std::string text = driftingQuantity(drift) + " drifts by " +
                     errorInWords(drift.std, isAngular(d, drift.direction)) + " RMS";
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
    return "measure at positions closer together, and one position twenty times: the error depends on the "
           "position, or on something that is not recorded";
  // a quarter of the time constant: between two references the drift then changes by less than its own size
  const std::string every =
      positive(drift.timeConstant) ? "every " + durationInWords(drift.timeConstant / 4.0) : "at intervals";
  if (drift.perhaps.empty())
    return "measure the same reference again " + every +
           ", or record the temperatures of the parts that carry the probe";
  return "measure the same places at other temperatures that do not simply rise or fall with time; until "
         "then, the same reference again " +
         every;
}

}  // namespace mm
