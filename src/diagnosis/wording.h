#pragma once
#include <string>
#include <vector>

#include "base/quantity_words.h"
#include "diagnosis/diagnose.h"
#include "effects/effect_words.h"

namespace mm {

// A diagnosis as people say it: the sentence of its verdict, and the words of which it is made.

/// The verdict in one to four sentences: what is named, with its size and odds, and what else it may be.
std::string sentenceOf(const Diagnosis& diagnosis);

/// "0.76 ± 0.13 arcsec RMS (k = 2)": a standard deviation that belongs to places.
std::string sizeOfScatter(const ArtifactScatter& scatter);

/// What differs from position to position, and what to do.
std::string errorsOfPositions(const ArtifactScatter& scatter);

/// Its first letter a capital.
std::string capitalized(std::string text);
/// It has rivals that further data would tell from it: one of them acts, and none of them is named.
bool hasOpenRivals(const CandidateResult& missing);
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
/// How often these moves are to be measured until they separate the rival; 0: no practicable number does.
int repeatsOfMoves(double deviations, std::size_t moves);
/// Why a rival cannot be separated, or not excluded; empty where measuring more would separate it.
std::string whyNotApart(const Confusable& rival);

/// Whether errors along a direction are angles.
bool isAngular(const Diagnosis& diagnosis, const std::string& direction);

}  // namespace mm
