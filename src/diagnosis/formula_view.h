#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "diagnosis/formula_shapes.h"
#include "diagnosis/residual_space.h"
#include "diagnosis/subset_search.h"

namespace mm {

/// What formulas are fitted to: a residual, what may absorb a part of it, and the symbols, for all rows of a
/// session or for some of them.
struct FormulaView {
  std::vector<Symbol> symbols;          // values at `rows` data rows
  std::vector<std::string> directions;  // as in formula's `direction`
  Eigen::MatrixXd factors;              // rows x directions: a value of 1 in a direction, whitened
  Eigen::MatrixXd basis;                // length x rank, orthonormal: the model and the effects found
  Eigen::VectorXd left;                 // length: data rows, then priors; orthogonal to `basis`
  double rss = 0.0, dof = 1.0;
  int rows = 0;

  int length() const { return static_cast<int>(left.size()); }
  /// Columns of terms in a direction, not projected; length x coefficients.
  Eigen::MatrixXd columns(int direction, const std::vector<Term>& terms) const;
  /// Removes what `basis` absorbs.
  void project(Eigen::MatrixXd& columns) const;
  /// 1/2 dof ln(rss / dof).
  double misfit(double rss) const;
  double misfit() const { return misfit(rss); }
  /// The price of choosing where a formula acts and what it depends on; a combination of variables counts as
  /// all of them.
  template <class Symbols>
  double priceOfChoice(const Symbols& chosen) const {
    std::size_t variables = 0;
    for (int s : chosen) variables += symbols[s].variables.size();
    return priceOfVariables(variables);
  }
  double priceOfVariables(std::size_t count) const;
  /// The price of one term: its unknowns, and the choice of its shapes.
  double priceOf(const Term& term) const;
};

/// Makes views of a session; the parts that do not depend on what was found are made once.
class FormulaViews {
 public:
  explicit FormulaViews(const ResidualSpace& space);
  /// @param most data rows; all when there are no more, else evenly taken from the whole session.
  FormulaView view(const Subset& rest, int most) const;
  /// A view of some data rows, ascending: the model refitted to them alone.
  FormulaView viewOf(const Subset& rest, const std::vector<int>& taken) const;
  const std::vector<Symbol>& symbols() const { return symbols_; }
  const std::vector<Variable>& variables() const { return variables_; }

 private:
  const ResidualSpace& space_;
  std::vector<Variable> variables_;
  std::vector<Symbol> symbols_;
  Directions directions_;
  Eigen::MatrixXd factors_;
};

}  // namespace mm
