#pragma once
#include <vector>

#include "diagnosis/formula_screen.h"
#include "diagnosis/formula_view.h"

namespace mm {

/// A formula: terms in one direction.
struct FittedFormula {
  int direction = 0;
  std::vector<Term> terms;
  double rss = 0.0;
  double price = 0.0;      // of its unknowns, shapes and symbols, as a logarithm
  double objective = 0.0;  // penalised negative log-likelihood

  int unknowns() const;
};

/// The best formulas over the symbols of a guess: terms are chosen one after the other from a dictionary of
/// shapes and their products, the constants in all of them fitted together, then shortened.
std::vector<FittedFormula> fitFormulas(const FormulaView& view, const FormulaGuess& guess, std::size_t from,
                                       std::size_t to);

/// Fits the constants of a formula again and takes its figures in another view of the same session.
FittedFormula refit(const FormulaView& view, FittedFormula formula);

}  // namespace mm
