#pragma once
#include <Eigen/Core>

#include "thermal/dfnn_rules.h"

namespace mm {

/// Consequents of a fuzzy network with a ridge: a line common to all rules, and the departure of each rule
/// from it. Penalties are relative to the number of samples; the common offset is not penalised.
class RidgeConsequents {
 public:
  /// Columns 1, x and, where there are several rules, the columns of DfnnRules::design().
  static Eigen::MatrixXd design(const Eigen::MatrixXd& x, const DfnnRules& rules);

  /// @param z design() of the samples, y samples x outputs, inputs: how many.
  RidgeConsequents(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, Eigen::Index inputs);
  /// Coefficients of the design's columns, columns x outputs.
  Eigen::MatrixXd solve(double ridge, double departureRidge) const;
  /// The penalty of each column, as the square root that multiplies its coefficient.
  Eigen::VectorXd penaltyRoots(double ridge, double departureRidge) const;

 private:
  Eigen::MatrixXd gram_, right_;
  double samples_;
  Eigen::Index inputs_;
};

/// Moves centres and widths of the rules to the nearest minimum of the penalised squared error, the
/// consequents being those of each step (variable projection; Levenberg-Marquardt). Widths stay within a
/// factor of 10 of the start.
DfnnRules refineRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnRules& start,
                      double ridge, double departureRidge, int iterations = 40);

}  // namespace mm
