#pragma once
#include <Eigen/Core>

#include "estimation/calibrate.h"

namespace mm {

/// The residual of an observation as an arrow (m, workpiece): from where the surface or the target is to
/// where the machine found it, the sign of an error of indication (VIM 2.16; docs/signs.md). That is the
/// residual of a contact along `normal`, and the opposite of measured minus model of an instrument.
/// Components that were not measured, and angular ones, are zero. @param normal outward unit normal of the
/// touched ball, or unit vector along a length.
Eigen::Vector3d residualVector(const CalibrationResult& fit, int observation, const Eigen::Vector3d& normal);

}  // namespace mm
