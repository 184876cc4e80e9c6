#include "tools/batch_run.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/format.h"
#include "tools/interrupt.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Seconds without a new file after which a job of another host is taken for dead: a day, or two steps.
double patienceOf(int limit) { return std::max(86'400.0, 2.0 * limit); }

/// What an earlier run left in `work`; only under the lock, with no engine running.
void tidy(const ResultsFolder& results, int limit) {
  results.removeLeftovers(patienceOf(limit));
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(results.work(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("chunk", 0) == 0 || name.rfind("slurm-", 0) == 0 || name == "engine.log" ||
        name == "slurm.sh")
      fs::remove(entry.path(), ignored);
  }
}

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
  std::size_t waiting() const { return waiting_.size(); }
  BatchSummary& summary() { return summary_; }

  /// Enters what the chunks say has ended since they were asked last.
  void collect(const std::vector<Chunk>& chunks) {
    std::vector<JobResult> ended;
    for (const Chunk& chunk : chunks) {
      Read& read = read_[chunk.ended.string()];
      if (read.jobs >= chunk.jobs.size()) continue;  // all of it has ended
      std::ifstream in(chunk.ended);
      if (!in.seekg(read.bytes)) continue;
      for (std::string key; std::getline(in, key) && !in.eof(); read.bytes = in.tellg()) {
        ++read.jobs;
        take(key, ended);
      }
    }
    enter(ended);
  }
  /// Looks for every job that is still waiting: at the end.
  void collectAll() {
    std::vector<JobResult> ended;
    const std::set<std::string> open = waiting_;
    for (const std::string& key : open) take(key, ended);
    enter(ended);
    summary_.left = waiting_.size();
  }

 private:
  std::string place(const std::string& key) const {
    return (results_.jobFolder(key) / "result.json").string();
  }
  void take(const std::string& key, std::vector<JobResult>& ended) {
    if (waiting_.count(key) == 0) return;
    const auto text = results_.result(key);
    if (!text) return;
    waiting_.erase(key);
    ended.push_back(parseResult(*text, place(key)));
  }
  void enter(const std::vector<JobResult>& ended) {
    if (ended.empty()) return;
    tables_.enter(ended, results_);
    for (const JobResult& r : ended) {
      ++(r.status == "done" ? summary_.done : summary_.failed);
      if (r.status != "done") note(r);
    }
  }
  void note(const JobResult& r) { summary_.whys.push_back(sources_[r.key] + ": " + r.failed + ": " + r.why); }

  const ResultsFolder& results_;
  FleetDatabase tables_;
  std::map<std::string, std::string> sources_;
  struct Read {
    std::streamoff bytes = 0;
    std::size_t jobs = 0;
  };
  std::map<std::string, Read> read_;  // of each chunk's file of ended jobs
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
  const std::unique_ptr<Engine> engine = engineOf(options, results);
  tidy(results, options.limit);
  Bookkeeping books(manifest, results, again);
  const auto begun = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
  if (!books.toDo().empty()) {
    const std::vector<Chunk> chunks = writeChunks(results, books.toDo(), options, engine->mostChunks());
    std::error_code failed;
    const fs::path self = fs::read_symlink("/proc/self/exe", failed);
    if (failed) throw InputError("/proc/self/exe: cannot be read; is /proc mounted?");
    engine->start(chunks, self.string());
    ProgressBar bar("batch");
    while (books.waiting() > 0 && engine->running()) {
      if (Interrupt::asked()) {
        books.summary().stopped = true;
        engine->stop();
        break;
      }
      const auto asked = Clock::now();
      books.collect(chunks);
      const auto all = static_cast<double>(books.summary().jobs);
      bar.show(1.0 - static_cast<double>(books.waiting()) / all, note(books.summary(), seconds()));
      // of thousands of chunks on a slow disk at most half of the time is for looking
      std::this_thread::sleep_for(
          std::max<Clock::duration>(std::chrono::milliseconds(50), Clock::now() - asked));
    }
    while (!books.summary().stopped && engine->running()) {  // its last words
      if (Interrupt::asked()) engine->stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    books.summary().complaint = engine->complaint();
  }
  books.collectAll();
  results.removeLeftovers(patienceOf(options.limit));
  books.summary().seconds = seconds();
  return books.summary();
}

}  // namespace mm
