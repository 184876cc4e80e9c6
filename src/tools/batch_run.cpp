#include "tools/batch_run.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/format.h"
#include "fleet/fleet_database.h"
#include "tools/interrupt.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// The manifest's jobs that wait, and the tables that take those that end.
class Bookkeeping {
 public:
  Bookkeeping(const Manifest& manifest, const ResultsFolder& results, bool again)
      : results_(results), tables_(results.database(), Database::Use::kWrite) {
    const std::set<std::string> entered = tables_.plan(manifest.jobs);
    std::vector<JobResult> toEnter;
    for (const BatchJob& job : manifest.jobs) {
      sources_[job.key] = job.source + ": " + job.bag.string();
      std::optional<JobResult> result;
      if (const auto text = results.result(job.key)) result = parseResult(*text, place(job.key));
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
      const auto text = results_.result(*at);
      if (text) ended.push_back(parseResult(*text, place(*at)));
      at = text ? waiting_.erase(at) : std::next(at);
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
  std::string place(const std::string& key) const {
    return (results_.jobFolder(key) / "result.json").string();
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

}  // namespace

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
    const fs::path self = fs::read_symlink("/proc/self/exe", failed);
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

}  // namespace mm
