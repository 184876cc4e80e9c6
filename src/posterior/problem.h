#pragma once
#include <tuple>
#include <utility>
#include <vector>

#include "estimation/noise_fit.h"
#include "posterior/size_grid.h"

namespace mm {

/// One shape of a cause: columns of the problem, whose coefficients are drawn together.
struct CauseShape {
  int cause = 0;
  int first = 0, count = 0;        // columns
  bool secondPartOfFirst = false;  // of the first two coefficients (part_of_first.h)
  Sizes logPrior = Sizes::Zero();  // of this shape at each size, given that the cause acts
};

/// One thing that may act.
struct Cause {
  double logPriorOdds = 0.0;  // that it acts, against that it does not
  int first = 0, end = 0;     // of the shapes
  /// Other causes of which this one is a part where they act, and its usual share of their size.
  std::vector<std::pair<int, double>> partOf = {};
};

/// A linear-Gaussian session: what is free, what scatters, and what may act.
struct PosteriorProblem {
  NoiseRows rows;                    // whitened by the stated noise
  std::vector<RandomBlock> scatter;  // what belongs to places; `fixed` ones are always there
  RowMatrix columns;                 // of all shapes, length of the rows
  std::vector<CauseShape> shapes;    // those of a cause after one another
  std::vector<Cause> causes;
  /// Degrees of freedom that the stated noise is worth: many where it was declared or repeated often, one
  /// where it was estimated from the residuals themselves.
  double statedFreedoms = 1.0;
};

/// What the noise may be.
struct NoiseState {
  std::vector<DriftTerm> drift;
  std::vector<double> scatter;  // ratios of the blocks, in units of the white noise
  Eigen::VectorXd variance;     // a data row, of its white noise
  /// Log prior: what every machine has costs little, and less the larger it is (half-Cauchy in units of the
  /// white noise).
  double logPrior(const PosteriorProblem& problem) const;
  /// Whether two states are the same but for a few percent.
  bool resembles(const NoiseState& other) const;
};

/// A shape that acts, at a size of the grid.
struct Acting {
  int shape = 0, size = 0;
  bool operator<(const Acting& other) const {
    return std::tie(shape, size) < std::tie(other.shape, other.size);
  }
};
/// At most one shape of a cause; ascending in the shapes.
using ActingSet = std::vector<Acting>;

}  // namespace mm
