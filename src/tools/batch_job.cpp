#include "tools/batch_job.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/number_text.h"
#include "base/utc_now.h"
#include "base/version.h"
#include "calibration_file/atomic_file.h"
#include "fleet/child_process.h"
#include "fleet/engine.h"
#include "machine/machine_fit.h"
#include "model/model_spec.h"
#include "ros_bridge/bag_session.h"
#include "session/session_hash.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCalibrationFile = "calibration.yaml";
constexpr const char* kAddedFile = "added.yaml";

/// The calibration that the steps after calibrate judge by.
fs::path calibrationFor(const BatchJob& job, const fs::path& folder) {
  if (job.does("calibrate")) return folder / kCalibrationFile;
  return job.calibration;
}

/// The line that would be typed for a step, after `mm`.
std::vector<std::string> wordsOf(const std::string& step, const BatchJob& job, const fs::path& folder) {
  const std::string bag = job.bag.string();
  std::vector<std::string> words{step == "add_all" ? "add" : step, bag};
  const auto add = [&](std::initializer_list<std::string> more) { words.insert(words.end(), more); };
  const bool fits = step != "check" && step != "verify";
  if (step == "check" && !job.model.empty()) add({"--model", job.model.string()});
  if (step == "calibrate")
    add({"--model", job.model.string(), "-o", (folder / kCalibrationFile).string(), "--method", job.method});
  if (step == "diagnose" || step == "add_all") add({"--calibration", calibrationFor(job, folder).string()});
  if (step == "add_all") add({"--all", "-o", (folder / kAddedFile).string()});
  if (step == "verify") add({"--calibration", job.calibration.string()});
  if (step == "verify" && job.loaded) add({"--loaded"});
  if (step == "report") {
    const fs::path added = folder / kAddedFile;
    add({"--calibration", (fs::exists(added) ? added : calibrationFor(job, folder)).string(), "-o",
         (folder / "report.html").string()});
    if (!job.serial.empty()) add({"--serial", job.serial});
  } else {
    add({"--json"});
  }
  if (fits) add({"--seed", std::to_string(job.seed), "--threads", "1"});
  if (fits && job.repeatability > 0.0) add({"--repeatability-um", numberText(job.repeatability)});
  if (!job.space.empty()) add({"--namespace", job.space});
  return words;
}

/// What a step must leave, or it has failed, whatever its exit status.
fs::path productOf(const std::string& step, const fs::path& folder) {
  if (step == "calibrate") return folder / kCalibrationFile;
  if (step == "add_all") return folder / kAddedFile;
  if (step == "report") return folder / "report.html";
  return folder / (step + ".json");
}

/// What the tables want of the session itself: a step of its own that is not typed.
int describeSession(const BatchJob& job, const fs::path& file) {
  std::optional<Machine> machine;
  if (!job.model.empty()) {
    const ModelSpec model = loadModelSpec(job.model.string());
    if (!model.machine.empty()) machine = Machine::load(model.machine, job.model.parent_path());
  }
  const Session session =
      readSessionBag(job.bag, {}, machine ? &*machine : nullptr, {job.space, !job.space.empty()});
  JobResult about;
  about.epoch = session.epoch;
  about.serial = serialOf(session.machine);
  about.machineName = session.machine.name();
  about.sessionHash = sessionHash(session);
  about.observations = static_cast<long>(session.observations.size());
  about.sensors = sensorHealth(session);
  writeFileAtomically(file, resultText(about));
  return kDone;
}

/// Whether a step says that the disk failed it, which is not the input's fault.
bool ofTheDisk(const std::string& said) {
  const std::vector<std::string> words = {std::strerror(ENOSPC), std::strerror(EIO), "is the disk full?",
                                          "the disk reports an error"};
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& w) { return said.find(w) != std::string::npos; });
}

/// One job: its steps, each in a process of its own, and what they found.
class JobRun {
 public:
  JobRun(const BatchJob& job, fs::path folder, MmProgram program, int limit)
      : job_(job), folder_(std::move(folder)), program_(program), limit_(limit) {
    result_.key = job.key;
    result_.software = kVersion;
    result_.status = "done";
  }

