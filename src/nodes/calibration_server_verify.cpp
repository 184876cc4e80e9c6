// The service `verify` of the calibration server.
#include "base/error.h"
#include "nodes/calibration_server.h"
#include "report/verify_json.h"
#include "ros_bridge/node_support.h"
#include "session/session_summary.h"
#include "verification/verify.h"
#include "verification/verify_words.h"

namespace mm {

std::string CalibrationServer::takenBack(const std::string& id, bool& done) {
  if (store_.linked("active") != id)
    return "calibration " + id + " is not the active calibration, so nothing is rolled back";
  try {
    return "rolled back: " + rollback({}) + " is active again";
  } catch (const InputError& e) {
    done = false;
    return std::string("not rolled back: ") + e.what();
  }
}

void CalibrationServer::verify(const measuring_machine::Verify::Request& request,
                               measuring_machine::Verify::Response& response) {
  std::string name = request.calibration;
  if (name.empty()) name = store_.linked("active");
  if (name.empty())
    throw InputError("no calibration is active in " + store_.folder().string() +
                     "; promote one first, or name the calibration to verify");
  const Calibration calibration = calibrationFrom(name);
  const SessionPtr session = openSession(request.bag, Machine(calibration.urdf, calibration.machineName));
  VerifyOptions how;
  how.loaded = request.loaded != 0;
  if (!request.export_folder.empty())
    how.exported = std::make_shared<const LoadedExport>(request.export_folder, calibration);
  how.calibrate = options();
  const Verification found = mm::verify(*session, calibration, how);
  job_.step("answering", 1.0);  // a verdict that was cut short is none
  response.json = verifyJson(found);
  response.message = found.inWords;
  if (request.automatic_rollback != 0 && found.verdict != VerifyVerdict::kHelped) {
    bool done = true;
    const std::string kept = whyKept(found);
    response.message += "; " + (kept.empty() ? takenBack(calibration.id, done) : kept);
    response.success = done;
  }
  for (const std::string& more : {axesText(found), whyNotFresh(calibration, *session), lossText(*session),
                                  keepAnswer(store_, calibration, *session, found)})
    if (!more.empty()) response.message += "; " + more;
}

}  // namespace mm
