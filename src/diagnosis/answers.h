#pragma once
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/held_out.h"
#include "diagnosis/search.h"

namespace mm {

// From an explanation to what a diagnosis answers: effects that can be added, their rivals, curves, words.

/// An effect that a member of an explanation stands for.
struct Answer {
  EffectPtr effect;
  Eigen::VectorXd start;  // of its parameters, SI, from the linearised fit
  int member = 0;         // of the explanation
};
/// In the order of the members; a member whose shape is mixed of a family gives one for each shape that
/// counts.
std::vector<Answer> answersOf(const Search& search, const Explanation& found);

/// Heavy tails of the noise: weights by Student's t, where its likelihood is clearly the greater.
struct Tails {
  double dof = 0.0;          // 0: normal
  Eigen::VectorXd variance;  // a data row: 1 / weight
};
/// Degrees of freedom of Student's t that the residuals bear out, and the weights that follow.
Tails tailsOf(const Search& search, const Explanation& found);
/// If the resolution is coarser than the noise, most readings are identical and the noise looks like zero.
/// Each gets a value that it may have had (uniform over a quarter of the instrument's step, the same for
/// every look). Where less than half agree it does nothing.
void spreadOverResolution(Questions& q);

/// m or rad of a residual of one unit of the stated noise.
double unitOf(const ResidualSpace& space);
/// Root mean square of what columns at these values explain, beside what the model's unknowns absorb, in
/// units of the stated noise.
double projectedRms(const ResidualSpace& space, const RowMatrix& columns, const Eigen::VectorXd& values);

/// Members in the order of what they bring, most first.
void sortByGain(const Search& search, Explanation& found);
void fillAnswers(const Search& search, const Explanation& found, const HeldOut& held, double unit,
                 Diagnosis& out);
/// Values and uncertainties by the fit of everything. @param first of the effects' parameters in its x.
/// @param undetermined for each effect: its size stays as it was found, without an uncertainty.
void takeParameters(const CalibrationResult& full, int first, const std::vector<EffectPtr>& effects,
                    const std::vector<char>& undetermined, Diagnosis& out);
/// Of which members that fit has made what the session cannot tell from a smooth profile
/// (Effect::mayBeClaimed): a wave that became longer than the travel, or has its nodes at the places of the
/// session, or is a small difference of large parts.
/// @param first parameter of the answers.
std::vector<char> whatRanOff(const ResidualSpace& space, const std::vector<Answer>& answers,
                             const CalibrationResult& full, int first, std::size_t members);
/// Sizes by the fit that knows the form of the balls and how large what comes with a cause usually is, where
/// there is either: least squares do not. @param named how many members are causes; those behind them come
/// with one (withParts).
void takeRegularised(const Search& search, const Explanation& found, std::size_t named, Diagnosis& out);
/// Every cause that was asked: its gain with nothing else but the noise. Its odds are the sample's
/// (takeOdds).
void listCandidates(const Search& search, const Explanation& found, const HeldOut& held, double unit,
                    Diagnosis& out);
void listCannotShow(const Questions& questions, const Explanation& found, Diagnosis& out);
void fillScatter(const Search& search, const Explanation& found, double unit, Diagnosis& out);
/// Inputs that the session did not record: what was assumed in their place, and what cannot be excluded
/// without them.
void fillMissingInputs(const Questions& questions, Diagnosis& out);
/// Moves that separate confusable effects, and which of them no move separates.
void separate(const Search& search, const Explanation& found, Diagnosis& out);
/// A formula of at most three constants, where one is equivalent to a profile.
void describeProfiles(const Search& search, const Explanation& found, const HeldOut& held, double unit,
                      Diagnosis& out);

/// @return a member: not 0 where it is a free curve for what a cause with a name leaves.
std::vector<char> curvesForTheRest(const Search& search, const Explanation& found);

}  // namespace mm
