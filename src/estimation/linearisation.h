#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// A problem linearised at one point: residuals, and how they change with the unknowns and with each small
/// error. A value that holds for its point alone; who has one can ask it, and nothing has to be called
/// before.
class Linearisation {
 public:
  const Problem& problem() const { return *problem_; }             ///< what was linearised
  const Eigen::VectorXd& x() const { return x_; }                  ///< where: all unknowns, SI
  const Eigen::VectorXd& residuals() const { return residuals_; }  ///< of the data rows, m or rad
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }    ///< data rows x unknowns, not whitened
  const std::vector<UnknownGroup>& groups() const { return problem_->groups(); }  ///< of the columns
  /// By each small error of the machine: data rows x ErrorLayout::size().
  const Eigen::MatrixXd& slotGradients() const { return slotGradients_; }

  /// Columns (data rows x parameters) by which an effect that is not in the model would change the residuals,
  /// with the effect's parameters at `p`, SI.
  /// @param asked an observation: whether its rows are wanted, the others stay zero; null: all.
  Eigen::MatrixXd effectColumns(const Effect& effect, const std::vector<double>& p,
                                const std::vector<char>* asked = nullptr) const;

 private:
  friend Linearisation linearise(const Problem& problem, const Eigen::VectorXd& x);
  explicit Linearisation(const Problem& problem) : problem_(&problem) {}

  const Problem* problem_;
  Eigen::VectorXd x_, residuals_;
  Eigen::MatrixXd jacobian_, slotGradients_;
};

/// @param problem must outlive what is returned. @param x of all unknowns, SI.
Linearisation linearise(const Problem& problem, const Eigen::VectorXd& x);

}  // namespace mm
