#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/linearisation.h"

namespace mm {

/// What it does to the residuals of contacts that balls and points lie beside the places in their file, or
/// have other radii.
struct BallColumns {
  Eigen::MatrixXd centres;  // data rows of the problem x 3 a feature, m/m: zero where the place is an unknown
  /// Data rows x 1 a feature, m/m: zero for a point, and for a ball whose radius is an unknown, as it is
  /// where the file states its uncertainty: beside that, a scatter of the radii would stand for whatever
  /// moves balls.
  Eigen::MatrixXd radii;
};

/// Their places scatter as one number, not as an unknown each, where there are so many; more are treated as
/// free of scatter: their columns would be too many.
constexpr std::size_t kFewestScattering = 3, kMostScattering = 40;

/// @param rows of the problem that are used. @return each empty where no contact shows any of it, or the
/// artifact has too few or too many features.
BallColumns ballColumns(const Linearisation& at, const std::vector<int>& rows);

}  // namespace mm
