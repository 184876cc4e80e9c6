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
  std::string name;        // for people: "x", "x travel direction", "temperature bed", "time", "ball"
  std::string symbol;      // in formulas: "x", "x_velocity", "bed", "t"; empty for categories
  bool category = false;   // values are then small integers
  Eigen::VectorXd values;  // a used row
  double centre = 0.0, half = 1.0;  // raw = centre + half * scaled, in the unit of formulas
};

/// Every variable of the session that varies and is known for (nearly) all used rows.
std::vector<Variable> variablesOf(const ResidualSpace& space);

/// Directions of the used rows.
Directions directionsOf(const ResidualSpace& space);

/// How much of `left` (whitened, projected residual, length of the space) each variable explains, in any
/// direction: low order terms of the variable times each direction, after everything that the model and
/// `found` absorb.
/// @param found orthonormal columns of effects already found. The p-values are corrected for the number of
/// variables.
std::vector<WhereItFails> explainedByVariable(const ResidualSpace& space, const Eigen::VectorXd& left,
                                              const Eigen::MatrixXd& found);

}  // namespace mm
