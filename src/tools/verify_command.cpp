#include <iostream>
#include <memory>

#include "base/error.h"
#include "calibration_file/calibration_yaml.h"
#include "report/blind_page.h"
#include "report/verify_json.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "tools/store_options.h"
#include "verification/blind_trial.h"
#include "verification/verify.h"
#include "verification/verify_words.h"

namespace mm {
namespace {

struct VerifyCommand : SessionAndCalibration {
  bool loaded = false, rollBack = false;
  std::string exported;     // folder
  std::string blind, page;  // the key of a blind trial; what is written of it
  OutputFiles files;
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

/// A session of the same machine. Warns where the calibration was made of it.
Session freshSession(const VerifyCommand& c, const Calibration& calibration) {
  Session session = loadSession(c.bags.joined(), calibration, c.fit.space);
  if (const std::string why = whyNotFresh(calibration, session); !why.empty())
    warn(c.bags.joined() + ": " + why);
  return session;
}

/// The states are compared before the key is read.
int runBlind(VerifyCommand& c) {
  if (c.loaded || !c.exported.empty() || c.rollBack)
    throw InputError("--blind judges both states of the controller: omit --loaded, --export and --roll-back");
  c.files.input({c.blind, c.calibration});
  c.files.output("-o", c.page, FileKind::kPage);
  c.files.check();
  BlindReport report;
  CalibrateOptions options = c.fit.checked();
  const Calibration calibration = loadCalibration(c.calibration);
  const Session session = freshSession(c, calibration);
  report.blocks = withBar("comparing", options, [&] { return trialBlocks(session, calibration, options); });
  report.labelled = compareStates(report.blocks.blocks);
  const TrialKey key = loadKey(c.blind);
  checkKey(key, session.placements, c.bags.joined(), c.blind);
  report.on = key.on;
  report.opened = opened(report.labelled, key.on, report.blocks.angular);
  report.session = c.bags.joined();
  report.calibration = c.calibration;
  std::cout << (c.json ? blindJson(report) + "\n" : blindText(report));
  if (!c.page.empty()) {
    c.files.write(c.page, blindPage(report));
    if (!c.json) std::cout << "written to " << c.page << '\n';
  }
  return report.opened.verdict == TrialVerdict::kHelped ? kDone : kAnswerIsNo;
}

int runVerify(VerifyCommand& c) {
  if (!c.blind.empty()) return runBlind(c);
  if (!c.page.empty()) throw InputError("-o is the page of a blind trial; add --blind KEY");
  VerifyOptions options;
  options.loaded = c.loaded;
  options.calibrate = c.fit.checked();
  const Calibration calibration = loadCalibration(c.calibration);
  if (!c.exported.empty()) options.exported = std::make_shared<const LoadedExport>(c.exported, calibration);
  const Session session = freshSession(c, calibration);
  const Verification found =
      withBar("verifying", options.calibrate, [&] { return verify(session, calibration, options); });
  std::cout << (c.json ? verifyJson(found) + "\n" : verifyText(found));
  std::string lost;
  try {
    lost = keepAnswer(c.store.storeFor(calibration), calibration, session, found);
  } catch (const InputError& e) {
    lost = std::string("the verdict is not stored: ") + e.what();
  }
  warn(lost);
  if (found.verdict == VerifyVerdict::kHelped) return kDone;
  if (c.rollBack) say(takenBack(c, calibration, found));
  return kAnswerIsNo;
}

}  // namespace

void addVerifyCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<VerifyCommand>(
      app, exitStatus, runVerify, "verify", "Verify with a few fresh points whether the correction helps");
  c.declare(command, "the fresh session: ten places not used for the calibration are enough");
  command.add_flag("--loaded", c.loaded, "the controller's compensation was active during the session");
  command.add_option("--export", c.exported,
                     "the folder of mm export whose tables were loaded (with --loaded): errors that they "
                     "cannot carry are not judged");
  command.add_flag("--roll-back", c.rollBack,
                   "if the correction does not help, make the previously active calibration active again");
  command.add_option("--blind", c.blind,
                     "the key of a blind trial that mm plan verify --blind planned: compare its blocks with "
                     "the correction on and off");
  command.add_option("-o,--output", c.page, "also write an HTML page (with --blind)");
  c.files.declare(command);
  c.store.declare(command);
  c.fit.declare(command, false);
  command.footer(
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
      "  mm verify fresh.bag --calibration c.yaml --roll-back\n"
      "  mm verify trial.bag --calibration c.yaml --blind trial.key.yaml -o trial.html");
}

}  // namespace mm
