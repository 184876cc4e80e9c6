#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "uncertainty/measurement_task.h"

namespace mm {

// Where a shape is touched. Lengths in m, frame workpiece.

/// Directions from the centre of a ball to the points of its upper half: 25 as ISO 10360-5 recommends (pole;
/// 4 at 22.5 degrees from it, 8 at 45, 4 at 67.5, 8 at the equator, each ring turned by 22.5 degrees against
/// the one before), any other number in equal areas along a spiral. Pole: +z. Unit vectors.
std::vector<Eigen::Vector3d> ballDirections(int count);

/// Contacts on a ball, from outside.
std::vector<TaskPoint> ballPoints(const Eigen::Vector3d& centre, double radius, int count);
/// Contacts on a ring about a normal (unit), from outside, equally spaced.
std::vector<TaskPoint> ringPoints(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double radius,
                                  int count);
/// Contacts on a square about its centre, in rows; count is rounded up to a square number.
std::vector<TaskPoint> squarePoints(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double side,
                                    int count);
/// Contacts on a line, equally spaced, ends included.
std::vector<TaskPoint> linePoints(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                  const Eigen::Vector3d& normal, int count);
/// Their places.
std::vector<Eigen::Vector3d> placesOf(const std::vector<TaskPoint>& points);

/// The tasks of the standards. @throw InputError: the calibrated volume is too small, or has no such axis.
MeasurementTask lengthTestTask(const Model& model, const std::optional<PermissibleError>& permissible);
/// @param targets 0: five.
MeasurementTask positioningTask(const std::string& axis, int targets, const Model& model);

/// Radius of the balls that were calibrated with, m; without any 10 mm, at most a quarter of the smallest
/// side of the calibrated volume that has one.
double usualBallRadius(const Domain& domain);

}  // namespace mm
