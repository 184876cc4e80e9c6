#pragma once
#include <vector>

#include "diagnosis/formula_view.h"

namespace mm {

/// A guess of where a formula acts and what it depends on.
struct FormulaGuess {
  int direction = 0;
  std::vector<int> symbols;   // ascending
  std::vector<Factor> waves;  // periods that stand out
  double objective = 0.0;     // penalised negative log-likelihood of smooth terms or of the wave
};

/// Ranks all choices of a direction and of up to three symbols by what smooth functions and waves of them
/// explain.
/// @return at most `count`, best first.
std::vector<FormulaGuess> screenFormulas(const FormulaView& view, int count);

}  // namespace mm
