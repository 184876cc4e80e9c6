#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <optional>

#include "base/error.h"
#include "calibration_file/calibration_yaml.h"
#include "report/verify_json.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "tools/store_options.h"
#include "verification/verify.h"
#include "verification/verify_words.h"

namespace mm {
namespace {

struct VerifyCommand : SessionAndCalibration {
  bool loaded = false, rollBack = false;
  std::string exported;  // folder
  StoreOptions store;
};

/// What was active before becomes active again where this calibration does not help. @return in words.
std::string takenBack(const VerifyCommand& c, const Calibration& calibration, const Verification& found) {
  const std::string kept = whyKept(found);
  if (!kept.empty()) return kept;
  CalibrationStore store = c.store.storeFor(calibration);
  if (store.linked("active") != calibration.id)
    return "calibration " + calibration.id + " is not the active calibration in " + store.folder().string() +
           ", so nothing is rolled back";
  const std::string before = store.rollback();
  return "rolled back: " + before + " is active again in " + store.folder().string();
}

int runVerify(const VerifyCommand& c) {
  VerifyOptions options;
  options.loaded = c.loaded;
  options.calibrate = c.fit.checked();
  const Calibration calibration = loadCalibration(c.calibration);
  if (!c.exported.empty()) options.exported = std::make_shared<const LoadedExport>(c.exported, calibration);
  const Session session = loadSession(c.bags.joined(), calibration, c.fit.space);
  if (const std::string why = whyNotFresh(calibration, session); !why.empty())
    std::cerr << "mm: warning: " << c.bags.joined() << ": " << why << std::endl;
  std::optional<Verification> found;
  {
    ProgressBar bar("verifying");
    options.calibrate.progress = [&](const std::string& stage, double share) { bar.show(share, stage); };
    found = verify(session, calibration, options);
  }
  std::cout << (c.json ? verifyJson(*found) + "\n" : verifyText(*found));
  std::string lost;
  try {
    lost = keepAnswer(c.store.storeFor(calibration), calibration, session, *found);
  } catch (const InputError& e) {
    lost = std::string("the verdict is not stored: ") + e.what();
  }
  if (!lost.empty()) std::cerr << "mm: warning: " << lost << std::endl;
  if (found->verdict == VerifyVerdict::kHelped) return kDone;
  if (c.rollBack) std::cerr << "mm: " << takenBack(c, calibration, *found) << std::endl;
  return kAnswerIsNo;
}

}  // namespace

void addVerifyCommand(CLI::App& app, int& exitStatus) {
  auto c = std::make_shared<VerifyCommand>();
  CLI::App* command =
      app.add_subcommand("verify", "Verify with a few fresh points whether the correction helps");
  c->declare(*command, "the fresh session: ten places not used for the calibration are enough");
  command->add_flag("--loaded", c->loaded, "the controller's compensation was active during the session");
  command->add_option("--export", c->exported,
                      "the folder of mm export whose tables were loaded (with --loaded): errors that they "
                      "cannot carry are not judged");
  command->add_flag("--roll-back", c->rollBack,
                    "if the correction does not help, make the previously active calibration active again");
  c->store.declare(*command);
  c->fit.declare(*command, false);
  command->footer(
      "The calibration is not refitted. With --loaded the readings should have no error; without it they "
      "are\n"
      "uncorrected, and the correction should remove their error. The verdict names a table that is not "
      "loaded, has\n"
      "the wrong sign or belongs to another axis, and what has changed since the calibration. If the "
      "calibration is\n"
      "in the store, the verdict is stored with it and appears on its certificate.\n"
      "Examples:\n"
      "  mm plan verify plan.yaml --calibration c.yaml -o verify.yaml\n"
      "  mm verify fresh.bag --calibration c.yaml --loaded --export for_linuxcnc\n"
      "  mm verify fresh.bag --calibration c.yaml --roll-back");
  command->callback([c, &exitStatus] { exitStatus = runVerify(*c); });
}

}  // namespace mm
