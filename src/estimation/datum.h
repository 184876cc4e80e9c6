#pragma once
#include "estimation/calibrate.h"

namespace mm {

/// True when a law could say where the instrument's readings start: the model is the user's own formulas from
/// end to end, and there are deviations without a setup.
bool lawMayStateDatum(const Session& session, const Model& model);

/// True when the residuals of a fit with Datum::kOfTheLaw say that the instrument does not start where the
/// law does: a free zero would take more of them away than chance does.
bool contradictsDatum(const CalibrationResult& fitted);

}  // namespace mm
