#include "ros_bridge/residual_markers.h"

#include <cmath>

namespace mm {
namespace {

using visualization_msgs::Marker;

constexpr double kUsualArrow = 2e-3;  // m

Marker marker(const std::string& frame, const std::string& name, int type) {
  Marker m;
  m.header.frame_id = frame;
  m.ns = name;
  m.type = type;
  m.action = Marker::ADD;
  m.pose.orientation.w = 1.0;
  return m;
}

geometry_msgs::Point toPoint(const Eigen::Vector3d& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

std_msgs::ColorRGBA colour(double r, double g, double b, double a) {
  std_msgs::ColorRGBA c;
  c.r = static_cast<float>(r);
  c.g = static_cast<float>(g);
  c.b = static_cast<float>(b);
  c.a = static_cast<float>(a);
  return c;
}

/// Where an observation was, and its residual as a vector (m); zero where there is none in m.
Eigen::Vector3d residualVector(const CalibrationResult& result, int observation, Eigen::Vector3d& at,
                               bool& counts) {
  const Problem& problem = *result.problem;
  const Observation& o = problem.session().observations[static_cast<std::size_t>(observation)];
  at = problem.state(observation).tip;
  if (std::isfinite(o.laserReading)) at += problem.state(observation).orientation.col(2) * o.laserReading;
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();
  const bool ball =
      o.kind == ObservationKind::kContact &&
      problem.session().artifact.features[static_cast<std::size_t>(o.feature)].kind == FeatureKind::kBall;
  if (ball) outward = (at - problem.featureInWorkpiece(o.feature, result.x)).normalized();
  const int end = observation + 1 < static_cast<int>(problem.session().observations.size())
                      ? problem.firstRow(observation + 1)
                      : problem.rowCount();
  counts = true;
  for (int row = problem.firstRow(observation); row < end; ++row) {
    const ResidualRow& r = problem.rows()[static_cast<std::size_t>(row)];
    counts = counts && result.weight[row] > 0.0;
    if (r.angular) continue;
    if (ball)
      residual = result.residuals[row] * outward;
    else if (o.kind == ObservationKind::kDeviation)
      residual +=
          result.residuals[row] *
          problem.session().machine.jacobian(o.position.data(), 0.0).col(r.component).head<3>().normalized();
    else
      residual[r.component] = result.residuals[row];
  }
  return residual;
}

}  // namespace

visualization_msgs::MarkerArray residualMarkers(const CalibrationResult& result, double scale,
                                                const std::string& frame) {
  if (!(scale > 0.0)) scale = result.figures.rms > 0.0 ? kUsualArrow / result.figures.rms : 1.0;
  visualization_msgs::MarkerArray all;
  Marker clear = marker(frame, "", Marker::SPHERE);
  clear.action = Marker::DELETEALL;
  all.markers.push_back(clear);

  Marker arrows = marker(frame, "residuals", Marker::LINE_LIST);
  constexpr double kShaft = 0.1e-3;  // m, width of an arrow
  arrows.scale.x = kShaft;           // m, width
  Marker dots = marker(frame, "contacts", Marker::SPHERE_LIST);
  constexpr double kDot = 0.3e-3;  // m, side of a dot
  dots.scale.x = dots.scale.y = dots.scale.z = kDot;
  const Problem& problem = *result.problem;
  for (int i = 0; i < static_cast<int>(problem.session().observations.size()); ++i) {
    if (!problem.uses(i)) continue;
    Eigen::Vector3d at;
    bool counts = true;
    const Eigen::Vector3d residual = residualVector(result, i, at, counts);
    if (!at.allFinite() || !residual.allFinite()) continue;
    const std_msgs::ColorRGBA shade = counts ? colour(0.1, 0.6, 1.0, 1.0) : colour(1.0, 0.1, 0.1, 1.0);
    arrows.points.push_back(toPoint(at));
    arrows.points.push_back(toPoint(at + scale * residual));
    arrows.colors.push_back(shade);
    arrows.colors.push_back(shade);
    dots.points.push_back(toPoint(at));
    dots.colors.push_back(shade);
  }
  if (!arrows.points.empty()) {
    all.markers.push_back(arrows);
    all.markers.push_back(dots);
  }
  int id = 0;
  const Artifact& artifact = problem.session().artifact;
  for (std::size_t f = 0; f < artifact.features.size(); ++f) {
    if (artifact.features[f].kind != FeatureKind::kBall) continue;
    const Eigen::Vector3d centre = problem.featureInWorkpiece(static_cast<int>(f), result.x);
    if (!centre.allFinite()) continue;
    Marker ball = marker(frame, "balls", Marker::SPHERE);
    ball.id = id++;
    ball.pose.position = toPoint(centre);
    ball.scale.x = ball.scale.y = ball.scale.z = 2.0 * artifact.features[f].radius;
    ball.color = colour(0.7, 0.7, 0.7, 0.5);
    all.markers.push_back(ball);
  }
  return all;
}

}  // namespace mm
