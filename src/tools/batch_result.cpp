#include "tools/batch_result.h"

#include <signal.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.h"
#include "base/version.h"
#include "calibration_file/atomic_file.h"
#include "fleet/child_process.h"
#include "fleet/job_result.h"
#include "machine/machine_fit.h"
#include "model/model_spec.h"
#include "ros_bridge/bag_session.h"
#include "session/session_hash.h"
#include "tools/exit_status.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr int kTookTooLong = 124;  // what `timeout` ends with
constexpr int kSignalled = 128;

/// What the tables want of the session itself.
void describeSession(const BatchJob& job, JobResult& result) {
  std::optional<Machine> machine;
  if (!job.model.empty()) {
    const ModelSpec model = loadModelSpec(job.model.string());
    if (!model.machine.empty()) machine = Machine::load(model.machine, job.model.parent_path());
  }
  const Session session =
      readSessionBag(job.bag, {}, machine ? &*machine : nullptr, {job.space, !job.space.empty()});
  result.epoch = session.epoch;
  result.serial = serialOf(session.machine);
  result.machineName = session.machine.name();
  result.sessionHash = sessionHash(session);
  result.observations = static_cast<long>(session.observations.size());
  result.sensors = sensorHealth(session);
}

/// Whether a step says that the disk failed it, which is not the input's fault.
bool ofTheDisk(const std::string& said) {
  const std::vector<std::string> words = {std::strerror(ENOSPC), std::strerror(EIO), "is the disk full?",
                                          "the disk reports an error"};
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& w) { return said.find(w) != std::string::npos; });
}

/// The step that ended last, where that is why the job failed.
void judgeSteps(JobResult& result) {
  std::istringstream steps(readFile("steps.txt"));
  std::string step;
  int status = 0;
  long milliseconds = 0;
  while (steps >> step >> status >> milliseconds) {
  }
  if (status <= kAnswerIsNo) return;
  result.status = "failed";
  result.failed = step;
  const std::string said = lastWordsOf(step + ".log");
  result.again = status == kTookTooLong || status > kSignalled || ofTheDisk(said);
  if (status == kTookTooLong)
    result.why = "took longer than " + std::to_string(milliseconds / 1000) + " s (--limit)";
  else if (status > kSignalled)
    result.why = "ended by signal " + std::to_string(status - kSignalled) + " (" +
                 strsignal(status - kSignalled) + ")";
  else
    result.why = said.empty() ? "exit status " + std::to_string(status) + ", without a message" : said;
}

JobResult judge(const BatchJob& job) {
  JobResult result;
  result.key = job.key;
  result.software = kVersion;
  result.status = "done";
  const auto fail = [&](const char* at, const std::string& why, bool again) {
    result.status = "failed";
    result.failed = at;
    result.why = why;
    result.again = again;
  };
  try {
    judgeSteps(result);
    if (!result.again && keyOf(job) != job.key)
      fail("inputs", "a file changed while the batch ran; run it again", true);
    if (result.status == "done") readStepFiles(".", job, result);
  } catch (const std::exception& e) {
    fail("results", e.what(), true);
  }
  try {
    if (!result.again) describeSession(job, result);  // what a step crashed on may crash this, too
  } catch (const std::exception& e) {
    if (result.status == "done") fail("session", e.what(), ofTheDisk(e.what()));
  }
  return result;
}

}  // namespace

int writeBatchResult() {
  const fs::path here = fs::current_path();
  const BatchJob job = jobOf(nlohmann::json::parse(readFile("job.json")));
  writeFileAtomically("result.json", resultText(judge(job)));
  ResultsFolder(here.parent_path().parent_path()).finish(job.key);
  return kDone;
}

}  // namespace mm
