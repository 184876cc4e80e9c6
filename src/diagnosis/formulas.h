#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/residual_space.h"
#include "diagnosis/subset_search.h"

namespace mm {

/// A formula found for what no effect of the catalogue explains, ready to be added as effect `formula`.
struct FoundFormula {
  EffectSpec spec;
  Eigen::MatrixXd columns;  // projected on the model, whitened
  std::vector<std::string> variables;
  double objective = 0.0;  // penalised negative log-likelihood
};

/// A wave found along a joint: its period in m (rad), from the catalogue's search.
struct FoundPeriod {
  std::string joint;
  double period = 0.0;
};

/// Sparse search over products, powers, harmonics, steps and decays of the session's variables and their
/// sums, in every direction: the shortest formulas first. Values in um (arcsec for rotary directions),
/// variables in the units of `formula`.
class FormulaSearch {
 public:
  explicit FormulaSearch(const ResidualSpace& space, const std::vector<FoundPeriod>& periods = {});
  ~FormulaSearch();

  /// @param rest what is already in the model and found: its `left` is to be explained.
  /// @return at most `count`, best first; empty when none is significant after correction for all terms
  /// tried.
  std::vector<FoundFormula> run(const Subset& rest, double dof, double significance, int count) const;

 private:
  struct Dictionary;
  const ResidualSpace& space_;
  std::unique_ptr<Dictionary> dictionary_;
};

}  // namespace mm
