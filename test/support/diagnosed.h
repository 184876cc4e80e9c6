#pragma once
#include <vector>

#include "diagnosis/diagnose.h"
#include "fitted_model.h"

namespace mm::test {

/// What a model of these effects misses of a session.
inline Diagnosis diagnosed(const Session& session, const std::vector<EffectSpec>& model = {}) {
  return diagnose(session, modelOf(session, model), {});
}

}  // namespace mm::test
