#include "fleet/snakemake.h"

#include <signal.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "base/error.h"
#include "calibration_file/atomic_file.h"
#include "fleet/readable.h"
#include "session/text_file.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr double kClusterPatience = 30.0;  // s, for a cluster to end jobs
constexpr int kJobsInSlurm = 100;          // an srun here for each

void require(const std::string& program, const std::string& package) {
  if (!onPath(program))
    throw InputError(program + " is not on the PATH; install it (Debian: " + package + ")");
}

fs::path rules() {
  for (const char* folder : {MM_SOURCE_CONFIG, MM_INSTALLED_CONFIG}) {
    fs::path file = fs::path(folder) / "batch" / "Snakefile";
    if (fs::is_regular_file(file)) return file;
  }
  throw InputError(std::string("batch/Snakefile is neither in ") + MM_SOURCE_CONFIG + " nor in " +
                   MM_INSTALLED_CONFIG + "; install the package again");
}

}  // namespace

Snakemake::Snakemake(EngineOptions options, const ResultsFolder& folder)
    : options_(std::move(options)), folder_(fs::absolute(folder.path()).lexically_normal()) {
  require("snakemake", "snakemake");
  if (options_.engine != "slurm") return;
  for (const char* program : {"srun", "squeue", "scancel"}) require(program, "slurm-client");
  name_ = "mm-" + std::to_string(std::hash<std::string>()(folder_.path().string()));
  endInSlurm();
}

void Snakemake::endInSlurm() const {
  ChildProcess end(
      {"sh", "-c",
       "scancel --name=$0 && while rows=$(squeue --noheader --name=$0) && [ \"$rows\" ]; do sleep 0.2; done "
       "&& squeue --noheader --name=$0",
       name_},
      folder_.log());
  if (end.endsWithin(kClusterPatience) && end.status() == 0) return;
  throw InputError("--engine slurm: Slurm does not end the jobs " + name_ +
                   " of this folder, or does not answer (" + lastWordsOf(folder_.log()) +
                   "); wait until squeue --name=" + name_ + " lists none, and run again");
}

void Snakemake::start(const std::vector<BatchJob>& jobs, const std::string& program) {
  nlohmann::json todo{{"mm", program}, {"limit", options_.limit}, {"under", nlohmann::json::array()}};
  if (!name_.empty())
    todo["under"] = {"srun", "--quiet", "--ntasks=1", "--cpus-per-task=1", "--job-name=" + name_};
  for (const BatchJob& job : jobs) {
    folder_.begin(job);
    todo["products"].push_back(
        (folder_.jobFolder(job.key) / "result.json").lexically_relative(folder_.work()).string());
  }
  writeFileAtomically(folder_.work() / "batch.json", todo.dump());
  const std::string work = folder_.work().string();
  if (!isUtf8(program))
    throw InputError("the path of mm, " + readable(program) + ", is not UTF-8; install it elsewhere");
  // A user may have a profile that nobody asked for here, another locale than that of the paths, and no home
  // that can be written.
  std::vector<std::string> words{"env", "--unset=SNAKEMAKE_PROFILE", "PYTHONUTF8=1",
                                 "XDG_CACHE_HOME=" + work};
  words.insert(words.end(), {"snakemake", "--snakefile", rules().string(), "--directory", work,
                             "--keep-going", "--keep-incomplete", "--nolock", "--rerun-triggers", "mtime",
                             "--drop-metadata", "--scheduler", "greedy", "--quiet", "rules"});
  if (!options_.profile.empty()) words.insert(words.end(), {"--profile", options_.profile});
  int atATime = options_.jobs;
  if (atATime == 0 && options_.profile.empty())
    atATime =
        name_.empty() ? std::max(1, static_cast<int>(std::thread::hardware_concurrency())) : kJobsInSlurm;
  if (atATime > 0) words.insert(words.end(), {"--jobs", std::to_string(atATime)});
  child_ = std::make_unique<ChildProcess>(words, folder_.log());
}

void Snakemake::stop() {
  if (!child_) return;
  if (!options_.profile.empty()) {
    child_->ask(SIGINT);  // it cancels what it gave to a cluster
    child_->endsWithin(kClusterPatience);
  }
  child_.reset();
  if (!name_.empty()) endInSlurm();
}

std::string Snakemake::complaint() const {
  if (!child_ || child_->status() <= 0) return {};
  std::string said = lastWordsOf(folder_.log());
  std::istringstream log(readFile(folder_.log()));
  for (std::string line; std::getline(log, line);)
    if (const std::size_t at = line.find("rror: "); at != std::string::npos) {
      said = line.substr(at + 6);
      break;
    }
  return (options_.profile.empty() ? "" : "--profile " + options_.profile + ": ") + said + " (" +
         folder_.log().string() + ")";
}

}  // namespace mm
