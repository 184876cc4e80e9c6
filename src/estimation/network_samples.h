#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/linearisation.h"

namespace mm {

/// What the other effects leave of the error of one axis, as a network learns it: one sample a set of
/// measurements in which each of its positions was measured.
struct NetworkSamples {
  std::vector<double> positions;  // of the axis, ascending, m or rad: the outputs
  Eigen::MatrixXd temperatures;   // sets x sensors of the domain, degC; NaN: not known
  Eigen::MatrixXd error;          // sets x positions, m or rad: what the axis is off there
  std::vector<int> setOf;         // an observation: its set; -1: in none
  /// Outputs, one a position, at the reading q: linear between two, constant beyond.
  double at(double q, const Eigen::RowVectorXd& outputs) const;
  /// The course of the errors that varies most over all positions: about the size of the largest.
  Eigen::VectorXd mainError() const;
};

/// Gathers the samples from the residuals at x. The outputs are the positions measured where every set holds
/// all of them; else the ends of the observed range, else one for the whole range. Sets that
/// follow each other without a pause are one, and neighbours are averaged where there are more than 300.
/// @param at the problem without networks. @param residuals of its data rows, m or rad. @param
/// weight a data row: 0 leaves it out.
/// @param positions where the outputs must be; empty: as above, and at least kFewestSets sets are needed.
/// @throw InputError when there are too few sets, or the axis is not measured at all.
NetworkSamples gatherNetworkSamples(const Linearisation& at, const Eigen::VectorXd& residuals,
                                    const Eigen::VectorXd& weight, int axis,
                                    const std::vector<double>& positions = {});

inline constexpr int kFewestSets = 6;

}  // namespace mm
