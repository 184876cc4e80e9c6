#pragma once
#include <string>
#include <vector>

#include "diagnosis/formula_fit.h"
#include "diagnosis/formula_view.h"
#include "diagnosis/judge.h"
#include "diagnosis/subset_search.h"

namespace mm {

/// A formula found for what no effect of the catalogue explains, ready to be added as effect `formula`.
struct FoundFormula {
  EffectSpec spec;
  Eigen::MatrixXd columns;  // projected on the model, whitened
  std::vector<std::string> variables;
  FittedFormula fitted;
  double choices = 0.0;    // logarithm of the number of formulas that it was chosen among
  double objective = 0.0;  // penalised negative log-likelihood

  int unknowns() const { return fitted.unknowns(); }
};

/// The shortest formulas that explain a residual, in the spirit of sparse symbolic regression: first where a
/// formula acts and what it depends on (smooth functions and waves of up to three symbols in every
/// direction), then its shape (products of shapes of those symbols, with their constants fitted). Values in
/// um (arcsec for rotary directions), variables in the units of `formula`.
class FormulaSearch {
 public:
  explicit FormulaSearch(const ResidualSpace& space);

  /// Whether some smooth function or wave of a few symbols explains more than its price: a cheap look.
  bool promising(const Subset& rest, double dof) const;
  /// @param rest what is already in the model and found: its `left` is to be explained.
  /// @return at most `count`, best first; empty when none is significant after correction for all terms
  /// tried.
  std::vector<FoundFormula> run(const Subset& rest, double dof, double significance, int count) const;
  /// Held-out RMS (whitened) with a formula added; its constants, too, are fitted without the fold.
  double heldOut(const FoundFormula& formula, const Subset& rest, const HeldOutJudge& judge) const;

 private:
  const ResidualSpace& space_;
  FormulaViews views_;
};

}  // namespace mm
