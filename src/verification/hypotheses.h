#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "verification/fresh_points.h"

namespace mm {

/// What became of the correction of one axis. The share of the machine's error that remains is 0, 1, 2, -1.
enum class AxisState { kCorrected, kNotCorrected, kWrongSign, kTwice };

/// A table of one axis that stands at another one.
struct Exchange {
  int of = 0, on = 0;    // of FreshPoints::axes()
  bool entered = false;  // by the other axis's position, too; else it is only added to the other axis
};

/// One way in which a correction can have been loaded, and what the raw readings then show.
struct LoadedHow {
  std::vector<AxisState> axes;      // one an axis
  std::vector<Exchange> exchanges;  // empty: none
  Eigen::VectorXd field;            // length rows of FreshPoints: to be explained
  double logPrior = 0.0;            // log of its odds before any data

  bool uniform() const;  ///< every axis the same, none exchanged
};

/// Every hypothesis that these points can tell apart: all axes alike, one or more axes otherwise, tables of
/// two axes exchanged. The first is that everything is corrected.
/// @param loaded the controller corrected while the points were measured; else they are raw, and a
/// correction that is right explains them. @param seen an axis: whether its correction is large enough.
std::vector<LoadedHow> hypothesesOf(const FreshPoints& points, bool loaded, const std::vector<char>& seen);

/// The share of the machine's error that remains: 0, 1, 2 or -1.
double remainingOf(AxisState state);

}  // namespace mm
