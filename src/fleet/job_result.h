#pragma once
#include <filesystem>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "fleet/job.h"
#include "fleet/sensor_health.h"

namespace mm {

/// One parameter of a calibration, in the unit of people.
struct FleetParameter {
  std::string effect, name, unit;  // effect: `{type: backlash, axis: x}`
  double value = 0.0, std = 0.0;   // std 0: fixed
  bool fixed = false;              // by a convention, or without influence

  /// See eachField; in the order of the JSON and of the table.
  template <class Self, class F>
  static void fields(Self& self, const F& f) {
    f("effect", self.effect);
    f("name", self.name);
    f("unit", self.unit);
    f("value", self.value);
    f("std", self.std);
    f("fixed", self.fixed);
  }
};

/// What a job found; the same bits whoever ran it, wherever and when.
struct JobResult {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string key, status;  // "done" or "failed"
  std::string failed, why;  // the step that failed, and its message
  bool again = false;       // not the input's fault (killed, time limit, disk full): the next run tries again
  std::string software, sessionHash, serial, machineName;
  double epoch = kNone;  // s, UTC: start of the session
  long observations = 0;
  std::string verdict, sentence;  // of the last diagnosis
  bool converged = true;
  bool angular = false;  // the session has angular residuals only: figures in urad
  double rms = kNone, heldOutRms = kNone, chi2PerDof = kNone, repeatability = kNone;  // um (urad); chi2: 1
  std::vector<FleetParameter> parameters;
  std::vector<std::string> found;  // effects that the diagnosis named, or that add_all added
  bool asked = false;              // whether a diagnosis ran: then `found` may be empty and means something
  std::string verified;            // verdict of verify
  double verifiedBefore = kNone, verifiedAfter = kNone;  // um
  std::vector<SensorHealth> sensors;

  /// See eachField; of all that is no list, in the order of the JSON.
  template <class Self, class F>
  static void fields(Self& self, const F& f) {
    f("key", self.key);
    f("again", self.again);
    f("serial", self.serial);
    f("machine_name", self.machineName);
    f("epoch_s", self.epoch);
    stored(self, f);
  }
  /// Those that the table `jobs` keeps under the same name.
  template <class Self, class F>
  static void stored(Self& self, const F& f) {
    f("status", self.status);
    f("failed", self.failed);
    f("why", self.why);
    f("software", self.software);
    f("session_hash", self.sessionHash);
    f("observations", self.observations);
    f("verdict", self.verdict);
    f("sentence", self.sentence);
    f("asked", self.asked);
    f("converged", self.converged);
    f("angular", self.angular);
    f("rms_um", self.rms);
    f("held_out_rms_um", self.heldOutRms);
    f("chi2_per_dof", self.chi2PerDof);
    f("repeatability_um", self.repeatability);
    f("verified", self.verified);
    f("verified_before_um", self.verifiedBefore);
    f("verified_after_um", self.verifiedAfter);
  }
};

/// Of result.json. What is not UTF-8 in it (the message of a step about a foreign file) is replaced.
std::string resultText(const JobResult& result);
/// @param source for messages. @throw InputError: damaged.
JobResult parseResult(const std::string& text, const std::string& source);

/// Fills in what the steps left in the job's folder: calibration.yaml, diagnose.json, verify.json.
/// @throw InputError: a file is damaged.
void readStepFiles(const std::filesystem::path& folder, const BatchJob& job, JobResult& result);

/// Fills in what a calibration says: figures, parameters in the unit of people, effects that were added.
void takeFigures(const Calibration& calibration, JobResult& result);

}  // namespace mm
