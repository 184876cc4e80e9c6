#pragma once
#include <string>

#include "calibration_file/calibration_store.h"
#include "session/session.h"
#include "verification/verify.h"

namespace mm {

/// Keeps an answer where the calibration is kept, for its history and its certificate. The answer stands
/// whether or not it could be kept. @return why it could not; empty: it was, or the store has no such
/// calibration.
std::string keepAnswer(const CalibrationStore& store, const Calibration& calibration, const Session& session,
                       const Verification& found);

}  // namespace mm
