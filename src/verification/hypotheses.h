#pragma once
#include <Eigen/Core>
#include <optional>
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
  std::vector<AxisState> axes;       // one an axis
  std::optional<AxisState> offsets;  // of the external offsets beside the tables; empty: there are none, or
                                     // these points do not show them
  std::vector<Exchange> exchanges;   // empty: none
  Eigen::VectorXd field;             // length rows of FreshPoints: to be explained
  double logPrior = 0.0;             // log of its odds before any data

  bool alike() const;       ///< every axis the same, none exchanged
  bool uniform() const;     ///< and the external offsets as the axes
  AxisState state() const;  ///< of the axes where they are alike; where there are none, of the offsets
};

/// Every hypothesis that these points can tell apart: all axes alike, one or more axes otherwise, tables of
/// two axes exchanged, each with the external offsets alike or otherwise. The first is that everything is
/// corrected.
/// @param loaded the controller corrected while the points were measured; else they are raw, and a
/// correction that is right explains them. @param seen an axis: whether its correction is large enough.
/// @param offsetsSeen the same of the external offsets.
std::vector<LoadedHow> hypothesesOf(const FreshPoints& points, bool loaded, const std::vector<char>& seen,
                                    bool offsetsSeen);

/// What is said of a state.
struct StateFacts {
  double remaining;     // share of the machine's error: 0, 1, 2 or -1
  const char* finding;  // see Verification::finding
  const char* words;    // what became of an error: "not corrected"
  const char* loaded;   // of tables or of external offsets: "are loaded"
};
/// By the order of AxisState.
const StateFacts& factsOf(AxisState state);

}  // namespace mm
