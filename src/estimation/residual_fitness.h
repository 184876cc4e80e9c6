#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "estimation/genetic.h"
#include "estimation/problem.h"

namespace mm {

/// The residuals themselves as the fitness of a chromosome, for models that are not linear in their
/// parameters; with the penalty of LASER (11) on unit vectors. The coordinates of free points are no genes:
/// LASER (9) gives them, the mean over the postures of where the probe is.
class ResidualFitness final : public GeneticFitness {
 public:
  /// @param base of the unknowns that are no genes, SI. @param genes unknowns, in the order of a chromosome.
  /// @param inverseSigma a data row: sqrt(weight) / sigma, in 1/m or 1/rad; 0 leaves the row out.
  /// @param unit m or rad that a residual of one standard deviation stands for.
  /// @param metre costs are squares of this many metres.
  ResidualFitness(const Problem& problem, const Eigen::VectorXd& base, std::vector<int> genes,
                  const Eigen::VectorXd& inverseSigma, double unit, double metre,
                  std::function<bool()> cancelled);
  static bool solvedInClosedForm(const Problem& problem, int unknown);
  /// Puts the points where the chromosome sees them.
  void solve(Eigen::VectorXd& x) const;
  std::size_t dimension() const override { return genes_.size(); }
  void evaluate(const double* population, std::size_t count, double* costs) const override;

 private:
  double cost(const Eigen::VectorXd& x) const;
  Eigen::VectorXd meansOf(const Eigen::VectorXd& r) const;

  const Problem& problem_;
  const Eigen::VectorXd base_;
  std::vector<int> genes_;
  const Eigen::VectorXd& inverseSigma_;
  double unit_, metre_;
  std::function<bool()> cancelled_;
  std::vector<int> solved_;   // unknowns
  std::vector<int> placeOf_;  // a data row: index in solved_, or -1
};

}  // namespace mm
