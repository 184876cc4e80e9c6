#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "fleet/database.h"
#include "fleet/job_result.h"

namespace mm {

/// One finished job with its labels: a row of the fleet.
struct FleetRecord {
  std::string machine, date, session, model;  // date: ISO 8601, UTC
  JobResult result;
};

/// The tables of a folder of results (docs/formats.md): jobs, parameters, found, sensors. Written by one
/// `mm batch` at a time, read by anybody meanwhile. What is in the folder `jobs` is the truth: after a file
/// was lost, `mm batch` enters from it what its manifest names, and nothing else (machine, date and session
/// of other jobs stand in their own manifests alone).
class FleetDatabase {
 public:
  /// @throw InputError: cannot be opened, or of a newer version.
  FleetDatabase(const std::filesystem::path& file, Database::Use use);

  /// Tells of the jobs of a manifest; those of an earlier one of the same sessions and models (changed since)
  /// are not current any more. @return keys whose results the tables hold already.
  std::set<std::string> plan(const std::vector<BatchJob>& jobs);
  /// Enters finished jobs of the plan, once: entering one again changes nothing.
  void enter(const std::vector<JobResult>& results, const ResultsFolder& folder);
  /// A job that is to be done again: what was entered is taken out.
  void takeOut(const std::string& key);

  /// All current jobs that ended, done or failed, by machine and date.
  std::vector<FleetRecord> records() const;
  long count(const std::string& status) const;  ///< current jobs: "waiting", "done", "failed"

 private:
  void enterLists(const std::vector<JobResult>& results) const;
  void addLists(std::vector<FleetRecord>& records) const;
  Database database_;
  long long schema_ = 0;  // of the file
};

}  // namespace mm
