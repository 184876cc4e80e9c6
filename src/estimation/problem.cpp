#include "estimation/problem.h"

#include <Eigen/Dense>
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

Eigen::Matrix3d Problem::poseRotation(const Eigen::VectorXd& x, Eigen::Matrix3d* leftJacobian) const {
  if (leftJacobian != nullptr) leftJacobian->setIdentity();
  if (poseOffset_ < 0) return rotation0_;
  const Eigen::Vector3d w = x.segment<3>(poseOffset_);
  const double angle = w.norm();
  if (angle < kNoTurn) return (Eigen::Matrix3d::Identity() + skew(w)) * rotation0_;
  const Eigen::Matrix3d k = skew(w / angle);
  if (leftJacobian != nullptr)
    *leftJacobian = Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / angle * k +
                    (1 - std::sin(angle) / angle) * k * k;
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() * rotation0_;
}

Eigen::Vector3d Problem::featureInWorkpiece(int feature, const Eigen::VectorXd& x) const {
  Eigen::Vector3d c = featureStart_[feature];
  if (featureOffset_[feature] >= 0) c += x.segment<3>(featureOffset_[feature]);
  Eigen::Vector3d t = translation0_;
  if (poseOffset_ >= 0) t += x.segment<3>(poseOffset_ + 3);
  return poseRotation(x, nullptr) * c + t;
}

