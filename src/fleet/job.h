#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mm {

/// What can be done with a session, in the order in which it is done: check, calibrate, diagnose, add_all,
/// verify, report.
const std::vector<std::string>& batchSteps();

/// One session with one model, and what to do with it. `key` names its folder: a hash of everything that the
/// result depends on, and of nothing else, so that the same job is never done twice.
struct BatchJob {
  std::string key;
  std::filesystem::path bag, model, calibration;  // absolute; model, calibration: empty where none is needed
  std::string space;                              // namespace of the topics
  std::vector<std::string> steps;
  std::string method = "least_squares";
  std::uint64_t seed = 1;
  double repeatability = 0.0;  // um; 0: not stated
  bool loaded = false;         // the controller corrected while the session was measured (verify --loaded)
  std::string serial;          // for the report's head
  // Labels, which no result depends on: of the tables only.
  std::string machine, date;  // date: ISO 8601, UTC; empty: the start of the session
  std::string source;         // "manifest.yaml:12", for messages

  bool does(const std::string& step) const;  ///< whether the step is among its steps

  /// See eachField; in the order of the JSON.
  template <class Self, class F>
  static void fields(Self& self, const F& f) {
    f("key", self.key);
    f("bag", self.bag);
    f("model", self.model);
    f("calibration", self.calibration);
    f("namespace", self.space);
    f("steps", self.steps);
    f("method", self.method);
    f("seed", self.seed);
    f("repeatability_um", self.repeatability);
    f("loaded", self.loaded);
    f("serial", self.serial);
    f("machine", self.machine);
    f("date", self.date);
    f("source", self.source);
  }
};

/// The key of a job: 32 hexadecimal digits of a SHA-1 over the bytes of its files (the model's URDF, too),
/// its options and the version of the package. The bag is read in blocks. @throw InputError: a file cannot be
/// read, or grows or shrinks meanwhile.
std::string keyOf(const BatchJob& job);

/// What job.json in its folder says.
nlohmann::json jobJson(const BatchJob& job);
BatchJob jobOf(const nlohmann::json& json);  ///< @throw nlohmann::json::exception: not as jobJson wrote it

/// The folder of results, as `mm batch -o` names it:
///
///     fleet.db            the tables (fleet_database.h)
///     jobs/ab/ab12…/      one finished job: result.json, calibration.yaml, what the steps printed
///     work/               of jobs that run: removed by a later run where they were killed
///     batch.log           what Snakemake says
///
/// A job's folder is filled in `work` and renamed when it is complete, so that whoever is killed at any
/// moment leaves a whole folder or none.
class ResultsFolder {
 public:
  explicit ResultsFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& path() const { return folder_; }            ///< as it was named
  std::filesystem::path database() const { return folder_ / "fleet.db"; }  ///< the tables
  std::filesystem::path work() const { return folder_ / "work"; }          ///< of what runs
  std::filesystem::path log() const { return folder_ / "batch.log"; }      ///< of Snakemake
  std::filesystem::path jobFolder(const std::string& key) const;           ///< of a finished job
  bool finished(const std::string& key) const;                             ///< done or failed
  std::optional<std::string> result(const std::string& key) const;         ///< text of result.json
  /// Makes the folder. @throw InputError: no permission, a file is in the way, or the path is not UTF-8.
  void prepare() const;
  /// Removes what an earlier run left in `work`; where it still runs, its files have no name any more.
  void clearWork() const;
  /// A folder for the work on a job, with what is to do as job.json; what lies in the job's place goes.
  void begin(const BatchJob& job) const;
  /// Makes a folder of `begin`, with the result in it, the job's. @throw InputError.
  void finish(const std::string& key) const;
  /// Removes a finished job, so that it is done again.
  void forget(const std::string& key) const;

 private:
  std::filesystem::path folder_;
};

/// One run of `mm batch` at a time writes to a folder of results. Ends with the process, however that ends.
class ResultsLock {
 public:
  /// @throw InputError: another process has it, or the file system has no locks.
  explicit ResultsLock(const ResultsFolder& folder);
  ~ResultsLock();
  ResultsLock(const ResultsLock&) = delete;
  ResultsLock& operator=(const ResultsLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace mm
