#pragma once
#include <Eigen/Core>
#include <vector>

#include "thermal/dfnn_rules.h"

namespace mm {

/// Consequents of a fuzzy network with a ridge, in two steps: the ridge-linear fit, common to all rules, and
/// the departure of each rule from it, fitted to what the line leaves. So the network goes over into
/// ridge-linear regression as the ridge on the departures grows, and beyond the samples it goes on as that
/// does. Penalties are relative to the number of samples; the common offset is not penalised.
class RidgeConsequents {
 public:
  /// Columns 1, x and, where there are several rules, those of DfnnRules::design() for x within the rules'
  /// range.
  static Eigen::MatrixXd design(const Eigen::MatrixXd& x, const DfnnRules& rules);

  /// @param z design() of the samples, y samples x outputs, inputs: how many.
  RidgeConsequents(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, Eigen::Index inputs);
  /// Coefficients of the design's columns, columns x outputs, for each of the ridges on the line.
  std::vector<Eigen::MatrixXd> solve(const std::vector<double>& ridges, double departureRidge) const;
  Eigen::MatrixXd solve(double ridge, double departureRidge) const {
    return solve(std::vector<double>{ridge}, departureRidge).front();
  }

 private:
  Eigen::MatrixXd gram_, right_;  // of all columns
  double samples_;
  Eigen::Index line_;  // columns of the line
};

/// Moves centres and widths of the rules to the nearest minimum of the penalised squared error, the
/// consequents being those of each step (variable projection; Levenberg-Marquardt). Widths stay within a
/// factor of 10 of the start.
DfnnRules refineRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnRules& start,
                      double ridge, double departureRidge, int iterations = 40);

}  // namespace mm
