#pragma once
#include <memory>
#include <string>
#include <vector>

#include "fleet/child_process.h"
#include "fleet/job.h"

namespace mm {

/// Where Snakemake runs the jobs.
struct EngineOptions {
  std::string engine = "local";  // local or slurm
  std::string profile;           // of Snakemake, which then says where; empty: none
  int jobs = 0;      // at a time; 0: one a core of this computer, 100 of Slurm, as the profile says
  int limit = 3600;  // s that a step may take
};

/// Snakemake with the rules of the package (config/batch/Snakefile) over the jobs of a folder of results.
class Snakemake {
 public:
  /// Ends what an earlier run, that was killed, left in Slurm. @throw InputError: not installed.
  Snakemake(EngineOptions options, const ResultsFolder& folder);
  /// Starts it in `work`, where each job gets its folder. @param program path of mm. @throw InputError.
  void start(const std::vector<BatchJob>& jobs, const std::string& program);
  bool running() { return child_ && child_->running(); }  ///< cheap enough for twenty times a second
  void stop();  ///< ends all that it runs. @throw InputError: Slurm does not end it.
  /// Why it failed, with the place of its log; empty: it did not. To be asked when it has ended.
  std::string complaint() const;

 private:
  void endInSlurm() const;
  EngineOptions options_;
  ResultsFolder folder_;
  std::string name_;  // of the folder's jobs in Slurm
  std::unique_ptr<ChildProcess> child_;
};

}  // namespace mm
