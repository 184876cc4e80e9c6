#pragma once
#include <vector>

#include "estimation/calibrate.h"
#include "model/observed_domain.h"

namespace mm::test {

/// A model over what a session covers.
inline Model modelOf(const Session& session, const std::vector<EffectSpec>& effects = {}) {
  return {session.machine, observedDomain(session), effects};
}

/// Its parameters by least squares.
inline CalibrationResult fitted(const Session& session, const std::vector<EffectSpec>& effects = {},
                                bool rejectOutliers = true) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.rejectOutliers = rejectOutliers;
  return calibrate(session, modelOf(session, effects), options);
}

}  // namespace mm::test
