#include "base/grid_values.h"

#include <algorithm>
#include <cmath>

namespace mm {

std::pair<std::size_t, double> placeAmong(const std::vector<double>& at, double position) {
  if (at.size() < 2) return {0, 0.0};
  if (std::isnan(position)) return {0, position};
  if (position <= at.front()) return {0, 0.0};
  if (position >= at.back()) return {at.size() - 2, 1.0};
  const auto i = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), position) - at.begin()) - 1;
  return {i, (position - at[i]) / (at[i + 1] - at[i])};
}

std::vector<GridCorner> gridCorners(const std::vector<std::vector<double>>& at,
                                    const std::vector<double>& position) {
  std::vector<GridCorner> corners = {{0, 1.0}};
  for (std::size_t axis = 0; axis < at.size(); ++axis) {
    const auto [before, share] = placeAmong(at[axis], position[axis]);
    std::vector<GridCorner> next;
    for (const GridCorner& corner : corners) {
      const std::size_t point = corner.point * at[axis].size() + before;
      next.push_back({point, corner.share * (1.0 - share)});
      next.push_back({point + 1, corner.share * share});
    }
    corners = std::move(next);
  }
  return corners;
}

double gridValue(const std::vector<GridCorner>& corners, const std::vector<double>& values) {
  double sum = 0.0;
  for (const GridCorner& corner : corners) sum += corner.share * values[corner.point];
  return sum;
}

}  // namespace mm
