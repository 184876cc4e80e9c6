#include "ros_bridge/residual_markers.h"

#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

#include "base/format.h"
#include "estimation/residual_vector.h"

namespace mm {
namespace {

using visualization_msgs::Marker;

constexpr double kUsualArrow = 2e-3;  // m

/// The longest of 1, 2, 5, 10 … um that an arrow of `scale` shows no longer than a centimetre.
double roundLength(double scale) {
  double length = 1e-9;
  for (int i = 0; 1e-2 >= scale * length * (i % 3 == 1 ? 2.5 : 2.0); ++i) length *= i % 3 == 1 ? 2.5 : 2.0;
  return length;
}

/// An arrow to draw: from where, m in workpiece.
struct Arrow {
  Eigen::Vector3d at, residual;
  bool counts = true;  // not an outlier
};

Arrow arrowOf(const CalibrationResult& result, int observation) {
  const Problem& problem = *result.problem;
  const Session& session = problem.session();
  const Observation& o = session.observations[static_cast<std::size_t>(observation)];
  const bool laser = std::isfinite(o.laserReading);
  Arrow arrow;
  arrow.at = problem.state(observation).tip;
  if (laser) arrow.at += problem.state(observation).orientation.col(2) * o.laserReading;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  if (session.outward(o) != 0)
    normal = (arrow.at - problem.featureInWorkpiece(o.feature, o.placement, result.x)).normalized();
  arrow.residual = residualVector(result, observation, normal);
  if (o.kind == ObservationKind::kContact && !laser)
    arrow.at -= session.artifact.tipRadiusOf(o.stylus) * normal;
  for (int row = problem.firstRow(observation); row < problem.firstRow(observation + 1); ++row)
    arrow.counts = arrow.counts && result.weight[row] > 0.0;
  return arrow;
}

/// A bar of a round length beside the arrows, and what it stands for.
void addScale(const std::string& frame, double scale, const Eigen::Vector3d& top,
              visualization_msgs::MarkerArray& all) {
  const double length = roundLength(scale);
  const Eigen::Vector3d at = top + Eigen::Vector3d(0.0, 0.0, 5e-3);
  Marker bar = markerIn(frame, "scale", Marker::LINE_LIST);
  bar.scale.x = 0.4e-3;  // m, width
  bar.color = colourOf(0.1, 0.6, 1.0);
  bar.points = {tf2::toMsg(at), tf2::toMsg(Eigen::Vector3d(at - Eigen::Vector3d(scale * length, 0.0, 0.0)))};
  all.markers.push_back(bar);
  all.markers.push_back(wordsIn(frame, "scale in words", format("residuals: this is %g um", 1e6 * length),
                                at + Eigen::Vector3d(0.0, 0.0, 2e-3)));
}

}  // namespace

std_msgs::ColorRGBA colourOf(double red, double green, double blue, double opaque) {
  std_msgs::ColorRGBA c;
  c.r = static_cast<float>(red);
  c.g = static_cast<float>(green);
  c.b = static_cast<float>(blue);
  c.a = static_cast<float>(opaque);
  return c;
}

Marker markerIn(const std::string& frame, const std::string& name, int type) {
  Marker m;
  m.header.frame_id = frame;
  m.ns = name;
  m.type = type;
  m.action = Marker::ADD;
  m.pose.orientation.w = 1.0;
  return m;
}

Marker wordsIn(const std::string& frame, const std::string& name, const std::string& text,
               const Eigen::Vector3d& at) {
  Marker m = markerIn(frame, name, Marker::TEXT_VIEW_FACING);
  m.pose.position = tf2::toMsg(at);
  m.text = text;
  m.scale.z = 2e-3;  // m, height of a letter
  m.color = colourOf(1.0, 1.0, 1.0);
  return m;
}

visualization_msgs::MarkerArray residualMarkers(const CalibrationResult& result, double scale,
                                                const std::string& frame) {
  if (!(scale > 0.0)) scale = result.figures.rms > 0.0 ? kUsualArrow / result.figures.rms : 1.0;
  visualization_msgs::MarkerArray all;
  Marker clear = markerIn(frame, "", Marker::SPHERE);
  clear.action = Marker::DELETEALL;
  all.markers.push_back(clear);

  Marker arrows = markerIn(frame, "residuals", Marker::LINE_LIST);
  arrows.scale.x = 0.1e-3;  // m, width
  Marker dots = markerIn(frame, "contacts", Marker::SPHERE_LIST);
  dots.scale.x = dots.scale.y = dots.scale.z = 0.3e-3;    // m, side of a dot
  Eigen::Vector3d top = Eigen::Vector3d::Constant(-1e9);  // the highest of each coordinate, m
  const Problem& problem = *result.problem;
  for (int i = 0; i < static_cast<int>(problem.session().observations.size()); ++i) {
    if (!problem.uses(i)) continue;
    const Arrow arrow = arrowOf(result, i);
    if (!arrow.at.allFinite() || !arrow.residual.allFinite()) continue;
    const std_msgs::ColorRGBA shade = arrow.counts ? colourOf(0.1, 0.6, 1.0) : colourOf(1.0, 0.1, 0.1);
    top = top.cwiseMax(arrow.at);
    arrows.points.push_back(tf2::toMsg(arrow.at));
    arrows.points.push_back(tf2::toMsg(Eigen::Vector3d(arrow.at + scale * arrow.residual)));
    arrows.colors.push_back(shade);
    arrows.colors.push_back(shade);
    dots.points.push_back(tf2::toMsg(arrow.at));
    dots.colors.push_back(shade);
  }
  if (!arrows.points.empty()) {
    all.markers.push_back(arrows);
    all.markers.push_back(dots);
    addScale(frame, scale, top, all);
  }
  int id = 0;
  const Artifact& artifact = problem.session().artifact;
  for (std::size_t f = 0; f < artifact.features.size(); ++f) {
    if (artifact.features[f].kind != FeatureKind::kBall) continue;
    const Eigen::Vector3d centre = problem.featureInWorkpiece(
        static_cast<int>(f), problem.session().placementOf(static_cast<int>(f)), result.x);
    if (!centre.allFinite()) continue;
    Marker ball = markerIn(frame, "balls", Marker::SPHERE);
    ball.id = id++;
    ball.pose.position = tf2::toMsg(centre);
    ball.scale.x = ball.scale.y = ball.scale.z = 2.0 * artifact.features[f].radius;
    ball.color = colourOf(0.7, 0.7, 0.7, 0.5);
    all.markers.push_back(ball);
  }
  return all;
}

}  // namespace mm
