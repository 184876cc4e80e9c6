#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "estimation/noise_rows.h"
#include "estimation/residual_space.h"

namespace mm {

/// A quantity that the residual may depend on, one value a used row. Continuous ones are scaled to [-1, 1].
struct Variable {
  std::string name;    // for people: "x", "x travel direction", "temperature bed", "time", "ball", "session"
  std::string symbol;  // in formulas: "x", "x_velocity", "bed", "t"; empty for categories
  bool category = false;            // values are then small integers
  std::vector<std::string> labels;  // of a category's values from 0; empty: they are the directions -1 and +1
  Eigen::VectorXd values;           // a used row
  double centre = 0.0, half = 1.0;  // raw = centre + half * scaled, in the unit of formulas
};

/// Every variable of the session that varies and is known for (nearly) all used rows.
std::vector<Variable> variablesOf(const ResidualSpace& space);

/// Directions of the used rows.
Directions directionsOf(const ResidualSpace& space);

/// How much of what the model leaves each variable explains, in any direction: low order terms of the
/// variable times each direction, after everything that the model absorbs; most first. The p-values are
/// corrected for the number of variables.
/// @param noise what whitens the rows; null: they are white. @param scatter columns (length of the space) of
/// what scatters from place to place, and explains nothing.
std::vector<WhereItFails> explainedByVariable(const ResidualSpace& space, const TimeWhitener* noise,
                                              const RowMatrix& scatter);

}  // namespace mm
