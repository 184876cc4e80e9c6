#pragma once
#include "compensation/compensator.h"

namespace mm {

/// A state at rest in the middle of everything that was calibrated: positions, temperatures, covariates, the
/// laser's reading. Directions of travel and the time are those of Compensator::blankState.
State middleState(const Compensator& compensator);

}  // namespace mm
