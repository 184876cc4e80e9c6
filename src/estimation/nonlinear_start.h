#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// Start values for parameters that enter nonlinearly (a period, a time constant): each effect's searchStarts
/// are tried with everything else refitted by the linearised problem; the best, with its amplitudes, goes
/// into x. Effects whose nonlinear parameters have no searchStarts (formulas) are left alone.
/// @param cancelled ends the search with the best so far; may be empty.
void nonlinearStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                    const Eigen::VectorXd& inverseSigma, const std::function<bool()>& cancelled);

}  // namespace mm
