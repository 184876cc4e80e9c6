#include "ros_bridge/correction_messages.h"

#include <Eigen/Geometry>
#include <cmath>

namespace mm {

geometry_msgs::TransformStamped toTransform(const ProbePose& pose, const ros::Time& stamp,
                                            const std::string& parent, const std::string& child) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = pose.position.x();
  message.transform.translation.y = pose.position.y();
  message.transform.translation.z = pose.position.z();
  const Eigen::Quaterniond q = Eigen::Quaterniond(pose.orientation).normalized();
  message.transform.rotation.x = q.x();
  message.transform.rotation.y = q.y();
  message.transform.rotation.z = q.z();
  message.transform.rotation.w = q.w();
  return message;
}

measuring_machine::CorrectedContact toContactMessage(const measuring_machine::ProbeContact& contact,
                                                     const Correction& correction,
                                                     const Calibration& calibration) {
  measuring_machine::CorrectedContact message;
  message.header = contact.header;
  message.approach = contact.approach;
  message.feature = contact.feature;
  message.calibration_id = calibration.id;
  const auto toPoint = [](const Eigen::Vector3d& p) {
    geometry_msgs::Point point;
    point.x = p.x();
    point.y = p.y();
    point.z = p.z();
    return point;
  };
  message.position = toPoint(correction.corrected.position);
  message.nominal = toPoint(correction.nominal.position);
  Eigen::Matrix3d covariance = correction.covariance;
  // The repeatability of a purely angular session says nothing about lengths.
  if (std::isfinite(calibration.rms) && calibration.repeatability > 0.0)
    covariance.diagonal().array() += calibration.repeatability * calibration.repeatability;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) message.covariance[3 * r + c] = covariance(r, c);
  message.sigma = std::sqrt(covariance.trace() / 3.0);
  return message;
}

}  // namespace mm
