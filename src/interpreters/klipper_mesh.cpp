#include "interpreters/klipper_mesh.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

/// Lagrange's polynomial through values at 0, 1, 2 …
double lagrange(const std::vector<double>& values, double at) {
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < values.size(); ++j)
      if (j != i) weight *= (at - static_cast<double>(j)) / (static_cast<double>(i) - static_cast<double>(j));
    sum += weight * values[i];
  }
  return sum;
}

/// Cardinal spline between values[i] and values[i + 1]; at the ends the outer neighbour is the end itself.
double cardinal(const std::vector<double>& values, std::size_t i, double t, double tension) {
  const std::size_t last = values.size() - 1;
  const double before = values[i == 0 ? 0 : i - 1], from = values[i], to = values[i + 1],
               after = values[std::min(i + 2, last)];
  const double t2 = t * t, t3 = t2 * t;
  return from * (2 * t3 - 3 * t2 + 1) + to * (-2 * t3 + 3 * t2) +
         tension * (to - before) * (t3 - 2 * t2 + t) + tension * (after - from) * (t3 - t2);
}

/// `between` values more in each section.
std::vector<double> filled(const std::vector<double>& values, int between, const MeshProfile& profile) {
  if (profile.algorithm == MeshAlgorithm::kDirect) return values;
  std::vector<double> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    result.push_back(values[i]);
    if (i + 1 == values.size()) break;
    for (int k = 1; k <= between; ++k) {
      const double t = static_cast<double>(k) / (between + 1);
      result.push_back(profile.algorithm == MeshAlgorithm::kLagrange
                           ? lagrange(values, static_cast<double>(i) + t)
                           : cardinal(values, i, t, profile.tension));
    }
  }
  return result;
}

}  // namespace

KlipperMesh::KlipperMesh(const MeshProfile& profile) : minX_(profile.minX), minY_(profile.minY) {
  std::vector<std::vector<double>> rows;
  for (const auto& row : profile.points) rows.push_back(filled(row, profile.betweenX, profile));
  const std::size_t columns = rows.front().size();
  for (std::size_t x = 0; x < columns; ++x) {
    std::vector<double> column;
    for (const auto& row : rows) column.push_back(row[x]);
    column = filled(column, profile.betweenY, profile);
    grid_.resize(column.size(), std::vector<double>(columns));
    for (std::size_t y = 0; y < column.size(); ++y) grid_[y][x] = column[y];
  }
  stepX_ = (profile.maxX - profile.minX) / static_cast<double>(columns - 1);
  stepY_ = (profile.maxY - profile.minY) / static_cast<double>(grid_.size() - 1);
  double sum = 0.0;
  for (const auto& row : grid_)
    for (const double height : row) sum += height;
  constexpr double kHundred = 100.0;
  average_ = std::nearbyint(kHundred * sum / static_cast<double>(columns * grid_.size())) / kHundred;
}

double KlipperMesh::cell(double coordinate, double lower, double step, int count, int& index) const {
  index = std::clamp(static_cast<int>(std::floor((coordinate - lower) / step)), 0, count - 2);
  return std::clamp((coordinate - (lower + step * index)) / step, 0.0, 1.0);
}

std::vector<double> KlipperMesh::alongX() const {
  std::vector<double> at;
  for (std::size_t i = 0; i < grid_.front().size(); ++i)
    at.push_back(minX_ + static_cast<double>(i) * stepX_);
  return at;
}

std::vector<double> KlipperMesh::alongY() const {
  std::vector<double> at;
  for (std::size_t k = 0; k < grid_.size(); ++k) at.push_back(minY_ + static_cast<double>(k) * stepY_);
  return at;
}

double KlipperMesh::at(double x, double y) const {
  int i = 0, j = 0;
  const double tx = cell(x, minX_, stepX_, static_cast<int>(grid_.front().size()), i);
  const double ty = cell(y, minY_, stepY_, static_cast<int>(grid_.size()), j);
  const auto row = [&](int k) { return (1.0 - tx) * grid_[k][i] + tx * grid_[k][i + 1]; };
  return (1.0 - ty) * row(j) + ty * row(j + 1);
}

double KlipperMesh::lowest() const {
  double found = grid_[0][0];
  for (const auto& row : grid_) found = std::min(found, *std::min_element(row.begin(), row.end()));
  return found;
}

double KlipperMesh::highest() const {
  double found = grid_[0][0];
  for (const auto& row : grid_) found = std::max(found, *std::max_element(row.begin(), row.end()));
  return found;
}

void KlipperMesh::subtract(double height) {
  for (auto& row : grid_)
    for (double& value : row) value -= height;
}

}  // namespace mm
