#pragma once
#include <Eigen/Core>
#include <vector>

#include "session/session.h"

namespace mm {

/// A rotation, then a shift.
struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // m
};

/// Start values from the geometry alone: where the artifact stood, where its features are in it, and the
/// offsets of the styli.
struct GeometricStart {
  std::vector<RigidMotion> poses;         // artifact -> workpiece, one a placement
  std::vector<Eigen::Vector3d> features;  // in the artifact's frame, m
  std::vector<Eigen::Vector3d> offsets;   // one a stylus, at the least one: axes of probe_tip, m

  Eigen::Vector3d inWorkpiece(int feature, int placement) const;              ///< m
  Eigen::Vector3d tipOf(const Session& session, const Observation& o) const;  ///< nominal, in workpiece, m
};
/// From the contacts and reference positions alone, at the nominal machine.
GeometricStart geometricStart(const Session& session);

/// Gives every free feature without a start value (NaN) one: the centre of the sphere through its tips (their
/// mean where there is none), or where its lengths begin. @throw InputError: these do not determine it.
void startFreeFeatures(Session& session);

/// Points of which places are known in two frames, m.
struct PointPairs {
  std::vector<Eigen::Vector3d> from, to;
  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { from.push_back(a), to.push_back(b); }
};
Eigen::Matrix3Xd columnsOfPoints(const std::vector<Eigen::Vector3d>& points);  ///< one a point

/// The rigid motion that brings `from` closest to `to` (columns, m): translation alone of one point, the
/// shortest rotation of points on one line. Otherwise that of Umeyama (IEEE Trans. PAMI 13 (1991) 376), a
/// rotation also where a reflection fits better.
RigidMotion rigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

}  // namespace mm
