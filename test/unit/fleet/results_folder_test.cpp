#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/error.h"
#include "fleet/job.h"
#include "fleet/snakemake.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class ResultsFolderTest : public testing::Test {
 protected:
  ResultsFolderTest() : results_(make()) {
    job_.key = key_;
    results_.prepare();
  }
  ~ResultsFolderTest() override { fs::remove_all(results_.path()); }
  static fs::path make() {
    std::string pattern = (fs::temp_directory_path() / "mm_results_XXXXXX").string();
    return mkdtemp(pattern.data());
  }
  void begin() { results_.begin(job_); }
  void finish(const std::string& text) {
    std::ofstream(results_.work() / key_ / "result.json") << text;
    results_.finish(key_);
  }
  const std::string key_ = "ab345678901234567890123456789012";
  BatchJob job_;
  ResultsFolder results_;
};

TEST_F(ResultsFolderTest, aJobIsThereWhenItIsCompleteAndNotBefore) {
  begin();
  EXPECT_FALSE(results_.finished(key_));
  EXPECT_FALSE(results_.result(key_).has_value());
  finish("{}");
  EXPECT_EQ(results_.result(key_).value(), "{}");
  EXPECT_TRUE(fs::is_empty(results_.work()));
}

TEST_F(ResultsFolderTest, itsFolderSaysWhatIsToDo) {
  job_.bag = "/a folder/it's.bag";
  job_.steps = {"check", "calibrate"};
  begin();
  const BatchJob read = jobOf(nlohmann::json::parse(std::ifstream(results_.work() / key_ / "job.json")));
  EXPECT_EQ(read.key, key_);
  EXPECT_EQ(read.bag, job_.bag);
  EXPECT_EQ(read.steps, job_.steps);
}

TEST_F(ResultsFolderTest, aForgottenJobCanBeDoneAgain) {
  begin();
  finish("first");
  results_.forget(key_);
  EXPECT_FALSE(results_.finished(key_));
  begin();
  finish("second");
  EXPECT_EQ(results_.result(key_).value(), "second");
}

TEST_F(ResultsFolderTest, aFolderWithoutAResultIsNotInTheWay) {
  fs::create_directories(results_.jobFolder(key_));
  std::ofstream(results_.jobFolder(key_) / "calibration.yaml") << "half";
  EXPECT_FALSE(results_.finished(key_));
  begin();
  finish("whole");
  EXPECT_EQ(results_.result(key_).value(), "whole");
  EXPECT_FALSE(fs::exists(results_.jobFolder(key_) / "calibration.yaml"));
}

TEST_F(ResultsFolderTest, aProcessThatOutlivedItsRunWritesNothingIntoTheNext) {
  begin();
  int told[2];
  ASSERT_EQ(pipe(told), 0);
  const pid_t child = fork();
  if (child == 0) {
    char byte = 0;
    fs::current_path(results_.work() / key_);
    close(told[1]);
    if (read(told[0], &byte, 1) != 1) _exit(2);
    _exit(std::ofstream("calibration.yaml") << "of the first" ? 1 : 0);
  }
  const std::string its = "/proc/" + std::to_string(child) + "/cwd";
  while (fs::read_symlink(its).filename() != key_) std::this_thread::yield();
  results_.clearWork();
  begin();
  EXPECT_EQ(write(told[1], "", 1), 1);
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_FALSE(fs::exists(results_.work() / key_ / "calibration.yaml"));
}

TEST_F(ResultsFolderTest, aPathThatIsNoUtf8IsRefused) {
  EXPECT_THROW(ResultsFolder(results_.path() / "ger\xE4t").prepare(), InputError);
}

TEST_F(ResultsFolderTest, twoRunsAtATimeAreRefusedAndAnEndedOneIsForgotten) {
  {
    const ResultsLock first(results_);
    EXPECT_THROW(ResultsLock second(results_), InputError);
  }
  EXPECT_NO_THROW(ResultsLock third(results_));
}

/// Slurm's commands as scripts on the PATH. @param squeue what it does.
class SlurmCommands {
 public:
  SlurmCommands(const fs::path& folder, const std::string& squeue) : path_(std::getenv("PATH")) {
    fs::create_directories(folder);
    for (const auto& [name, line] :
         std::map<std::string, std::string>{{"snakemake", ":"},
                                            {"srun", ":"},
                                            {"scancel", "echo $* >" + (folder / "said").string()},
                                            {"squeue", squeue}}) {
      std::ofstream(folder / name) << "#!/bin/sh\n" << line << "\n";
      fs::permissions(folder / name, fs::perms::owner_all);
    }
    ::setenv("PATH", (folder.string() + ":" + path_).c_str(), 1);
  }
  ~SlurmCommands() { ::setenv("PATH", path_.c_str(), 1); }

 private:
  std::string path_;
};

TEST_F(ResultsFolderTest, whatAKilledRunLeftInSlurmIsEndedAndWaitedFor) {
  const fs::path folder = results_.path() / "bin", asked = folder / "asked";
  const SlurmCommands slurm(
      folder, "echo >>" + asked.string() + "; [ $(wc -l <" + asked.string() + ") -gt 2 ] || echo 17 R");
  EngineOptions options;
  options.engine = "slurm";
  EXPECT_NO_THROW(Snakemake(options, results_));
  std::string said;
  std::ifstream(folder / "said") >> said;
  EXPECT_EQ(said.rfind("--name=mm-", 0), 0u) << said;
  EXPECT_EQ(fs::file_size(asked), 4u);  // until none was listed, and once more to hear that it answers
}

TEST_F(ResultsFolderTest, aSlurmThatDoesNotAnswerIsNotTakenForAnEmptyQueue) {
  const SlurmCommands slurm(results_.path() / "bin", "echo 'Unable to contact slurm controller' >&2; exit 1");
  EngineOptions options;
  options.engine = "slurm";
  try {
    Snakemake refused(options, results_);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("Unable to contact slurm controller"), std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace mm
