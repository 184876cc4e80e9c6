#pragma once
#include <functional>
#include <vector>

#include "diagnosis/formulas.h"
#include "diagnosis/judge.h"
#include "diagnosis/round.h"

namespace mm {

/// A formula with its held-out RMS (whitened).
struct JudgedFormula {
  FoundFormula formula;
  double before = 0.0, after = 0.0;
};

/// What the effects found do not account for.
struct UnknownEffect {
  bool beyondShapes = false;            // structure that is not the shape of an effect found
  bool shapeLeft = false;               // structure that is
  Subset kept;                          // the effects found, or those that stay beside the formulas
  std::vector<JudgedFormula> formulas;  // best first; each lowers the held-out RMS
  bool formulaFirst = false;            // the best formula explains more than any of the effects kept
};

/// Whether structure is left, and whether a short formula explains more, for its length, than the effects of
/// the catalogue do, alone or beside some of them. @param step called before each search.
UnknownEffect lookBeyond(const Round& round, const HeldOutJudge& judge, const Subset& found,
                         const std::function<void()>& step);

}  // namespace mm
