#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// Direction of a beam to begin with: a probe may be mounted the other way round than the chain says, from
/// where no descent finds back. Of directions all around, each with everything else refitted by one linear
/// step, the best goes into x, if it is much better than the one that is there.
void beamStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
               const Eigen::VectorXd& inverseSigma);

}  // namespace mm
