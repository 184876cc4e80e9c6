#include "session/geometric_start.h"

#include <Eigen/Dense>

#include "session/sphere_centre.h"

namespace mm {
namespace {

/// Points whose extent across a line is below a thousandth of that along it (squares: 1e-6) do not tell the
/// rotation about the line.
constexpr double kOneLine = 1e-6;

}  // namespace

void rigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, Eigen::Matrix3d& rotation,
                 Eigen::Vector3d& translation) {
  const Eigen::Vector3d a = from.rowwise().mean(), b = to.rowwise().mean();
  const Eigen::Vector3d extent =
      Eigen::JacobiSVD<Eigen::Matrix3d>((from.colwise() - a) * (from.colwise() - a).transpose())
          .singularValues();
  rotation.setIdentity();
  if (extent[1] > kOneLine * extent[0]) {
    rotation = Eigen::umeyama(from, to, false).topLeftCorner<3, 3>();
  } else if (from.cols() > 1) {  // on one line: the shortest rotation
    const Eigen::Vector3d u = from.rightCols<1>() - from.leftCols<1>(),
                          v = to.rightCols<1>() - to.leftCols<1>();
    rotation = Eigen::Quaterniond::FromTwoVectors(u, v).toRotationMatrix();
  }
  translation = b - rotation * a;
}

GeometricStart geometricStart(const Session& session) {
  const auto& features = session.artifact.features;
  GeometricStart start;
  std::vector<std::vector<Eigen::Vector3d>> touched(features.size()), approaches(features.size());
  std::vector<char> laser(features.size(), 0);
  for (const Observation& o : session.observations) {
    if (o.kind != ObservationKind::kContact || o.feature < 0) continue;
    const ProbePose pose = session.machine.nominal(o.position.data(), o.laserReading);
    touched[o.feature].push_back(pose.position);
    if (o.laserReading == o.laserReading) laser[o.feature] = 1;
    if (o.approach.allFinite() && o.approach.norm() > 0.5)
      approaches[o.feature].push_back(o.approach.normalized());
  }
  start.features.resize(features.size());
  std::vector<char> found(features.size(), 0);
  for (std::size_t f = 0; f < features.size(); ++f) {
    start.features[f] = features[f].position;
    if (touched[f].empty()) continue;
    if (features[f].kind == FeatureKind::kPoint) {
      start.features[f] = meanOf(touched[f]);
      found[f] = 1;
      continue;
    }
    const double distance = features[f].radius + (laser[f] ? 0.0 : session.artifact.tipRadius);
    if (approaches[f].size() == touched[f].size()) {
      Eigen::Vector3d centre = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < touched[f].size(); ++i)
        centre += touched[f][i] + distance * approaches[f][i];
      start.features[f] = centre / static_cast<double>(touched[f].size());
      found[f] = 1;
    }
    Eigen::Vector3d fitted;
    if (sphereCentre(touched[f], distance, fitted)) {
      // the mirror image of a shallow cap fits too: trust the approach where there is one
      if (!found[f] || (fitted - start.features[f]).norm() < distance) start.features[f] = fitted;
      found[f] = 1;
    }
  }
  if (!session.artifact.poseKnown) {
    Eigen::Matrix3Xd from(3, 0), to(3, 0);
    for (std::size_t f = 0; f < features.size(); ++f) {
      if (!found[f] || !features[f].known) continue;
      from.conservativeResize(3, from.cols() + 1);
      to.conservativeResize(3, to.cols() + 1);
      from.rightCols<1>() = features[f].position;
      to.rightCols<1>() = start.features[f];
    }
    if (from.cols() > 0) rigidMotion(from, to, start.rotation, start.translation);
  }
  for (std::size_t f = 0; f < features.size(); ++f)
    if (features[f].known || !found[f])
      start.features[f] = start.rotation * features[f].position + start.translation;
  return start;
}

}  // namespace mm
