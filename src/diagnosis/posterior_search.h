#pragma once
#include <set>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/search.h"
#include "posterior/slots.h"

namespace mm {

/// A cause with a name that explains nearly all that a curve does.
struct CurveName {
  int curve = -1, cause = -1;  // groups of the questions
  /// That the curve is there, and that it is this one where one in the catalogue does; whether the curve
  /// predicts anything beside it says nothing of it.
  double probability = 0.0;
};

/// What the posterior over sets of causes says of a session.
struct PosteriorAnswer {
  PosteriorSample sample;
  std::vector<double> rest;    // probability of groups behind those of the sample, beside what it found
  std::vector<Slot> slots;     // likeliest first; causes are groups of the questions
  std::vector<int> likeliest;  // a group: its shape of most probability, -1: none was visited
  Explanation found;           // the leaders of the named slots; the noise is that beside the parts, too
  /// What comes with a cause that is named as real parts are made, and is no cause of its own.
  std::vector<Member> parts = {};
  std::vector<CurveName> curveNames = {};

  std::set<int> doubted = {};  // groups

  /// A cause that does not clearly predict is not named; it acts where it predicts anything, too. What was
  /// its rival may be another's. @param probability that it does. @return whether the slots name what they
  /// did not: `findNamed` has to be asked again.
  bool doubt(int group, double probability);
};

/// Log prior odds that a cause acts in a session.
double logPriorOddsOf(const Questions& questions, const Group& group);
/// A session as the posterior sees it. @param groups what may act; those of the questions or a part of them.
/// @param statedFreedoms how many degrees of freedom the stated noise is worth.
PosteriorProblem problemOf(const Questions& questions, const Groups& groups, double statedFreedoms);
/// What a sample of the questions says. @param problem of them.
PosteriorAnswer answerOf(const Questions& questions, const PosteriorProblem& problem, PosteriorSample sample);
/// What the slots of an answer name, and the noise beside it. @param problem of the questions.
void findNamed(const Questions& questions, const PosteriorProblem& problem, PosteriorAnswer& answer);
/// What was found, and behind its members the parts that come with any of them: noise, sizes and predictions
/// are those beside these.
Explanation withParts(const Questions& questions, const PosteriorAnswer& answer, Explanation found);
/// The noise alone.
Explanation noiseOnly(const NoiseState& noise);
/// What acts, with the nonlinear parameters at their best at this noise. @param evidence of the questions.
std::vector<Member> membersOf(const Search& search, const Evidence& evidence, const PosteriorProblem& problem,
                              const ActingSet& acting);
/// What acts, and the noise beside it, refitted as causes of the questions. @param names of its curves.
Explanation explanationOf(const Questions& questions, const PosteriorProblem& problem,
                          const ActingSet& acting, const NoiseState& noise,
                          std::vector<CurveName>* names = nullptr);
/// Degrees of freedom that the repeatability of a fit is worth.
double statedFreedomsOf(const CalibrationResult& fitted);

/// The shape of a cause that has most of its probability, as it would be added.
EffectSpec specOf(const Questions& questions, const PosteriorAnswer& answer, int cause);
/// Odds and rivals, as the sample has them.
void takeOdds(const Questions& questions, const PosteriorAnswer& answer, Diagnosis& out);

}  // namespace mm
