#pragma once
#include <string>
#include <utility>
#include <vector>

#include "estimation/residual_space.h"

namespace mm {

/// A target for the measurement plan: values by the names of the import columns.
struct Move {
  std::vector<std::pair<std::string, double>> values;      // "x_mm", "b_deg", "wait_s" …
  std::vector<std::pair<std::string, std::string>> words;  // "feature"
  std::vector<double> approach;                            // unit vector in workpiece, or empty
  std::vector<std::pair<std::string, double>> from;        // a joint: the side it comes from, -1 or +1
  /// Of a named placement: turned about the vertical and shifted from where the artifact's file says it is in
  /// workpiece (rad, m).
  double turn = 0.0;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
};

/// An effect with the values of its nonlinear parameters: one explanation of the data.
struct Hypothesis {
  EffectPtr effect;
  std::vector<double> nonlinear;
};

struct NextMeasurement {
  std::vector<Move> moves;
  std::string change;  // what the operator changes before them, in words; empty: nothing
  struct Rival {
    bool same = false;  // each imitates the other wherever the machine can go
    double deviations =
        0.0;  // by which the moves tell it from the leading hypothesis, in standard deviations
  };
  std::vector<Rival> rivals;  // as asked; empty where nothing could be proposed
};

/// Feasible moves that best tell `own` from its rivals: the leading hypothesis is believed at its fitted
/// size, each rival imitates it as well as it can on the data so far, and the moves are those at which the
/// imitation fails most for its uncertainty (T-optimal design, greedily). Where they do not tell enough with
/// the artifact as it stands, it is turned, or another stylus taken, if that tells more.
NextMeasurement nextMeasurement(const ResidualSpace& space, const Hypothesis& own,
                                const std::vector<Hypothesis>& rivals);

}  // namespace mm
