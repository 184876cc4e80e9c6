#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// Unknowns of effects that enter nonlinearly, e.g. a rate inside an exponential of a formula; not the angles
/// of MMT, whose effect is as good as linear.
bool hasNonlinearParameters(const Problem& problem);

/// Everything that enters linearly at its optimum, with the nonlinear parameters of the effects held where
/// they are: from a start far away, half of the way that a descent would have to find.
/// @return false when the residual does not become smaller; x is then as it was.
bool linearStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                 const Eigen::VectorXd& inverseSigma);

/// Each candidate refined; the one that ends with the smallest residual. Of equal ones the first.
/// @param cancelled ends it with the best so far; may be empty.
Eigen::VectorXd bestRefined(const Problem& problem, const std::vector<Eigen::VectorXd>& candidates,
                            const std::vector<char>& fixed, const Eigen::VectorXd& sigma,
                            const Eigen::VectorXd& weight, const std::function<bool()>& cancelled);

}  // namespace mm
