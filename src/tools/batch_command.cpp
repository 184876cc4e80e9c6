#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/format.h"
#include "base/json_text.h"
#include "fleet/fleet_database.h"
#include "fleet/manifest.h"
#include "fleet/snakemake.h"
#include "tools/batch_result.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/one_line.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

using Clock = std::chrono::steady_clock;

struct BatchCommand {
  std::string manifest, output;
  EngineOptions engine;
  bool again = false, json = false, result = false;
};

/// What a run did.
struct BatchSummary {
  std::size_t jobs = 0, before = 0, done = 0, failed = 0, left = 0;  // before: finished by an earlier run
  bool stopped = false;                                              // by Ctrl-C
  double seconds = 0.0;
  std::string complaint;          // of Snakemake
  std::vector<std::string> whys;  // a line a failed job
};

/// The manifest's jobs that wait, and the tables that take those that end.
class Bookkeeping {
 public:
  Bookkeeping(const Manifest& manifest, const ResultsFolder& results, bool again)
      : results_(results), tables_(results.database(), Database::Use::kWrite) {
    const std::set<std::string> entered = tables_.plan(manifest.jobs);
    std::vector<JobResult> toEnter;
    for (const BatchJob& job : manifest.jobs) {
      sources_[job.key] = job.source + ": " + job.bag.string();
      std::optional<JobResult> result = resultOf(job.key);
      if (result && result->status == "failed" && (again || result->again)) {
        tables_.takeOut(job.key);
        results.forget(job.key);
        result.reset();
      }
      if (!result) {
        if (entered.count(job.key) > 0) tables_.takeOut(job.key);  // its folder was removed
        waiting_.insert(job.key);
        toDo_.push_back(job);
        continue;
      }
      ++summary_.before;
      if (result->status == "failed") note(*result);
      if (entered.count(job.key) == 0) toEnter.push_back(*result);
    }
    tables_.enter(toEnter, results);
    summary_.jobs = manifest.jobs.size();
  }

  const std::vector<BatchJob>& toDo() const { return toDo_; }
  BatchSummary& summary() { return summary_; }

  /// Enters what has ended since it was asked last.
  void collect() {
    std::vector<JobResult> ended;
    for (auto at = waiting_.begin(); at != waiting_.end();) {
      const std::optional<JobResult> result = resultOf(*at);
      if (result) ended.push_back(*result);
      at = result ? waiting_.erase(at) : std::next(at);
    }
    summary_.left = waiting_.size();
    if (ended.empty()) return;
    tables_.enter(ended, results_);
    for (const JobResult& r : ended) {
      ++(r.status == "done" ? summary_.done : summary_.failed);
      if (r.status != "done") note(r);
    }
  }

 private:
  std::optional<JobResult> resultOf(const std::string& key) const {
    const std::optional<std::string> text = results_.result(key);
    if (!text) return std::nullopt;
    return parseResult(*text, (results_.jobFolder(key) / "result.json").string());
  }
  void note(const JobResult& r) { summary_.whys.push_back(sources_[r.key] + ": " + r.failed + ": " + r.why); }

  const ResultsFolder& results_;
  FleetDatabase tables_;
  std::map<std::string, std::string> sources_;
  std::set<std::string> waiting_;
  std::vector<BatchJob> toDo_;
  BatchSummary summary_;
};

std::string note(const BatchSummary& s, double seconds) {
  const std::size_t ended = s.done + s.failed;
  std::string text = format("%zu of %zu jobs, %zu failed", s.before + ended, s.jobs, s.failed);
  if (ended > 0 && seconds > 0.0) text += format(", %.1f a second", static_cast<double>(ended) / seconds);
  return text;
}

/// Does what a manifest asks for and is not done yet, and enters it in the tables. Killed at any moment, the
/// next run goes on where it was. @param again failed jobs, too, are done again. @throw InputError.
BatchSummary runBatch(const Manifest& manifest, const ResultsFolder& results, const EngineOptions& options,
                      bool again) {
  results.prepare();
  const ResultsLock lock(results);
  Snakemake snakemake(options, results);
  results.clearWork();
  Bookkeeping books(manifest, results, again);
  BatchSummary& summary = books.summary();
  const auto begun = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
  if (!books.toDo().empty()) {
    std::error_code failed;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", failed);
    if (failed) throw InputError("/proc/self/exe: cannot be read; is /proc mounted?");
    snakemake.start(books.toDo(), self.string());
    ProgressBar bar("batch");
    while (snakemake.running() && !Interrupt::asked()) {
      const auto asked = Clock::now();
      books.collect();
      bar.show(1.0 - static_cast<double>(summary.left) / static_cast<double>(summary.jobs),
               note(summary, seconds()));
      // of thousands of jobs on a slow disk at most half of the time is for looking
      std::this_thread::sleep_for(
          std::max<Clock::duration>(std::chrono::milliseconds(50), Clock::now() - asked));
    }
    summary.stopped = snakemake.running();
    summary.complaint = snakemake.complaint();
    try {
      if (summary.stopped) snakemake.stop();
    } catch (const InputError& e) {
      summary.complaint = e.what();
    }
    books.collect();
    results.clearWork();
  }
  summary.seconds = seconds();
  return summary;
}

