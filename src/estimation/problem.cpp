#include "estimation/problem.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/rotation.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kSmallTurn = 1e-4;  // rad: below, the sine of an angle is the angle to rounding
constexpr double kNoTurn = 1e-12;    // rad: below, the direction of a rotation vector is rounding

Eigen::Vector3d rotationVector(const Eigen::Matrix3d& r) {
  const Eigen::AngleAxisd a(r);
  // near the identity AngleAxis loses the axis: the skew part is exact to third order there
  const Eigen::Vector3d half(0.5 * (r(2, 1) - r(1, 2)), 0.5 * (r(0, 2) - r(2, 0)), 0.5 * (r(1, 0) - r(0, 1)));
  return half.norm() < kSmallTurn && a.angle() < 1.0 ? half : Eigen::Vector3d(a.axis() * a.angle());
}

}  // namespace

double UnitVector::weight(const Eigen::VectorXd& inverseSigma) const {
  constexpr double kConstraint = 1e7;  // any: the residuals do not depend on the length
  const double largest = inverseSigma.size() > 0 ? inverseSigma.maxCoeff() : 0.0;
  return penalty > 0.0 ? std::sqrt(penalty) * kMillimetre * largest : kConstraint;
}

Eigen::VectorXd Problem::start() const {
  Eigen::VectorXd x(unknownCount());
  for (int i = 0; i < unknownCount(); ++i) x[i] = unknowns_[i].start;
  return x;
}

int Problem::find(UnknownKind kind, int owner) const {
  for (const UnknownGroup& group : groups_)
    if (group.kind == kind && group.owner == owner) return group.first;
  return -1;
}

Eigen::VectorXd Problem::sigmas(double linearSigma, double angularSigma) const {
  Eigen::VectorXd s(rowCount());
  for (int i = 0; i < rowCount(); ++i)
    s[i] =
        rows_[i].statedSigma > 0.0 ? rows_[i].statedSigma : (rows_[i].angular ? angularSigma : linearSigma);
  return s;
}

Eigen::Matrix3d Problem::poseRotation(int placement, const Eigen::VectorXd& x,
                                      Eigen::Matrix3d* leftJacobian) const {
  const Eigen::Matrix3d& start = start_.poses[static_cast<std::size_t>(placement)].rotation;
  const int offset = poseOffset_[static_cast<std::size_t>(placement)];
  if (leftJacobian != nullptr) leftJacobian->setIdentity();
  if (offset < 0) return start;
  const Eigen::Vector3d w = x.segment<3>(offset);
  const double angle = w.norm();
  if (angle < kNoTurn) return (Eigen::Matrix3d::Identity() + skew(w)) * start;
  const Eigen::Matrix3d k = skew(w / angle);
  if (leftJacobian != nullptr)
    *leftJacobian = Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / angle * k +
                    (1 - std::sin(angle) / angle) * k * k;
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() * start;
}

Eigen::Vector3d Problem::featureInArtifact(int feature, const Eigen::VectorXd& x) const {
  const auto f = static_cast<std::size_t>(feature);
  Eigen::Vector3d position = start_.features[f];
  if (featureOffset_[f] >= 0) position += x.segment<3>(featureOffset_[f]);
  return position;
}

Eigen::Vector3d Problem::featureInWorkpiece(int feature, int placement, const Eigen::VectorXd& x) const {
  const ArtifactPose pose = artifactPose(placement, x, false);
  return pose.rotation * featureInArtifact(feature, x) + pose.translation;
}

Eigen::Vector3d Problem::reach(int stylus, const Eigen::VectorXd& x) const {
  const auto s = static_cast<std::size_t>(stylus);
  Eigen::Vector3d offset = start_.offsets[s];
  if (stylusOffset_[s] >= 0) offset += x.segment<3>(stylusOffset_[s]);
  return offset;
}

void Problem::Derivative::clear(int rows, int parameters, int slotCount) {
  effects.setZero(rows, parameters);
  pose.setZero(rows, 6);
  feature.setZero(rows, 3);
  stylus.setZero(rows, 3);
  slots.setZero(rows, slotCount);
  radius.setZero(rows);
}

/// One observation on the way to its residuals.
struct Problem::Seen {
  int observation = 0, rows = 0;
  const Eigen::VectorXd& x;
  const ProbePose& pose;        // of the probe with the effects applied, at the tip of its stylus
  const Eigen::Vector3d reach;  // of that tip from probe_tip, in workpiece
  const Model::Workspace& work;
  double* r;
  Derivative* d;  // null: not wanted

  /// Passes a derivative with respect to the pose of the probe (6) on to the small errors.
  void chain(int row, Eigen::Matrix<double, 1, 6> by) const {
    by.tail<3>() += reach.cross(by.head<3>().transpose()).transpose();
    for (Eigen::Index s = 0; s < d->slots.cols(); ++s) d->slots(row, s) += (by * work.bySlot.col(s)).value();
  }
};

