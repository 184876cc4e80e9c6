#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <measuring_machine/AddEffect.h>
#include <measuring_machine/Calibrate.h>
#include <measuring_machine/CalibrateAction.h>
#include <measuring_machine/Cancel.h>
#include <measuring_machine/Compare.h>
#include <measuring_machine/Diagnose.h>
#include <measuring_machine/DiagnoseAction.h>
#include <measuring_machine/Promote.h>
#include <measuring_machine/RemoveEffect.h>
#include <measuring_machine/Rollback.h>
#include <measuring_machine/Verify.h>
#include <ros/ros.h>

#include <memory>
#include <string>

#include "calibration_file/calibration_store.h"
#include "diagnosis/diagnose.h"
#include "machine/machine.h"
#include "nodes/job_action.h"
#include "ros_bridge/live_session.h"
#include "workflow/job.h"
#include "workflow/recalibration.h"

namespace mm {

/// The loop measure, calibrate, compare, diagnose, add, as services with the JSON of `mm`; `~calibrate` and
/// `~diagnose` are actions as well. One long call at a time, each in the thread of its caller; everything
/// else goes on. Services are under `~`; topics `~progress`, `~ledger`, `~residuals`, `~changed` (id made
/// active). An answer's message says what of the session was lost or set aside. Calibrations of other
/// machines are not promoted. Parameters: `store`, `threads`, `residual_scale` (of the arrows; 0: by their
/// size), `frame_prefix`. Needs several threads.
class CalibrationServer {
 public:
  CalibrationServer(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine);

 private:
  using SessionPtr = std::shared_ptr<const Session>;
  using Change = Recalibration (*)(const Session&, const Calibration&, const EffectSpec&,
                                   const CalibrateOptions&);
  using Activation = std::string (CalibrationStore::*)(const std::string&, const CalibrationStore::Check&);
  /// A service whose work is the job's task of the same name.
  template <typename Service, typename Work>
  void offerTask(const std::string& name, Work work);
  void cancel(measuring_machine::Cancel::Response& response);

  // What services and actions do, within the job: a request or goal in, a response or result out.
  void compare(const measuring_machine::Compare::Request& request,
               measuring_machine::Compare::Response& response);
  void verify(const measuring_machine::Verify::Request& request,
              measuring_machine::Verify::Response& response);
  template <typename Asked, typename Answer>
  void calibrateSession(const Asked& asked, Answer& answer);
  template <typename Asked, typename Answer>
  void diagnoseSession(const Asked& asked, Answer& answer);
  template <typename Response>
  void change(const std::string& effect, Change change, Response& response);
  SessionPtr openSession(const std::string& bag, const Machine& fallback);
  SessionPtr sessionOf(const Calibration& calibration);
  ModelSpec modelFrom(const std::string& model, const Session& session) const;
  Calibration calibrationFrom(const std::string& idOrPath) const;
  CalibrateOptions options();
  /// Keeps the result as candidate and shows it. @return its id; `success` and `message` say what it is
  /// worth.
  std::string keep(Recalibration& done, const Session& session, std::uint8_t& success, std::string& message);
  /// The call that follows, as it is typed. It goes to the log too: rosservice breaks and escapes what it
  /// prints.
  std::string nextCall(const std::string& service, const std::string& request) const;
  std::string nextAfter(const Diagnosis& diagnosis, const Calibration& of) const;
  /// Promotes a calibration of this machine, or rolls back to one. @return what is active, as the other nodes
  /// are told. @throw InputError: it is of another machine.
  std::string activate(Activation how, const std::string& id);
  /// Makes active again what was active before `id`. @param done false: it was asked in vain. @return in
  /// words what became of it.
  std::string takenBack(const std::string& id, bool& done);
  void diagnoseNode(diagnostic_updater::DiagnosticStatusWrapper& status);
  void publishProgress(const Job::State& state);

  ros::NodeHandle own_;
  Machine machine_;
  CalibrationStore store_;
  unsigned threads_;
  double residualScale_;
  std::string prefix_;
  LiveSession live_;
  Job job_;
  SessionPtr last_;        // of the last long call; only the running job touches it
  std::string lastSpace_;  // the namespace that it was measured in
  std::string lastBag_;    // as it was asked for; empty: live
  ros::Publisher progressOut_, ledgerOut_, residualsOut_, verdictOut_, changedOut_;
  std::vector<ros::ServiceServer> services_;
  JobAction<measuring_machine::CalibrateAction> calibrateAction_;
  JobAction<measuring_machine::DiagnoseAction> diagnoseAction_;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace mm
