#include "uncertainty/task_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/median.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kUsualRadius = 10.0 * kMillimetre;

struct BallRing {
  double fromPole;  // deg
  int points;
  double turned;  // deg
};

}  // namespace

std::vector<Eigen::Vector3d> ballDirections(int count) {
  std::vector<Eigen::Vector3d> directions;
  const auto add = [&](double fromPole, double azimuth) {
    directions.emplace_back(std::sin(fromPole) * std::cos(azimuth), std::sin(fromPole) * std::sin(azimuth),
                            std::cos(fromPole));
  };
  if (count == 25) {
    constexpr BallRing kRings[] = {
        {0.0, 1, 0.0}, {22.5, 4, 0.0}, {45.0, 8, 22.5}, {67.5, 4, 45.0}, {90.0, 8, 67.5}};
    for (const BallRing& ring : kRings)
      for (int i = 0; i < ring.points; ++i)
        add(ring.fromPole * kDegree, (ring.turned + 360.0 * i / ring.points) * kDegree);
    return directions;
  }
  const double golden = kPi * (3.0 - std::sqrt(5.0));  // a turn by it never comes back to the same place
  for (int i = 0; i < count; ++i) add(std::acos(1.0 - static_cast<double>(i) / (count - 1)), golden * i);
  return directions;
}

std::vector<TaskPoint> ballPoints(const Eigen::Vector3d& centre, double radius, int count) {
  std::vector<TaskPoint> points;
  for (const Eigen::Vector3d& normal : ballDirections(count))
    points.push_back({centre + radius * normal, normal, -1, 0.0});
  return points;
}

std::vector<TaskPoint> ringPoints(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double radius,
                                  int count) {
  std::vector<TaskPoint> points;
  const Eigen::Vector3d first = normal.unitOrthogonal(), second = normal.cross(first);
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count;
    const Eigen::Vector3d out = std::cos(angle) * first + std::sin(angle) * second;
    points.push_back({centre + radius * out, out, -1, 0.0});
  }
  return points;
}

std::vector<TaskPoint> squarePoints(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double side,
                                    int count) {
  std::vector<TaskPoint> points;
  // Along the axes of the machine where the normal is one of them.
  Eigen::Index least = 0;
  normal.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d first = normal.cross(Eigen::Vector3d::Unit(least)).normalized();
  const Eigen::Vector3d second = normal.cross(first);
  const int rows = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < rows; ++j) {
      const double u = side * (static_cast<double>(i) / (rows - 1) - 0.5);
      const double v = side * (static_cast<double>(i % 2 == 0 ? j : rows - 1 - j) / (rows - 1) - 0.5);
      points.push_back({centre + u * first + v * second, normal, -1, 0.0});
    }
  return points;
}

std::vector<TaskPoint> linePoints(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                  const Eigen::Vector3d& normal, int count) {
  std::vector<TaskPoint> points;
  for (int i = 0; i < count; ++i)
    points.push_back({from + (to - from) * (static_cast<double>(i) / (count - 1)), normal, -1, 0.0});
  return points;
}

std::vector<Eigen::Vector3d> placesOf(const std::vector<TaskPoint>& points) {
  std::vector<Eigen::Vector3d> places;
  for (const TaskPoint& p : points) places.push_back(p.place);
  return places;
}

double usualBallRadius(const Domain& domain) {
  std::vector<double> radii;
  for (const double r : domain.featureRadius)
    if (r > 0.0) radii.push_back(r);
  if (!radii.empty()) return upperMedian(radii);
  double radius = kUsualRadius;
  for (const double side : Eigen::Vector3d(domain.tipUpper - domain.tipLower))
    if (side > kStoodStill) radius = std::min(radius, 0.25 * side);
  return radius;
}

}  // namespace mm