void Problem::seeDeviation(const Seen& seen) const {
  const Observation& o = session_->observations[seen.observation];
  const ProbePose nominal = model_.machine().nominal(o.position.data(), o.laserReading);
  const Eigen::Vector3d moved = seen.pose.position - nominal.position;
  const Eigen::Vector3d turned = rotationVector(seen.pose.orientation * nominal.orientation.transpose());
  for (int i = 0; i < seen.rows; ++i) {
    const int joint = rows_[firstRow_[seen.observation] + i].component;
    const Eigen::Matrix<double, 1, 6> by =
        model_.machine().seenAsDeviation(joint, o.position.data(), o.laserReading);
    seen.r[i] = o.deviation[joint] - by.head<3>().dot(moved) - by.tail<3>().dot(turned);
    if (seen.d != nullptr) seen.chain(i, -by);
  }
}

Problem::ArtifactPose Problem::artifactPose(int placement, const Eigen::VectorXd& x, bool derivative) const {
  ArtifactPose pose;
  pose.rotation = poseRotation(placement, x, derivative ? &pose.leftJacobian : nullptr);
  pose.translation = start_.poses[static_cast<std::size_t>(placement)].translation;
  const int offset = poseOffset_[static_cast<std::size_t>(placement)];
  if (offset >= 0) pose.translation += x.segment<3>(offset + 3);
  return pose;
}

void Problem::seePosition(const Seen& seen) const {
  // in the artifact's frame, where its components were measured
  const Observation& o = session_->observations[seen.observation];
  const ArtifactPose at = artifactPose(o.placement, seen.x, seen.d != nullptr);
  const Eigen::Vector3d inArtifact = at.rotation.transpose() * (seen.pose.position - at.translation);
  for (int i = 0; i < seen.rows; ++i) {
    const int k = rows_[firstRow_[seen.observation] + i].component;
    seen.r[i] = o.reference[k] - inArtifact[k];
    if (seen.d == nullptr) continue;
    Eigen::Matrix<double, 1, 6> by = Eigen::Matrix<double, 1, 6>::Zero();
    by.head<3>() = -at.rotation.col(k).transpose();
    seen.chain(i, by);
    // inArtifact = R'(p - t); a left rotation by w turns it by -w
    seen.d->pose.block<1, 3>(i, 0) =
        -at.rotation.col(k).transpose() * skew(seen.pose.position - at.translation) * at.leftJacobian;
    seen.d->pose.block<1, 3>(i, 3) = at.rotation.col(k).transpose();
  }
}

double Problem::growthAt(int observation) const {
  const Artifact& artifact = session_->artifact;
  if (artifact.expansion == 0.0 || artifact.temperatureSensor.empty()) return 1.0;
  const int sensor = model_.domain().findSensor(artifact.temperatureSensor);
  if (sensor < 0) return 1.0;
  return 1.0 + artifact.expansion * (state(observation).temperature[sensor] - kReferenceTemperature);
}

Problem::Away Problem::awayFromFeature(const Seen& seen) const {
  const Observation& o = session_->observations[seen.observation];
  Away away;
  away.at = artifactPose(o.placement, seen.x, seen.d != nullptr);
  away.growth = growthAt(seen.observation);
  const double* moved = seen.work.errors.data() + model_.machine().layout().feature(0);
  away.offset = away.at.rotation * (away.growth * featureInArtifact(o.feature, seen.x) +
                                    Eigen::Map<const Eigen::Vector3d>(moved));
  away.vector = seen.pose.position - away.offset - away.at.translation;
  return away;
}

/// The derivative of a residual that changes by n . (probe - feature).
void Problem::changeAlong(const Seen& seen, const Away& away, int row, const Eigen::RowVector3d& n) const {
  Eigen::Matrix<double, 1, 6> by = Eigen::Matrix<double, 1, 6>::Zero();
  by.head<3>() = n;
  seen.chain(row, by);
  seen.d->pose.block<1, 3>(row, 0) = n * skew(away.offset) * away.at.leftJacobian;
  seen.d->pose.block<1, 3>(row, 3) = -n;
  seen.d->feature.row(row) = -away.growth * n * away.at.rotation;
  seen.d->stylus.row(row) = n * seen.pose.orientation;
  seen.d->slots.block<1, 3>(row, model_.machine().layout().feature(0)) -= n * away.at.rotation;
}

void Problem::seeLength(const Seen& seen) const {
  const Away away = awayFromFeature(seen);
  const double length = away.vector.norm();
  seen.r[0] = session_->observations[seen.observation].length - length;
  if (seen.d != nullptr) changeAlong(seen, away, 0, -(away.vector / length).transpose());
}

