#include "ros_bridge/correction_messages.h"

#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

#include "base/format.h"
#include "ros_bridge/residual_markers.h"

namespace mm {

geometry_msgs::TransformStamped toTransform(const ProbePose& pose, const ros::Time& stamp,
                                            const std::string& parent, const std::string& child) {
  Eigen::Isometry3d placed = Eigen::Isometry3d::Identity();
  placed.linear() = Eigen::Quaterniond(pose.orientation).normalized().toRotationMatrix();
  placed.translation() = pose.position;
  geometry_msgs::TransformStamped message = tf2::eigenToTransform(placed);
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
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
  message.position = tf2::toMsg(correction.corrected.position);
  message.nominal = tf2::toMsg(correction.nominal.position);
  Eigen::Matrix3d covariance = correction.covariance;
  // The repeatability of a purely angular session says nothing about lengths.
  if (std::isfinite(calibration.rms) && calibration.repeatability > 0.0)
    covariance.diagonal().array() += calibration.repeatability * calibration.repeatability;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) message.covariance[3 * r + c] = covariance(r, c);
  message.sigma = std::sqrt(covariance.trace() / 3.0);
  return message;
}

visualization_msgs::MarkerArray correctionMarkers(const Correction& correction, const std::string& frame) {
  constexpr double kLonger = 1000.0;
  visualization_msgs::Marker arrow = markerIn(frame, "correction", visualization_msgs::Marker::ARROW);
  const Eigen::Vector3d &from = correction.nominal.position, &moved = correction.displacement;
  arrow.points = {tf2::toMsg(from), tf2::toMsg(Eigen::Vector3d(from + kLonger * moved))};
  arrow.scale.x = 0.4e-3;  // m: shaft, head
  arrow.scale.y = 1e-3;
  arrow.color = colourOf(1.0, 0.7, 0.1);
  visualization_msgs::Marker words =
      wordsIn(frame, "correction in words",
              format("corrected - nominal: %.2f, %.2f, %.2f um (x 1000), sigma %.2f um", 1e6 * moved.x(),
                     1e6 * moved.y(), 1e6 * moved.z(), 1e6 * correction.sigma),
              from + Eigen::Vector3d(0.0, 0.0, 6e-3));
  words.color = arrow.color;
  visualization_msgs::MarkerArray all;
  all.markers = {arrow, words};
  return all;
}

}  // namespace mm
