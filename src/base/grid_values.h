#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace mm {

/// Where `position` lies among ascending points: the one before it, and the share of the way to the next, 0
/// to 1; the ends are held.
std::pair<std::size_t, double> placeAmong(const std::vector<double>& at, double position);

/// A point of a grid, the last axis fastest, and its share of what the grid says at a place.
struct GridCorner {
  std::size_t point = 0;
  double share = 0.0;
};

/// The corners around a place, linear along each axis, the border beyond. @param at ascending positions of
/// each axis, at least two. @param position one an axis.
std::vector<GridCorner> gridCorners(const std::vector<std::vector<double>>& at,
                                    const std::vector<double>& position);
/// What the values of a grid say between its corners.
double gridValue(const std::vector<GridCorner>& corners, const std::vector<double>& values);

}  // namespace mm
