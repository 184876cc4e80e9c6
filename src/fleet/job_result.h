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
  double rms = kNone, heldOutRms = kNone, chi2PerDof = kNone, repeatability = kNone;  // um; chi2: 1
  std::vector<FleetParameter> parameters;
  std::vector<std::string> found;  // effects that the diagnosis named, or that add_all added
  bool asked = false;              // whether a diagnosis ran: then `found` may be empty and means something
  std::string verified;            // verdict of verify
  double verifiedBefore = kNone, verifiedAfter = kNone;  // um
  std::vector<SensorHealth> sensors;
};

std::string resultText(const JobResult& result);  ///< of result.json
/// Writes it, or another text of the job, so that it is complete or absent. @throw InputError naming the
/// file.
void writeJobFile(const std::filesystem::path& file, const std::string& text);
/// @param source for messages. @throw InputError: damaged.
JobResult parseResult(const std::string& text, const std::string& source);

/// Fills in what the steps left in the job's folder: calibration.yaml, diagnose.json, verify.json.
/// @throw InputError: a file is damaged.
void readStepFiles(const std::filesystem::path& folder, const BatchJob& job, JobResult& result);

/// The parameters of a calibration, in the unit of people.
std::vector<FleetParameter> parametersOf(const Calibration& calibration);

}  // namespace mm
