#pragma once
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "effects/effect_words.h"

namespace mm {

// A diagnosis as people say it: the sentence of its verdict, and the words and figures of which it is made.
// Every uncertainty after ± is expanded, with the coverage factor k = 2.

/// The verdict in one to four sentences: what is named, with its size and odds, and what else it may be.
std::string sentenceOf(const Diagnosis& diagnosis);

/// Several effects, as a list: "a, b and c"; of more than `shown`, the first and how many more.
std::string listInWords(const std::vector<EffectSpec>& effects, std::size_t shown = 4);

/// A probability as odds: "even", "3 to 2", "about 30 to 1", "more than 1000 to 1"; below one half the other
/// way round.
std::string oddsInWords(double probability);
/// A time: "40 s", "20 min", "3.5 h", "2.1 days".
std::string durationInWords(double seconds);
/// Value and expanded uncertainty (twice `std`), this with one digit, or two where it begins with 1 or 2:
/// "2.06 ± 0.06 um".
std::string expanded(double value, double std, const std::string& unit);
/// "2.06 ± 0.06 um (k = 2)": the coverage factor behind what has an uncertainty.
std::string withFactor(const std::string& text);
/// An error in um, or in arcsec: "0.3 um". @param value m or rad.
std::string errorInWords(double value, bool angular);
double unitOf(bool angular);  ///< m or rad of one of these
std::string nameOfUnit(bool angular);
bool positive(double value);  ///< and finite: a figure that is known
/// A number with three significant digits.
std::string shortNumber(double value);

/// Its name with what the fit found where its spec says "unknown": "periodic error of x, period 5.002 ± 0.018
/// mm".
std::string foundInWords(const CandidateResult& candidate);
/// Whose a cause is: "machine", "artifact plate", "stylus A", or "session b.bag", from which on it acts.
std::string ownerOf(const EffectSpec& effect, const Diagnosis& diagnosis);
/// How large a missing effect is: its constant or its amplitude ± expanded uncertainty, else the RMS of what
/// it does.
std::string sizeInWords(const CandidateResult& candidate, bool angular);
/// A variable as formulas call it, in words: "x", "time", "the speed of x", "the temperature bed".
std::string variableInWords(const std::string& name, const std::string& unit);
std::string variablesInWords(const ProfileResult& profile);
/// "the direction of travel of x"
std::string inputInWords(const std::string& input);
/// By how many standard deviations the proposed moves separate a rival.
std::string movesInWords(double deviations, std::size_t moves);
/// Why a rival cannot be separated, or not excluded; empty where measuring more would separate it.
std::string whyNotApart(const Confusable& rival);

/// Whether errors along a direction are angles.
bool isAngular(const Diagnosis& diagnosis, const std::string& direction);

}  // namespace mm
