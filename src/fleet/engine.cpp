#include "fleet/engine.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "calibration_file/atomic_file.h"
#include "fleet/child_process.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestChunk = 50;   // jobs: what a lost process costs at most
constexpr int kChunksAProcess = 8;  // so that the last ones end at about the same time

int jobsAtATime(const EngineOptions& options) {
  return options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// The last line that a program printed: why it ended.
std::string lastLine(const fs::path& log) {
  std::error_code ignored;
  if (!fs::is_regular_file(log, ignored) || fs::file_size(log, ignored) == 0) return {};
  const std::string text = readFile(log), trimmed(trim(text));
  return trimmed.substr(trimmed.find_last_of('\n') + 1);
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
  void stop() override { child_.end(SIGKILL); }  // what it runs ends with it
  std::string complaint() const override { return child_.status() > 0 ? lastLine(child_.log()) : ""; }

 private:
  EngineOptions options_;
  fs::path work_;
  ChildProcess child_;
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
    const std::string said = lastLine(log);
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
    if (!id_.empty()) cancel(id_);
    id_.clear();
    fs::remove(idFile());
  }
  int mostChunks() const override { return most_; }

 private:
  fs::path idFile() const { return work_ / "slurm_job"; }
  static bool inQueue(const std::string& id) {
    int status = 0;
    const std::string rows = outputOf({"squeue", "--noheader", "--jobs=" + id}, status);
    return status == 0 && !trim(rows).empty();  // an id that it does not know any more is an error
  }
  static void cancel(const std::string& id) {
    int status = 0;
    outputOf({"scancel", id}, status);
    while (inQueue(id)) std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  void endLeftover() const {
    std::error_code ignored;
    if (!fs::is_regular_file(idFile(), ignored)) return;
    cancel(std::string(trim(readFile(idFile()))));
    fs::remove(idFile());
  }

  EngineOptions options_;
  fs::path work_;
  std::string id_;
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