constexpr std::size_t kWhysPrinted = 20;

void print(const BatchSummary& s, const BatchCommand& c) {
  for (std::size_t i = 0; i < std::min(s.whys.size(), kWhysPrinted); ++i) say("failed: " + s.whys[i]);
  if (s.whys.size() > kWhysPrinted)
    say("failed: " + std::to_string(s.whys.size() - kWhysPrinted) + " more; mm fleet " + c.output +
        " lists them");
  if (!s.complaint.empty()) warn("snakemake: " + s.complaint);
  if (s.left > 0 && !s.stopped)
    say(std::to_string(s.left) + " jobs were not done; " + c.output +
        "/batch.log says why; run the same command again");
  if (c.json) {
    std::cout << jsonText({{"folder", c.output},
                           {"jobs", s.jobs},
                           {"done_before", s.before},
                           {"done", s.done},
                           {"failed", s.failed},
                           {"left", s.left},
                           {"stopped", s.stopped},
                           {"seconds", s.seconds},
                           {"why", s.whys}})
              << '\n';
    return;
  }
  std::cout << s.jobs << " jobs: " << s.before << " finished before, " << s.done << " done";
  if (s.failed > 0) std::cout << ", " << s.failed << " failed";
  if (s.left > 0) std::cout << ", " << s.left << " left";
  std::cout << "; " << std::max<std::size_t>(1, static_cast<std::size_t>(s.seconds + 0.5)) << " s\nmm fleet "
            << c.output << " summarises them\n";
}

int run(const BatchCommand& c) {
  if (c.result) return writeBatchResult();
  if (c.manifest.empty() || c.output.empty())
    throw InputError("a manifest and -o are required; see mm batch --help");
  const Manifest manifest = loadManifest(c.manifest);
  warn(manifest.remarks);
  const BatchSummary s = runBatch(manifest, ResultsFolder(c.output), c.engine, c.again);
  print(s, c);
  if (s.stopped) {
    say("stopped by Ctrl-C; finished jobs are kept, run the same command to continue");
    return kStopped;
  }
  return s.whys.empty() && s.left == 0 ? kDone : kAnswerIsNo;
}

}  // namespace

void addBatchCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<BatchCommand>(app, exitStatus, run, "batch",
                                               "Process many sessions: run each job of a manifest once");
  command.add_option("manifest", c.manifest, "YAML: sessions, models, steps");
  command.add_option("-o,--output", c.output, "the folder of results; finished jobs in it are kept");
  standardOption(command, "--engine", c.engine.engine, CLI::IsMember({"local", "slurm"}),
                 "where jobs run: local (this computer) or slurm");
  command
      .add_option("--profile", c.engine.profile, "Snakemake profile, for another cluster or other options")
      ->excludes(command.get_option("--engine"));
  standardOption(command, "--jobs", c.engine.jobs, wholeNumberWithin(0, 100'000),
                 "jobs at a time; 0: one per core of this computer, 100 with Slurm, or the number in the "
                 "profile");
  standardOption(command, "--limit", c.engine.limit, wholeNumberWithin(1, 10'000'000),
                 "time limit of one step, s");
  command.add_flag("--again", c.again, "run failed jobs again");
  command.add_flag("--json", c.json, "print the counts as JSON on standard output");
  command.add_flag("--result", c.result, "ends a job in the current folder: for Snakemake")->group("");
  command.footer(
      "A finished job is never run again, even if the batch is interrupted. A failed job does not stop the "
      "others\n"
      "and reports its reason. Exit status 1: a job failed.\n"
      "Examples:\n"
      "  mm batch manifest.yaml -o results\n"
      "  mm batch manifest.yaml -o results --engine slurm --jobs 64");
}

}  // namespace mm
