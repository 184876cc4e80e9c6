#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace mm {

enum class JointKind { kLinear, kRotary };

/// One moving joint of the chain workpiece -> probe_tip. SI: m, rad, m/s, rad/s.
struct Joint {
  std::string name;
  JointKind kind = JointKind::kLinear;
  double lower = 0.0;  // limits of motion; they never bound import
  double upper = 0.0;
  double maxVelocity = 0.0;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  // unit vector, axes of the joint's fixed side
  Eigen::Vector3d origin =
      Eigen::Vector3d::Zero();  // from the joint before it, axes of the joint's fixed side, m
};

/// Where each small error of one state stands in the vector of errors that `Machine::measure` takes.
/// Units: m and rad.
class ErrorLayout {
 public:
  explicit ErrorLayout(int joints) : joints_(joints) {}  ///< number of joints of the machine
  int axis(int joint) const { return joint; }            ///< added to the reading of a joint
  /// Translation and rotation of a joint's axis, in the axes of the joint's fixed side, that towards the bed
  /// (ISO 230-1).
  int jointTranslation(int joint, int k) const { return joints_ + 6 * joint + k; }
  int jointRotation(int joint, int k) const { return joints_ + 6 * joint + 3 + k; }
  int volume(int k) const { return 7 * joints_ + k; }  ///< displacement of the tip, in workpiece
  int orientation(int k) const {
    return 7 * joints_ + 3 + k;
  }  ///< rotation of the probe about its tip, in workpiece
  int probe(int k) const { return 7 * joints_ + 6 + k; }  ///< displacement in the axes of the link probe_tip
  int beam(int k) const {
    return 7 * joints_ + 9 + k;
  }                                                  ///< change of the beam's direction, axes of probe_tip
  int reading() const { return 7 * joints_ + 12; }   ///< added to the laser's reading
  int distance() const { return 7 * joints_ + 13; }  ///< added to the distance tip centre - ball centre
  int feature(int k) const {
    return 7 * joints_ + 14 + k;
  }                                              ///< displacement of the touched feature, artifact frame
  int size() const { return 7 * joints_ + 17; }  ///< of the vector of errors
  int joints() const { return joints_; }         ///< as given

 private:
  int joints_;
};

/// Where the probe is: tip centre (touch) or surface point (laser), and the orientation of probe_tip, in
/// workpiece.
struct ProbePose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();         // m
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  // columns: axes of probe_tip in workpiece
};

/// The kinematic chain from link `workpiece` to link `probe_tip` of a URDF.
class Machine {
 public:
  /// @param urdf text of the URDF. @param name what `machine:` said. @throw InputError when a link is
  /// missing.
  Machine(std::string urdf, std::string name);

  /// @param nameOrPath `three_axis`, `five_axis` or the path of a URDF. @param relativeTo folder of the file
  /// that names it. @throw InputError when it cannot be read.
  static Machine load(const std::string& nameOrPath, const std::filesystem::path& relativeTo = {});

  const std::string& name() const { return name_; }                    ///< as in the model file
  const std::string& urdf() const { return urdf_; }                    ///< its text, whole
  const std::vector<Joint>& joints() const { return joints_; }         ///< from workpiece to probe_tip
  int jointCount() const { return static_cast<int>(joints_.size()); }  ///< moving joints
  int tableJoints() const { return tableJoints_; }  ///< the first ones, which carry the workpiece on the bed
  /// @return index of a joint, or -1.
  int findJoint(const std::string& name) const;
  ErrorLayout layout() const { return ErrorLayout(jointCount()); }
  /// Nominal probe_tip in the frame of the last moving joint (its moving side, at zero the axes of its fixed
  /// side).
  const Eigen::Vector3d& tipTranslation() const { return tip_.translation; }  // m
  const Eigen::Matrix3d& tipRotation() const { return tip_.rotation; }

  /// Pose at the readings `q` (one a joint, m or rad) with the beam's reading (m; NaN or 0 for a touch
  /// probe).
  ProbePose nominal(const double* q, double laserReading) const;

  /// Pose with the small errors of `layout()` applied, exact in the axis errors, first order in small
  /// rotations.
  /// @param errors layout().size() values. @param gradient if not null, 6 x layout().size(): derivative of
  /// the position (rows 0-2, m) and of the orientation as a rotation vector in workpiece (rows 3-5, rad).
  ProbePose measure(const double* q, double laserReading, const double* errors,
                    Eigen::Matrix<double, 6, Eigen::Dynamic>* gradient = nullptr) const;

  /// Velocity of the tip per unit velocity of a joint: rows 0-2 linear, 3-5 angular, in workpiece, nominal
  /// chain.
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(const double* q, double laserReading) const;

  /// What an independent instrument reads of a small motion of the probe, as true minus indicated reading of
  /// a joint: row vector, by the translation (columns 0-2) and rotation (3-5) of the probe in workpiece.
  /// Along a linear joint; about the axis of a rotary one (polygon and autocollimator); on a pointing device,
  /// two rotary joints and nothing else, by its line of sight, which at zero readings is square to both axes:
  /// all that a star or a tracker tells.
  Eigen::Matrix<double, 1, 6> seenAsDeviation(int joint, const double* q, double laserReading) const;

 private:
  struct Link {                // one moving joint, or the tip
    Eigen::Matrix3d rotation;  // fixed transform before it
    Eigen::Vector3d translation;
    Eigen::Vector3d axis;  // of the joint, in the frame after the fixed transform
    bool turned = false;   // `rotation` is not the identity
    void appendTo(ProbePose& pose) const;
  };
  std::string name_, urdf_;
  std::vector<Joint> joints_;
  int tableJoints_ = 0;
  std::vector<Link> links_;
  Link tip_;  // after the last moving joint
};

}  // namespace mm
