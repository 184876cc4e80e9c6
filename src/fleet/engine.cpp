#include "fleet/engine.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <thread>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "calibration_file/atomic_file.h"
#include "fleet/child_process.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestChunk = 50;          // jobs: what a lost process costs at most
constexpr int kChunksAProcess = 8;         // so that the last ones end at about the same time
constexpr double kParallelPatience = 2.5;  // s, with GNU parallel: its own way to SIGKILL takes 0.4 s
constexpr auto kCancelPatience = std::chrono::seconds(30);  // for an array of Slurm to leave the queue

int jobsAtATime(const EngineOptions& options) {
  return options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// GNU parallel, on this computer or over hosts that see the same folders under the same names.
class Parallel : public Engine {
 public:
  Parallel(EngineOptions options, fs::path work) : options_(std::move(options)), work_(std::move(work)) {
    if (!onPath("parallel"))
      throw InputError("--engine " + options_.engine +
                       ": GNU parallel is not on the PATH; install it (Debian: parallel)");
  }

  void start(const std::vector<Chunk>& chunks, const std::string& program) override {
    std::string list;
    for (const Chunk& chunk : chunks) list += chunk.file.string() + '\n';
    const fs::path names = work_ / "chunks.txt";
    writeFileAtomically(names, list);
    std::vector<std::string> words{
        "env",        "SHELL=/bin/sh", "parallel", "--will-cite",
        "--plain",    "--ungroup",     "--jobs",   std::to_string(jobsAtATime(options_)),
        "--arg-file", names.string()};
    if (!options_.hosts.empty()) {
      words.insert(words.end(), {"--sshlogin", joined(options_.hosts, ",")});
      if (const char* ssh = std::getenv("PARALLEL_SSH"); ssh != nullptr)
        words.insert(words.end(), {"--ssh", ssh});
    }
    words.push_back(
        "exec " + shellLine({program, "batch", "--limit", std::to_string(options_.limit), "--job"}) + " {}");
    child_ = ChildProcess(words, work_ / "engine.log");
  }
  bool running() override { return child_.running(); }
  /// Each job, and each ssh, is in a process group of its own: only parallel knows them. At SIGTERM it ends
  /// them (TERM, then KILL) and then itself; at one that comes while it starts it does nothing. Killed, it
  /// leaves the clients of ssh; the mm of this computer end with it (see doChunk).
  void stop() override {
    stopped_ = true;
    for (int i = 0; i < 2; ++i)
      if (child_.ask(SIGTERM, kParallelPatience)) return;
    child_.end(SIGKILL);
  }
  std::string complaint() const override {
    return child_.status() > 0 && !stopped_ ? lastWordsOf(child_.log()) : "";
  }

 private:
  EngineOptions options_;
  fs::path work_;
  ChildProcess child_;
  bool stopped_ = false;
};

/// One job array of Slurm. It lives on when mm is killed; the next run ends what it left.
class Slurm : public Engine {
 public:
  Slurm(EngineOptions options, fs::path work) : options_(std::move(options)), work_(std::move(work)) {
    for (const char* program : {"sbatch", "squeue", "scancel", "scontrol"})
      if (!onPath(program))
        throw InputError(
            std::string("--engine slurm: ") + program +
            " is not on the PATH; install Slurm's commands (Debian: slurm-client, or slurm-wlm for a "
            "cluster of one computer), or use --engine local");
    int status = 0;
    const std::string settings = outputOf({"scontrol", "show", "config"}, status);
    std::smatch found;
    if (status != 0)
      throw InputError(
          "--engine slurm: scontrol show config does not answer; is slurmctld running (sinfo tells)?");
    if (std::regex_search(settings, found, std::regex(R"(MaxArraySize\s*=\s*(\d+))")))
      most_ = std::max(1, std::stoi(found[1]) - 1);
    endLeftover();
  }

  void start(const std::vector<Chunk>& chunks, const std::string& program) override {
    std::string script = "#!/bin/sh\nexec " +
                         shellLine({program, "batch", "--limit", std::to_string(options_.limit), "--job"}) +
                         " ";
    // chunks are numbered from 0 in the order of the list, and so are their files
    const std::string first = chunks.front().file.string();
    script += shellLine({first.substr(0, first.rfind("-0.json"))}) + "-$SLURM_ARRAY_TASK_ID.json\n";
    writeFileAtomically(work_ / "slurm.sh", script);
    std::vector<std::string> words{"sbatch",
                                   "--parsable",
                                   "--job-name=mm_batch",
                                   "--array=0-" + std::to_string(chunks.size() - 1) +
                                       (options_.jobs > 0 ? "%" + std::to_string(options_.jobs) : ""),
                                   "--output=" + (work_ / "slurm-%a.log").string(),
                                   "--chdir=" + work_.string()};
    words.insert(words.end(), options_.sbatchOptions.begin(), options_.sbatchOptions.end());
    words.push_back((work_ / "slurm.sh").string());
    const fs::path log = work_ / "engine.log";
    ChildProcess submit(words, log);
    while (submit.running()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const std::string said = lastWordsOf(log);
    if (submit.status() != 0) throw InputError("--engine slurm: sbatch refuses: " + said);
    id_ = said.substr(0, said.find(';'));
    writeFileAtomically(idFile(), id_);
    asked_ = std::chrono::steady_clock::now();
  }

  bool running() override {
    if (id_.empty()) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now - asked_ < std::chrono::seconds(2)) return true;  // the scheduler is not asked more often
    asked_ = now;
    if (inQueue(id_)) return true;
    fs::remove(idFile());
    id_.clear();
    return false;
  }
  void stop() override {
    if (id_.empty()) return;
    if (cancel(id_))
      fs::remove(idFile());
    else
      complaint_ =
          "array " + id_ + " may still run: Slurm does not answer, or does not end it; the next run ends it";
    id_.clear();
  }
  int mostChunks() const override { return most_; }
  std::string complaint() const override { return complaint_; }

 private:
  fs::path idFile() const { return work_ / "slurm_job"; }
  /// Asked for all arrays: of one that ended a while ago it says the same as of none at all, by an error, and
  /// an error may as well be a controller that restarts. Then it is taken to run still.
  static bool inQueue(const std::string& id) {
    int status = 0;
    std::istringstream ids(outputOf({"squeue", "--noheader", "--format=%F"}, status));
    if (status != 0) return true;
    for (std::string one; ids >> one;)
      if (one == id) return true;
    return false;
  }
  /// @return whether it has left the queue.
  static bool cancel(const std::string& id) {
    int status = 0;
    outputOf({"scancel", id}, status);
    const auto until = std::chrono::steady_clock::now() + kCancelPatience;
    while (inQueue(id)) {
      if (std::chrono::steady_clock::now() > until) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    return true;
  }
  void endLeftover() const {
    std::error_code ignored;
    if (!fs::is_regular_file(idFile(), ignored)) return;
    const std::string id(trim(readFile(idFile())));
    if (!cancel(id))
      throw InputError("--engine slurm: array " + id + " of an earlier run is in the queue still; scancel " +
                       id + ", wait until squeue does not list it, and run again");
    fs::remove(idFile());
  }

  EngineOptions options_;
  fs::path work_;
  std::string id_, complaint_;
  std::chrono::steady_clock::time_point asked_;
  int most_ = 1000;
};

}  // namespace

std::string shellLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    std::string quoted;
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += (line.empty() ? "'" : " '") + quoted + "'";
  }
  return line;
}