void Problem::seeContact(const Seen& seen) const {
  const Observation& o = session_->observations[seen.observation];
  const Artifact& artifact = session_->artifact;
  const Feature& feature = artifact.features[o.feature];
  const Away away = awayFromFeature(seen);
  if (feature.kind == FeatureKind::kPoint) {
    for (int k = 0; k < 3; ++k) {
      seen.r[k] = away.vector[k];
      if (seen.d != nullptr) changeAlong(seen, away, k, Eigen::RowVector3d::Unit(k));
    }
    return;
  }
  const int slot = model_.machine().layout().distance();
  double distance = away.growth * feature.radius +
                    (std::isfinite(o.laserReading) ? 0.0 : artifact.tipRadiusOf(o.stylus)) +
                    seen.work.errors[static_cast<std::size_t>(slot)];
  if (radiusOffset_[o.feature] >= 0) distance += seen.x[radiusOffset_[o.feature]];
  const double length = away.vector.norm();
  seen.r[0] = length - distance;
  if (seen.d == nullptr) return;
  changeAlong(seen, away, 0, (away.vector / length).transpose());
  seen.d->slots(0, slot) -= 1.0;
  seen.d->radius[0] = -1.0;
}

int Problem::residualsOf(int observation, const Eigen::VectorXd& x, double* r, Derivative* d,
                         Model::Workspace& work) const {
  const Observation& o = session_->observations[observation];
  const int rows = firstRow_[observation + 1] - firstRow_[observation];
  const auto clear = [&] {
    if (d != nullptr) d->clear(rows, model_.parameterCount(), model_.machine().layout().size());
  };
  if (!usable_[observation]) {
    std::fill(r, r + rows, 0.0);
    clear();
    return rows;
  }
  ProbePose pose = d != nullptr ? model_.differentiated(state(observation), x.data(), work)
                                : model_.corrected(state(observation), x.data(), work);
  clear();
  const Eigen::Vector3d reached = pose.orientation * reach(o.stylus, x);
  pose.position += reached;
  const Seen seen{observation, rows, x, pose, reached, work, r, d};
  switch (o.kind) {
    case ObservationKind::kDeviation:
      seeDeviation(seen);
      break;
    case ObservationKind::kPosition:
      seePosition(seen);
      break;
    case ObservationKind::kLength:
      seeLength(seen);
      break;
    case ObservationKind::kContact:
      seeContact(seen);
      break;
  }
  if (setupOf_[observation] >= 0 && o.kind != ObservationKind::kContact)
    for (int i = 0; i < rows; ++i)
      r[i] -= x[setupOffset_[setupOf_[observation] * std::max(3, model_.machine().jointCount()) +
                             rows_[firstRow_[observation] + i].component]];
  if (d != nullptr)
    for (const Model::Derivative& one : work.derivatives)
      d->effects.col(one.parameter) += d->slots.col(one.slot) * one.value;
  return rows;
}

Eigen::VectorXd Problem::residuals(const Eigen::VectorXd& x) const {
  Eigen::VectorXd r(rowCount());
  Model::Workspace work;
  for (std::size_t o = 0; o < session_->observations.size(); ++o)
    residualsOf(static_cast<int>(o), x, r.data() + firstRow_[o], nullptr, work);
  return r;
}

void Problem::scatter(int observation, const Derivative& d, Eigen::MatrixXd& rows) const {
  const Observation& at = session_->observations[observation];
  const int first = firstRow_[observation], n = firstRow_[observation + 1] - first;
  rows.setZero(n, unknownCount());
  if (!usable_[observation]) return;
  if (model_.parameterCount() > 0) rows.leftCols(model_.parameterCount()) = d.effects;
  const int pose = poseOffset_[static_cast<std::size_t>(at.placement)];
  if (at.kind != ObservationKind::kDeviation && pose >= 0) rows.middleCols(pose, 6) = d.pose;
  if (at.feature >= 0) {
    const int stylus = stylusOffset_[static_cast<std::size_t>(at.stylus)];
    if (stylus >= 0) rows.middleCols(stylus, 3) = d.stylus;
    if (featureOffset_[at.feature] >= 0) rows.middleCols(featureOffset_[at.feature], 3) = d.feature;
    if (radiusOffset_[at.feature] >= 0) rows.col(radiusOffset_[at.feature]) = d.radius;
  }
  if (at.kind != ObservationKind::kContact && setupOf_[observation] >= 0) {
    const int width = std::max(3, model_.machine().jointCount());
    for (int i = 0; i < n; ++i)
      rows(i, setupOffset_[setupOf_[observation] * width + rows_[first + i].component]) = -1.0;
  }
}

}  // namespace mm
