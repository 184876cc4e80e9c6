#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "fleet/job.h"

namespace mm {

/// Who runs the jobs: programs that exist for it.
struct EngineOptions {
  std::string engine = "local";            // local, ssh, slurm
  int jobs = 0;                            // at a time (on each host of ssh); 0: one a core of this computer
  int chunk = 0;                           // jobs that one process does in turn; 0: chosen by the engine
  std::vector<std::string> hosts;          // of ssh
  std::vector<std::string> sbatchOptions;  // of slurm: "--partition=short"
  int limit = 3600;                        // s that a step may take
};

/// The jobs of one process of an engine, as a file in `work`; as they end, it appends their keys to another.
struct Chunk {
  std::filesystem::path file, ended;
  std::vector<BatchJob> jobs;
};

/// Cuts the jobs into chunks and writes their files. @param most chunks that the engine takes at a time.
std::vector<Chunk> writeChunks(const ResultsFolder& folder, const std::vector<BatchJob>& jobs,
                               const EngineOptions& options, int most);
/// What a file of `writeChunks` holds.
struct ChunkToDo {
  std::filesystem::path folder;  // of the results
  Chunk chunk;
};
ChunkToDo readChunk(const std::filesystem::path& file);  ///< @throw InputError: damaged

/// A program that runs chunks: it is started once, and looked at until it has ended.
class Engine {
 public:
  virtual ~Engine() = default;
  /// @param program path of mm. @throw InputError: the engine is not installed, or refuses.
  virtual void start(const std::vector<Chunk>& chunks, const std::string& program) = 0;
  virtual bool running() = 0;  ///< cheap enough for twenty times a second
  /// Ends what it runs and waits for that, some seconds at most; what it says if that was not enough is the
  /// complaint.
  virtual void stop() = 0;
  virtual int mostChunks() const { return 1'000'000; }  ///< at a time
  /// What it said when it ended in an unusual way; empty: nothing.
  virtual std::string complaint() const { return {}; }
};

/// @throw InputError: no such engine, or hosts are missing.
std::unique_ptr<Engine> engineOf(const EngineOptions& options, const ResultsFolder& folder);

/// The words as one line of a POSIX shell.
std::string shellLine(const std::vector<std::string>& words);

}  // namespace mm
