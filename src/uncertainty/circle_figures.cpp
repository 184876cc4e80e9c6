#include "uncertainty/circle_figures.h"

#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kTurn = 2.0 * kPi;
constexpr double kLargestGap = kTurn / 12.0;
constexpr double kRound = 2e-3;  // readings of a circle are on it within this share of the radius

using Points = std::vector<Eigen::Vector2d>;

double inTurn(double angle) { return angle - kTurn * std::floor(angle / kTurn); }

/// Whether ascending angles go round without a large gap.
bool wholeTurn(std::vector<double> angles) {
  if (angles.size() < 12) return false;
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + kTurn - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return gap <= kLargestGap;
}

/// Radius of a path at an angle, linear between its points; both ends of the turn meet.
double radiusAt(const CirclePath& path, double angle) {
  const std::size_t n = path.angle.size();
  const auto above = static_cast<std::size_t>(std::upper_bound(path.angle.begin(), path.angle.end(), angle) -
                                              path.angle.begin());
  const std::size_t high = above % n, low = (above + n - 1) % n;
  const double width = inTurn(path.angle[high] - path.angle[low]);
  const double share = width > 0.0 ? inTurn(angle - path.angle[low]) / width : 0.0;
  return path.radial[low] + share * (path.radial[high] - path.radial[low]);
}

/// Radial deviations about a centre (mm), in um, points of nearly the same angle (other turns) taken
/// together.
CirclePath pathAbout(const Points& points, const Eigen::Vector2d& centre, double radius) {
  std::vector<std::pair<double, double>> polar;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d out = p - centre;
    polar.emplace_back(inTurn(std::atan2(out.y(), out.x())), (out.norm() - radius) * 1e3);
  }
  std::sort(polar.begin(), polar.end());
  CirclePath path;
  const auto range = std::minmax_element(polar.begin(), polar.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
  path.largest = range.second->second;
  path.smallest = range.first->second;
  path.circular = path.largest - path.smallest;
  constexpr double kSame = kTurn / 3600.0;
  for (std::size_t i = 0; i < polar.size();) {
    double angle = 0.0, radial = 0.0;
    std::size_t end = i;
    for (; end < polar.size() && polar[end].first - polar[i].first < kSame; ++end) {
      angle += polar[end].first;
      radial += polar[end].second;
    }
    const double count = end - i;
    path.angle.push_back(angle / count);
    path.radial.push_back(radial / count);
    i = end;
  }
  return path;
}

}  // namespace

Circle leastSquaresCircle(const Points& points) {
  const Eigen::Index n = points.size();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / n;
  Eigen::MatrixXd a(n, 3);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d p = points[i] - mean;
    a.row(i) << 2.0 * p.x(), 2.0 * p.y(), 1.0;
    b[i] = p.squaredNorm();
  }
  const Eigen::Vector3d start = leastSquares(a, b);
  Circle circle{start.head<2>(), std::sqrt(std::max(0.0, start[2] + start.head<2>().squaredNorm()))};
  for (int step = 0; step < 20; ++step) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector2d out = points[i] - mean - circle.centre;
      const double distance = out.norm();
      if (!(distance > 0.0)) return {mean + circle.centre, circle.radius};
      a.row(i) << out.x() / distance, out.y() / distance, 1.0;
      b[i] = distance - circle.radius;
    }
    const Eigen::Vector3d change = leastSquares(a, b);
    circle.centre += change.head<2>();
    circle.radius += change[2];
    constexpr double kSettled = 1e-12;  // of the radius, or m: rounding
    if (change.norm() < kSettled * std::max(1.0, circle.radius)) break;
  }
  circle.centre += mean;
  return circle;
}

CircleFigures circleFigures(const std::vector<CirclePoint>& points, double radius) {
  constexpr double kMillimetresPerUm = 1e-3;
  CircleFigures f;
  Points both, sense[2];
  for (const bool ccw : {true, false}) {
    std::vector<double> angles;
    Points& path = sense[ccw ? 0 : 1];
    for (const CirclePoint& p : points) {
      if (p.counterClockwise != ccw) continue;
      angles.push_back(inTurn(p.angle));
      path.emplace_back(radius * std::cos(p.angle) + p.u * kMillimetresPerUm,
                        radius * std::sin(p.angle) + p.v * kMillimetresPerUm);
    }
    if (!wholeTurn(angles)) {
      path.clear();
      continue;
    }
    (ccw ? f.counterClockwise : f.clockwise) = pathAbout(path, leastSquaresCircle(path).centre, radius);
    both.insert(both.end(), path.begin(), path.end());
  }
  if (sense[0].empty() || sense[1].empty()) return f;
  const Circle common = leastSquaresCircle(both);
  f.meanRadial = (common.radius - radius) * 1e3;
  f.bidirectional = pathAbout(both, common.centre, radius).circular;
  const CirclePath ccw = pathAbout(sense[0], common.centre, radius),
                   cw = pathAbout(sense[1], common.centre, radius);
  f.hysteresis = 0.0;
  for (std::size_t i = 0; i < ccw.angle.size(); ++i)
    f.hysteresis = std::max(f.hysteresis, std::abs(ccw.radial[i] - radiusAt(cw, ccw.angle[i])));
  return f;
}

std::optional<CircleTest> circleTest(const std::vector<CirclePlace>& places) {
  if (places.size() < 12) return std::nullopt;
  Points nominal;
  for (const CirclePlace& p : places) nominal.push_back(p.nominal);
  const Circle circle = leastSquaresCircle(nominal);
  if (!(circle.radius > 0.0) || !circle.centre.allFinite()) return std::nullopt;
  std::vector<double> angles;
  for (const Eigen::Vector2d& p : nominal) {
    const Eigen::Vector2d out = p - circle.centre;
    if (std::abs(out.norm() - circle.radius) > kRound * circle.radius) return std::nullopt;
    angles.push_back(inTurn(std::atan2(out.y(), out.x())));
  }
  if (!wholeTurn(angles)) return std::nullopt;
  CircleTest test;
  test.radius = circle.radius;
  std::vector<CirclePoint> measured, left;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t from = i == 0 ? 0 : i - 1, to = i == 0 ? 1 : i;  // the way by which it was reached
    const bool ccw = std::remainder(angles[to] - angles[from], kTurn) >= 0.0;
    measured.push_back({angles[i], places[i].measured.x(), places[i].measured.y(), ccw});
    left.push_back({angles[i], places[i].left.x(), places[i].left.y(), ccw});
  }
  test.measured = circleFigures(measured, circle.radius);
  test.calibrated = circleFigures(left, circle.radius);
  if (test.measured.counterClockwise.angle.empty() && test.measured.clockwise.angle.empty())
    return std::nullopt;
  return test;
}

}  // namespace mm
