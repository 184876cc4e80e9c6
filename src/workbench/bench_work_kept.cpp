// What is done with a calibration that is there: made active, judged, reported, exported; and what the page
// draws of the machine and of a plan.
#include "base/error.h"
#include "calibration_file/calibration_yaml.h"
#include "export/export_page.h"
#include "export/representability.h"
#include "report/report_page.h"
#include "report/verify_json.h"
#include "verification/verify.h"
#include "workbench/bench_work.h"
#include "workbench/plan_document.h"
#include "workbench/zip.h"

namespace mm {

CalibrationStore& BenchWork::store() {
  if (!store_) throw InputError("no session is open");
  return *store_;
}

std::string BenchWork::use(const std::string& id) {
  Calibration chosen = store().load(id);
  checkMachine(chosen, session());
  calibration_ = std::move(chosen);
  kept_ = true;
  forget({"diagnosis", "moves", "report", "export"});
  show();
  return id + " is in use";
}

std::string BenchWork::promote(const std::string& id) {
  CalibrationStore& kept = store();
  return activated(live_ != nullptr ? live_->promote(id) : kept.promote(id) + " is active");
}

std::string BenchWork::rollback(const std::string& id) {
  CalibrationStore& kept = store();
  return activated(live_ != nullptr ? live_->rollback(id) : kept.rollback(id) + " is active again");
}

/// Shows that another calibration is active now. @return the message.
std::string BenchWork::activated(std::string message) {
  forget({"verify"});  // it was said of the one that was active before
  showStore();
  return message;
}

std::string BenchWork::verify() {
  std::optional<Calibration> active;
  if (store_) active = store_->active().calibration;
  if (!active) throw InputError("no calibration is active; promote one, then measure a few fresh points");
  if (const std::string why = whyNotFresh(*active, session()); !why.empty()) throw InputError(why);
  VerifyOptions options;
  options.calibrate = this->options();
  const Verification found = mm::verify(session(), *active, options);
  documents_.put("verify", verifyJson(found));
  return found.inWords;
}

std::string BenchWork::report() {
  const ReportFiles files = loadReportFiles();
  ReportOptions options;
  options.diagnose = diagnosing(this->options());
  options.sessionPath = shownAs_;
  options.calibrationPath = calibration().id.empty() ? "calibration.yaml" : calibration().id + ".yaml";
  const ReportContents contents = makeReport(session(), calibration(), options);
  documents_.put("report", reportPage(contents, files), "text/html; charset=utf-8");
  showDiagnosis(contents.diagnosis);
  return contents.diagnosis.sentence;
}

std::string BenchWork::exportTo(const std::string& controller) {
  const ExportTarget& target = exportTarget(controller);
  Calibration whole = calibration();
  completeCalibration(whole);
  const ExportOptions options;
  const NeededCorrection needed(whole, options.letters);
  const Exported exported = exportedFor(target, needed, options);
  Representability judged = representability(
      whole, target, options, needed, exported,
      [this](const std::string& what, double share) { job_.step("exporting: " + what, share); });
  const std::vector<ExportedFile> files = exportFolderOf(whole, target, needed, exported, judged);
  const std::string folder = whole.id + "_" + target.name;
  documents_.put("export", zipOf(folder, files), "application/zip", folder + ".zip");
  const std::string done =
      folder + ".zip: " + std::to_string(files.size()) + " files, README.md first; " + judged.activeWords;
  if (!judged.carriesNothing()) return done;
  return done + "; " + target.title + " can carry nothing of this calibration: it holds " + exported.holds;
}

/// Of a running machine its own, whatever session is looked at; the meshes are those of the session's URDF.
void BenchWork::showMachine(const Machine& machine) {
  auto shown = std::make_shared<const Machine>(live_ != nullptr ? live_->machine() : machine);
  documents_.put("machine", machineDocument(*shown));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (machine_ && machine_->urdf() != shown->urdf()) documents_.remove("plan");  // it was drawn on another
    machine_ = std::move(shown);
  }
  if (machine.urdf() == drawnUrdf_ && origin_ == drawnOrigin_) return;
  drawnUrdf_ = machine.urdf();
  drawnOrigin_ = origin_;
  documents_.put("meshes", meshesDocument(drawnUrdf_, drawnOrigin_, sources_.packageFolder),
                 "application/octet-stream");
}

std::string BenchWork::lookAt(const std::string& plan) const {
  std::unique_lock<std::mutex> lock(mutex_);
  if (!machine_) throw InputError("no machine is shown, so there is nothing to draw the plan on");
  std::string drawn;
  for (std::shared_ptr<const Machine> on; on != machine_;) {  // another may be shown meanwhile
    on = machine_;
    lock.unlock();
    drawn = planDocument(plan, *on);
    lock.lock();
  }
  documents_.put("plan", std::move(drawn));
  return "the plan is drawn; nothing moves";
}

}  // namespace mm
