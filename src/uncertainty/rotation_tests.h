#pragma once
#include <string>
#include <vector>

#include "uncertainty/residual_of.h"

namespace mm {

/// Error motions of an axis of rotation (ISO 230-7) at the positions of one circle, um: `radial` away from
/// the centre of the least-squares circle, `axial` along the axis from the plane through the positions.
struct RotationTest {
  std::string joint, setup;
  double radius = 0.0;                                           // mm, of the least-squares circle
  double turn = 0.0;                                             // rad, from the first to the last angle
  std::vector<double> angle;                                     // rad, ascending: readings of the joint
  std::vector<double> radial, axial;                             // um
  double radialError = kNotMeasured, axialError = kNotMeasured;  // um, ranges
};

/// Positions that an independent instrument measured of a point beside the axis while nothing but one rotary
/// joint turned, at twelve angles or more over 150 degrees or more. The circle's centre and plane are found
/// from the positions, so neither the place nor the tilt of the axis counts, only how it moves.
/// @param left may be empty; else the error motions are those that the model leaves: the residuals about the
/// nominal circle.
std::vector<RotationTest> rotationTests(const Session& session, const ResidualOf& left = {});

/// "ISO 230-7, axis of rotation c: 72 readings over 360 deg".
std::string inWords(const RotationTest& test);

}  // namespace mm