  void run() {
    const std::string begun = utcNow();
    if (keyOf(job_) != job_.key)
      return fail("inputs", "a file changed while the batch ran; run it again", true);
    describe();
    for (const std::string& step : job_.steps)
      if (good() && !Interrupt::asked()) doStep(step);
    if (Interrupt::asked()) return;
    if (good()) readStepFiles(folder_, job_, result_);
    seconds_["started"] = begun;
    writeText("run.json", seconds_.dump(1) + "\n");
  }
  const JobResult& result() const { return result_; }
  void fail(const std::string& step, const std::string& why, bool again) {
    result_.status = "failed";
    result_.failed = step;
    result_.why = why;
    result_.again = again;
  }

 private:
  bool good() const { return result_.status == "done"; }
  void writeText(const char* name, const std::string& text) const {
    writeFileAtomically(folder_ / name, text);
  }

  void describe() {
    const fs::path file = folder_ / "session.json", log = folder_ / "session.log";
    const StepEnd end = inProcessOfItsOwn([&] { return describeSession(job_, file); }, log, log, limit_);
    if (!judged("session", end, file, log)) return;
    const JobResult about = parseResult(readFile(file), file.string());
    result_.epoch = about.epoch;
    result_.serial = about.serial;
    result_.machineName = about.machineName;
    result_.sessionHash = about.sessionHash;
    result_.observations = about.observations;
    result_.sensors = about.sensors;
  }

  void doStep(const std::string& step) {
    const fs::path out = folder_ / (step + (step == "report" ? ".txt" : ".json")),
                   log = folder_ / (step + ".log");
    const StepEnd end = runStep(program_, wordsOf(step, job_, folder_), out, log, limit_);
    judged(step, end, productOf(step, folder_), log);
  }

  /// Notes how a step ended; a log that says nothing is removed.
  bool judged(const std::string& step, const StepEnd& end, const fs::path& product, const fs::path& log) {
    seconds_["seconds"][step] = end.seconds;
    std::error_code ignored;
    const bool left = fs::is_regular_file(product, ignored) && fs::file_size(product, ignored) > 0;
    const std::string said = lastWordsOf(log);
    if (said.empty()) fs::remove(log, ignored);
    if (Interrupt::asked()) return false;
    if (end.timedOut)
      fail(step, "took longer than " + std::to_string(limit_) + " s (--limit)", true);
    else if (end.status > kSignalled)
      fail(step,
           "ended by signal " + std::to_string(end.status - kSignalled) + " (" +
               strsignal(end.status - kSignalled) + ")",
           true);
    else if (end.status > kAnswerIsNo || !left)
      fail(step, said.empty() ? "exit status " + std::to_string(end.status) + ", and nothing was said" : said,
           ofTheDisk(said));
    return good();
  }

  static constexpr int kSignalled = 128;
  const BatchJob& job_;
  fs::path folder_;
  MmProgram program_;
  int limit_;
  JobResult result_;
  nlohmann::ordered_json seconds_;
};

/// @return false: Ctrl-C came, and nothing of the job is kept.
bool doJob(const BatchJob& job, const ResultsFolder& results, MmProgram program, int limit) {
  const fs::path folder = results.begin(job.key);
  JobRun run(job, folder, program, limit);
  try {
    run.run();
  } catch (const std::exception& e) {
    run.fail("results", e.what(), true);
  }
  if (Interrupt::asked()) {
    fs::remove_all(folder);
    return false;
  }
  writeFileAtomically(folder / "result.json", resultText(run.result()));
  results.finish(folder, job.key);
  return true;
}

}  // namespace

int doChunk(const fs::path& file, MmProgram program, int limit) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // whoever runs the chunks and is killed takes them with it
  const ChunkToDo todo = readChunk(file);
  const ResultsFolder results(todo.folder);
  const int ended = ::open(todo.chunk.ended.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  std::string unwritten;
  for (const BatchJob& job : todo.chunk.jobs) {
    try {
      if (!results.finished(job.key) && !doJob(job, results, program, limit)) return kStopped;
    } catch (const std::exception& e) {  // the others' places may be writable
      unwritten = e.what();
    }
    const std::string line = job.key + "\n";
    if (ended >= 0 && ::write(ended, line.data(), line.size()) < 0) continue;  // found in its folder then
  }
  if (ended >= 0) ::close(ended);
  if (!unwritten.empty()) throw InputError(unwritten);
  return kDone;
}

}  // namespace mm
