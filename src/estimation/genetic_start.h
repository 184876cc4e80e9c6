#pragma once
#include "estimation/calibrate.h"

namespace mm {

/// Runs the published genetic algorithm over the effects' free parameters. Where all effects are linear the
/// fitness is MMT (16), vectorised, with the balls' centres recomputed each generation; else the residuals
/// themselves, with every free unknown a gene.
/// @param x start of all unknowns; on return the best chromosome (and, for nonlinear models, the other
/// unknowns).
GeneticSummary geneticStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                            const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                            const CalibrateOptions& options);

}  // namespace mm
