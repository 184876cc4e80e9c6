#pragma once
#include <string>
#include <vector>

#include "effects/profile.h"
#include "estimation/calibrate.h"

namespace mm {

/// A profile of one variable that the model has: its curve at the readings of the session, and what was
/// measured, which is the curve and the residual that it leaves.
struct AddedProfile {
  std::string inWords, direction, variable, variableUnit;
  ProfileCurve curve;        // ascending
  std::vector<double> x, y;  // single measurements, evenly thinned
};

/// Those of the fitted model, in its order; a profile of two variables is a map, and is left out.
std::vector<AddedProfile> addedProfiles(const CalibrationResult& fitted);

}  // namespace mm
