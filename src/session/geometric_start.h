#pragma once
#include <Eigen/Core>
#include <vector>

#include "session/session.h"

namespace mm {

/// Start values from the geometry alone: centres of the balls in workpiece and the pose of the artifact.
struct GeometricStart {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // artifact -> workpiece
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   // m
  std::vector<Eigen::Vector3d> features;                   // in workpiece, m
};
/// From the contacts alone, at the nominal machine.
GeometricStart geometricStart(const Session& session);

/// The rigid motion that brings `from` closest to `to` (columns, m): translation alone of one point, the
/// shortest rotation of points on one line. Otherwise that of Umeyama (IEEE Trans. PAMI 13 (1991) 376), a
/// rotation also where a reflection fits better.
void rigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, Eigen::Matrix3d& rotation,
                 Eigen::Vector3d& translation);

}  // namespace mm