std::vector<Chunk> writeChunks(const ResultsFolder& folder, const std::vector<BatchJob>& jobs,
                               const EngineOptions& options, int most) {
  const int hosts = std::max<int>(1, static_cast<int>(options.hosts.size()));
  const auto count = static_cast<int>(jobs.size());
  int size = options.chunk;
  if (size <= 0)
    size = std::clamp(count / (kChunksAProcess * hosts * jobsAtATime(options)), 1, kLargestChunk);
  size = std::max(size, (count + most - 1) / most);
  const fs::path work = fs::absolute(folder.work()).lexically_normal();
  const std::string run = std::to_string(static_cast<long>(::getpid()));
  std::vector<Chunk> chunks;
  for (int first = 0; first < count; first += size) {
    Chunk chunk;
    const std::string name = "chunk-" + run + "-" + std::to_string(chunks.size());
    chunk.file = work / (name + ".json");
    chunk.ended = work / (name + ".ended");
    nlohmann::json list = nlohmann::json::array();
    for (int i = first; i < std::min(count, first + size); ++i) {
      chunk.jobs.push_back(jobs[static_cast<std::size_t>(i)]);
      list.push_back(jobJson(chunk.jobs.back()));
    }
    const nlohmann::json whole = {{"folder", fs::absolute(folder.path()).lexically_normal().string()},
                                  {"ended", chunk.ended.string()},
                                  {"jobs", list}};
    writeFileAtomically(chunk.file, whole.dump());
    chunks.push_back(std::move(chunk));
  }
  return chunks;
}

ChunkToDo readChunk(const fs::path& file) {
  try {
    const nlohmann::json whole = nlohmann::json::parse(readFile(file));
    ChunkToDo todo{whole.at("folder").get<std::string>(), {file, whole.at("ended").get<std::string>(), {}}};
    for (const auto& job : whole.at("jobs")) todo.chunk.jobs.push_back(jobOf(job));
    return todo;
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file.string() + ": is not a list of jobs that mm batch wrote (" + e.what() +
                     "); run mm batch with the manifest");
  }
}

std::unique_ptr<Engine> engineOf(const EngineOptions& options, const ResultsFolder& folder) {
  static const std::vector<std::string> kEngines{"local", "ssh", "slurm"};
  if (std::find(kEngines.begin(), kEngines.end(), options.engine) == kEngines.end())
    throw InputError("--engine: '" + options.engine + "' is not known" +
                     didYouMean(options.engine, kEngines) + " (engines are " + listOf(kEngines) + ")");
  if (options.engine == "ssh" && options.hosts.empty())
    throw InputError("--engine ssh: no host is named; give --hosts pc1,pc2 (: is this computer)");
  if (options.engine != "ssh" && !options.hosts.empty())
    throw InputError("--hosts are those of --engine ssh; give that, or leave the hosts out");
  const fs::path work = fs::absolute(folder.work()).lexically_normal();
  if (options.engine == "slurm") return std::make_unique<Slurm>(options, work);
  return std::make_unique<Parallel>(options, work);
}

}  // namespace mm
