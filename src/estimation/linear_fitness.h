#pragma once
#include <memory>
#include <vector>

#include "estimation/genetic_sphere_fitness.h"
#include "estimation/problem.h"

namespace mm {

/// The fitness of MMT (16) of a problem whose effects are all linear in their parameters: contacts on balls,
/// and every other row and prior as linear rows.
/// @param x start of all unknowns, SI, at which the rows are linearised. @param genes unknowns, in the order
/// of a chromosome. @param inverseSigma a data row: sqrt(weight) / sigma, in 1/m or 1/rad; 0 leaves it out.
/// @param unit m or rad that a residual of one standard deviation stands for.
std::unique_ptr<SphereFitness> linearFitness(const Problem& problem, const Eigen::VectorXd& x,
                                             const std::vector<char>& fixed, const std::vector<int>& genes,
                                             const Eigen::VectorXd& inverseSigma, double unit);

}  // namespace mm
