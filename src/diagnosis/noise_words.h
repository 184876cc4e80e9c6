#pragma once
#include <string>

#include "diagnosis/diagnose.h"

namespace mm {

// What is told where no cause is missing, or beside one: of the noise, of drift, of what is left of a cause.

/// Sentence of Verdict::kScatter: what scatters, how much, and how to find out what it is.
std::string scatterSentence(const Diagnosis& diagnosis);
/// Sentence of Verdict::kExplained.
std::string explainedSentence(const Diagnosis& diagnosis);
/// " But backlash of x is not the same everywhere: …", and what would explain that; else empty.
std::string variationSentence(const Diagnosis& diagnosis);
/// " Backlash of x (odds 3 to 1) cannot be excluded. …", of causes that are not named; else empty.
std::string possibleSentence(const Diagnosis& diagnosis);
/// " What remains is 7.6 times the noise: x drifts by …", where causes are named and most of the error is
/// none of them; else empty.
std::string remainderSentence(const Diagnosis& diagnosis);
/// " Drift: …", of all that is not told by another sentence; else empty.
std::string driftSentence(const Diagnosis& diagnosis);

/// "7 readings were set aside as outliers, up to 19 um, all of b5: …"
std::string outliersInWords(const Diagnosis& diagnosis);
/// What drifts, how far and how slowly: "x drifts by 0.4 um RMS with a time constant of 20 min and follows
/// no recorded temperature".
std::string driftInWords(const Diagnosis& diagnosis, const DriftResult& drift);
/// What to do about it: how often to measure a reference, what to record.
std::string driftAdvice(const DriftResult& drift);

}  // namespace mm
