#include "verification/kept_answer.h"

#include "base/error.h"

namespace mm {

std::string keepAnswer(const CalibrationStore& store, const Calibration& calibration, const Session& session,
                       const Verification& found) {
  try {
    if (calibration.id.empty() || !store.keeps(calibration.id)) return {};
    CalibrationStore::Verified answer;
    answer.id = calibration.id;
    answer.verdict = nameOf(found.verdict);
    answer.before = found.before.rms;
    answer.after = found.after.rms;
    answer.beforeStd = found.before.std;
    answer.afterStd = found.after.std;
    answer.angular = found.angular;
    answer.points = found.observations;
    answer.session = session.source;
    store.note(answer);
    return {};
  } catch (const InputError& e) {
    return std::string("the answer is not kept with the calibration: ") + e.what();
  }
}

}  // namespace mm
