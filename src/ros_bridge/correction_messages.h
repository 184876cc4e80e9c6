#pragma once
#include <geometry_msgs/TransformStamped.h>
#include <measuring_machine/CorrectedContact.h>
#include <measuring_machine/ProbeContact.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "calibration_file/calibration.h"
#include "compensation/compensator.h"

namespace mm {

// What the compensation found, as messages. SI.

/// @param parent, child frame names.
geometry_msgs::TransformStamped toTransform(const ProbePose& pose, const ros::Time& stamp,
                                            const std::string& parent, const std::string& child);

/// The covariance is that of the calibration's parameters and of the repeatability of one contact together.
measuring_machine::CorrectedContact toContactMessage(const measuring_machine::ProbeContact& contact,
                                                     const Correction& correction,
                                                     const Calibration& calibration);

/// For rviz: an arrow from the nominal position of the tip to the corrected one, a thousand times as long,
/// and its components in words. @param frame of the workpiece.
visualization_msgs::MarkerArray correctionMarkers(const Correction& correction, const std::string& frame);

}  // namespace mm
