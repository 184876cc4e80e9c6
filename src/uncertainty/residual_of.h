#pragma once
#include <functional>

#include "estimation/calibrate.h"

namespace mm {

/// Residual of a component of an observation, m or rad; NaN: it has none. Components are x, y, z of a
/// position, the joint of a deviation, 0 of a length.
using ResidualOf = std::function<double(int observation, int component)>;

/// What a fitted model leaves. @param fitted must outlive it.
ResidualOf residualsOf(const CalibrationResult& fitted);

}  // namespace mm