int Problem::residualsOf(int observation, const Eigen::VectorXd& x, double* r, Derivative* d,
                         Model::Workspace& work) const {
  const Observation& o = session_->observations[observation];
  const State& at = state(observation);
  const ErrorLayout layout = model_.machine().layout();
  const int rows = firstRow_[observation + 1] - firstRow_[observation];
  const int parameters = model_.parameterCount();
  if (!usable_[observation]) {
    std::fill(r, r + rows, 0.0);
    if (d == nullptr) return rows;
    d->effects.setZero(rows, parameters);
    d->pose.setZero(rows, 6);
    d->feature.setZero(rows, 3);
    d->slots.setZero(rows, layout.size());
    d->radius.setZero(rows);
    return rows;
  }
  const ProbePose pose = model_.corrected(at, x.data(), work, d != nullptr ? &d->unused : nullptr);
  if (d != nullptr) {
    d->effects.setZero(rows, parameters);
    d->pose.setZero(rows, 6);
    d->feature.setZero(rows, 3);
    d->slots.setZero(rows, layout.size());
    d->radius.setZero(rows);
  }
  // by: derivative of a scalar residual with respect to the pose of the probe (6)
  const auto chain = [&](int row, const Eigen::Matrix<double, 1, 6>& by) {
    for (int s = 0; s < layout.size(); ++s) d->slots(row, s) += (by * work.bySlot.col(s)).value();
  };

  if (o.kind == ObservationKind::kDeviation) {
    const ProbePose nominal = model_.machine().nominal(o.position.data(), o.laserReading);
    const Eigen::Vector3d moved = pose.position - nominal.position;
    const Eigen::Vector3d turned = rotationVector(pose.orientation * nominal.orientation.transpose());
    for (int i = 0; i < rows; ++i) {
      const int joint = rows_[firstRow_[observation] + i].component;
      const Eigen::Matrix<double, 1, 6> by =
          model_.machine().seenAsDeviation(joint, o.position.data(), o.laserReading);
      r[i] = o.deviation[joint] - by.head<3>().dot(moved) - by.tail<3>().dot(turned);
      if (d != nullptr) chain(i, -by);
    }
  } else {
    const Artifact& artifact = session_->artifact;
    Eigen::Matrix3d leftJacobian;
    const Eigen::Matrix3d rotation = poseRotation(x, d != nullptr ? &leftJacobian : nullptr);
    Eigen::Vector3d translation = translation0_;
    if (poseOffset_ >= 0) translation += x.segment<3>(poseOffset_ + 3);
    double growth = 1.0;
    if (artifact.expansion != 0.0 && !artifact.temperatureSensor.empty()) {
      const int sensor = model_.domain().findSensor(artifact.temperatureSensor);
      if (sensor >= 0) growth += artifact.expansion * (at.temperature[sensor] - kReferenceTemperature);
    }
    if (o.kind ==
        ObservationKind::kPosition) {  // in the artifact's frame, where its components were measured
      const Eigen::Vector3d inArtifact = rotation.transpose() * (pose.position - translation);
      for (int i = 0; i < rows; ++i) {
        const int k = rows_[firstRow_[observation] + i].component;
        r[i] = o.reference[k] - inArtifact[k];
        if (d == nullptr) continue;
        Eigen::Matrix<double, 1, 6> by = Eigen::Matrix<double, 1, 6>::Zero();
        by.head<3>() = -rotation.col(k).transpose();
        chain(i, by);
        // inArtifact = R'(p - t); a left rotation by w turns it by -w
        d->pose.block<1, 3>(i, 0) =
            -rotation.col(k).transpose() * skew(pose.position - translation) * leftJacobian;
        d->pose.block<1, 3>(i, 3) = rotation.col(k).transpose();
      }
    } else {
      const Feature& feature = artifact.features[o.feature];
      Eigen::Vector3d inArtifact = featureStart_[o.feature];
      if (featureOffset_[o.feature] >= 0) inArtifact += x.segment<3>(featureOffset_[o.feature]);
      const double* errors = work.errors.data();
      inArtifact = growth * inArtifact + Eigen::Map<const Eigen::Vector3d>(errors + layout.feature(0));
      const Eigen::Vector3d offset = rotation * inArtifact;
      const Eigen::Vector3d away = pose.position - offset - translation;
      const auto geometry = [&](int row,
                                const Eigen::RowVector3d& n) {  // residual changes by n . (tip - feature)
        Eigen::Matrix<double, 1, 6> by = Eigen::Matrix<double, 1, 6>::Zero();
        by.head<3>() = n;
        chain(row, by);
        d->pose.block<1, 3>(row, 0) = n * skew(offset) * leftJacobian;
        d->pose.block<1, 3>(row, 3) = -n;
        d->feature.row(row) = -growth * n * rotation;
        d->slots.block<1, 3>(row, layout.feature(0)) -= n * rotation;
      };
      if (feature.kind == FeatureKind::kPoint) {
        for (int k = 0; k < 3; ++k) {
          r[k] = away[k];
          if (d != nullptr) geometry(k, Eigen::RowVector3d::Unit(k));
        }
      } else {
        double distance = growth * feature.radius +
                          (std::isfinite(o.laserReading) ? 0.0 : artifact.tipRadius) +
                          errors[layout.distance()];
        if (radiusOffset_[o.feature] >= 0) distance += x[radiusOffset_[o.feature]];
        const double length = away.norm();
        r[0] = length - distance;
        if (d != nullptr) {
          geometry(0, (away / length).transpose());
          d->slots(0, layout.distance()) -= 1.0;
          d->radius[0] = -1.0;
        }
      }
    }
  }
  if (setupOf_[observation] >= 0 && o.kind != ObservationKind::kContact) {
    const int width = std::max(3, model_.machine().jointCount());
    for (int i = 0; i < rows; ++i) {
      const int offset =
          setupOffset_[setupOf_[observation] * width + rows_[firstRow_[observation] + i].component];
      r[i] -= x[offset];
    }
  }
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
  if (at.kind != ObservationKind::kDeviation && poseOffset_ >= 0) rows.middleCols(poseOffset_, 6) = d.pose;
  if (at.kind == ObservationKind::kContact) {
    if (featureOffset_[at.feature] >= 0) rows.middleCols(featureOffset_[at.feature], 3) = d.feature;
    if (radiusOffset_[at.feature] >= 0) rows.col(radiusOffset_[at.feature]) = d.radius;
  } else if (setupOf_[observation] >= 0) {
    const int width = std::max(3, model_.machine().jointCount());
    for (int i = 0; i < n; ++i)
      rows(i, setupOffset_[setupOf_[observation] * width + rows_[first + i].component]) = -1.0;
  }
}

}  // namespace mm
