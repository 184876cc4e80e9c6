#pragma once
#include <string>
#include <vector>

#include "estimation/linearisation.h"
#include "estimation/noise_fit.h"

namespace mm {

/// In which directions a residual can be caused: the factor of a displacement along x, y, z of the workpiece,
/// of the approach (contacts), and of each rotary joint's reading (angular residuals); rows x directions, SI.
struct Directions {
  std::vector<std::string> names;  // as in formula's `direction`
  Eigen::MatrixXd factors;         // a used row x directions, not whitened
};
/// @param used the problem's data rows that are asked.
Directions directionsOf(const Linearisation& at, const std::vector<int>& used);

/// The rows of a linearised problem for the model of the noise.
struct LinearisedRows {
  NoiseRows rows;
  std::vector<std::string> directions;  // of drift
  std::vector<double> directionScale;   // m (rad) of a drift of ratio 1 beside white noise of 1
};
/// @param sigma of each data row, m or rad. @param target, base: whitened, the used rows and then the priors.
LinearisedRows noiseRows(const Linearisation& at, const std::vector<int>& used, const Eigen::VectorXd& sigma,
                         Eigen::VectorXd target, RowMatrix base);

}  // namespace mm
