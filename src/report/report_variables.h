#pragma once
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "estimation/calibrate.h"
#include "estimation/noise_rows.h"

namespace mm {

/// The residual of one row as a deviation along a direction, measured minus model: how much further than the
/// model says the probe went, whatever measured it (a contact on a ball, an instrument). Not finite where the
/// row tells little of this direction. @param factor of the row, and `largest` amount of the factors of all
/// (Directions).
double residualAlong(double residual, double factor, double largest);

/// Takes out the directions that no row tells of but by rounding: a residual along them would be of any size.
void dropUnmeasured(Directions& directions);

/// The mean residual in one bin of a variable, as a deviation along the variable's direction, and its
/// standard error. In um (arcsec for angular sessions).
struct VariableBin {
  double at = 0.0;  // mean of the variable in the bin, in its unit; the level's number for a category
  double mean = 0.0, standardError = 0.0;
  double meanImproved = kNotMeasured;  // the same with the named effects added
  int count = 0;
};

/// The residual, measured minus model, against one variable, along the direction in which the variable
/// explains most of it.
struct VariableView {
  std::string name;  // as in Diagnosis::where
  std::string unit;  // mm, deg, s, degC …; empty: none
  bool category = false;
  std::vector<std::string> labels;  // of a category's levels
  std::string direction;            // x, y, z, a joint, or approach
  double share = 0.0, pValue = 1.0;
  std::vector<VariableBin> bins;
  std::vector<double> x, y;  // single measurements, evenly thinned; y in um (arcsec)
  int observations = 0;      // rows behind the bins
};

/// @param fitted is linearised at its solution. @param improved the fit with the named effects added, or
/// null: used where its rows are the same. @param where shares and p-values; the views come in its order.
std::vector<VariableView> residualsByVariable(const CalibrationResult& fitted,
                                              const CalibrationResult* improved,
                                              const std::vector<WhereItFails>& where);

}  // namespace mm
