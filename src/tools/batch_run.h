#pragma once
#include <string>
#include <vector>

#include "fleet/manifest.h"
#include "fleet/snakemake.h"

namespace mm {

/// What a run of `mm batch` did.
struct BatchSummary {
  std::size_t jobs = 0, before = 0, done = 0, failed = 0, left = 0;  // before: finished by an earlier run
  bool stopped = false;                                              // by Ctrl-C
  double seconds = 0.0;
  std::string complaint;          // of Snakemake
  std::vector<std::string> whys;  // a line a failed job
};

/// Does what a manifest asks for and is not done yet, and enters it in the tables. Killed at any moment, the
/// next run goes on where it was. @param again failed jobs, too, are done again. @throw InputError.
BatchSummary runBatch(const Manifest& manifest, const ResultsFolder& results, const EngineOptions& options,
                      bool again);

}  // namespace mm
