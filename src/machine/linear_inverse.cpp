#include "machine/linear_inverse.h"

#include "base/dense.h"

namespace mm {

std::vector<int> linearJoints(const std::vector<Joint>& joints) {
  std::vector<int> linear;
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (joints[j].kind == JointKind::kLinear) linear.push_back(static_cast<int>(j));
  return linear;
}

LinearMotion linearMotion(const std::vector<int>& linear, const Eigen::Matrix3Xd& byJoint,
                          const Eigen::Vector3d& displacement) {
  LinearMotion motion;
  motion.change = Eigen::VectorXd::Zero(byJoint.cols());
  motion.missed = displacement.norm();
  if (linear.empty()) return motion;
  const Eigen::MatrixXd columns = byJoint(Eigen::all, linear);
  const Eigen::VectorXd by = shortestLeastSquares(columns, displacement);
  motion.change(linear) = by;
  motion.everyDirection = rankOf(columns) == 3;
  motion.missed = (columns * by - displacement).norm();
  return motion;
}

LinearMotion linearMotion(const Machine& machine, const double* q, double laserReading,
                          const Eigen::Vector3d& displacement) {
  return linearMotion(linearJoints(machine.joints()), machine.jacobian(q, laserReading).topRows<3>(),
                      displacement);
}

bool placeTip(const Machine& machine, const Eigen::Vector3d& target, double laserReading,
              std::vector<double>& q) {
  const LinearMotion motion = linearMotion(machine, q.data(), laserReading,
                                           target - machine.nominal(q.data(), laserReading).position);
  if (!motion.everyDirection) return false;
  for (std::size_t j = 0; j < q.size(); ++j) q[j] += motion.change[static_cast<Eigen::Index>(j)];
  return true;
}

bool withinLimits(const std::vector<Joint>& joints, const std::vector<double>& q, double slack) {
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (joints[j].upper > joints[j].lower &&
        (q[j] < joints[j].lower - slack || q[j] > joints[j].upper + slack))
      return false;
  return true;
}

}  // namespace mm
