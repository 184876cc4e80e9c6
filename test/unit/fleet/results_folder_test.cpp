#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "base/error.h"
#include "fleet/engine.h"
#include "fleet/job.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class ResultsFolderTest : public testing::Test {
 protected:
  ResultsFolderTest() : results_(make()) { results_.prepare(); }
  ~ResultsFolderTest() override { fs::remove_all(results_.path()); }
  static fs::path make() {
    std::string pattern = (fs::temp_directory_path() / "mm_results_XXXXXX").string();
    return mkdtemp(pattern.data());
  }
  fs::path begun(const std::string& text) {
    const fs::path folder = results_.begin(key_);
    std::ofstream(folder / "result.json") << text;
    return folder;
  }
  const std::string key_ = "ab345678901234567890123456789012";
  ResultsFolder results_;
};

TEST_F(ResultsFolderTest, aJobIsThereWhenItIsCompleteAndNotBefore) {
  const fs::path folder = begun("{}");
  EXPECT_FALSE(results_.finished(key_));
  EXPECT_FALSE(results_.result(key_).has_value());
  EXPECT_TRUE(results_.finish(folder, key_));
  EXPECT_EQ(results_.result(key_).value(), "{}");
  EXPECT_TRUE(fs::is_empty(results_.work()));
}

TEST_F(ResultsFolderTest, whoComesSecondChangesNothing) {
  EXPECT_TRUE(results_.finish(begun("first"), key_));
  EXPECT_FALSE(results_.finish(begun("second"), key_));
  EXPECT_EQ(results_.result(key_).value(), "first");
  EXPECT_TRUE(fs::is_empty(results_.work()));
}

TEST_F(ResultsFolderTest, aForgottenJobCanBeDoneAgain) {
  results_.finish(begun("first"), key_);
  results_.forget(key_);
  EXPECT_FALSE(results_.finished(key_));
  EXPECT_TRUE(results_.finish(begun("second"), key_));
  EXPECT_EQ(results_.result(key_).value(), "second");
}

TEST_F(ResultsFolderTest, whatAKilledProcessLeftIsRemovedAndWhatALivingOneDoesIsNot) {
  const pid_t child = fork();
  if (child == 0) {
    begun("half");
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const fs::path mine = begun("whole");
  EXPECT_EQ(results_.removeLeftovers(1e9), 1);
  EXPECT_TRUE(fs::exists(mine));
}

TEST_F(ResultsFolderTest, whatAnotherHostLeftIsRemovedWhenItHasBeenQuietForLong) {
  const fs::path old = results_.work() / (key_ + ".pc2.12"), fresh = results_.work() / (key_ + ".pc3.12");
  const auto twoDaysAgo = fs::file_time_type::clock::now() - std::chrono::hours(48);
  for (const fs::path& folder : {old, fresh}) {
    fs::create_directories(folder);
    std::ofstream(folder / "check.json") << "{";
    fs::last_write_time(folder, twoDaysAgo);
  }
  fs::last_write_time(old / "check.json", twoDaysAgo);
  std::ofstream(results_.work() / "slurm_job") << "12";
  EXPECT_EQ(results_.removeLeftovers(86'400.0), 1);
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(fresh));
  EXPECT_TRUE(fs::exists(results_.work() / "slurm_job"));
}

TEST_F(ResultsFolderTest, aFolderWithoutAResultIsNotInTheWay) {
  fs::create_directories(results_.jobFolder(key_));
  std::ofstream(results_.jobFolder(key_) / "calibration.yaml") << "half";
  EXPECT_FALSE(results_.finished(key_));
  EXPECT_TRUE(results_.finish(begun("whole"), key_));
  EXPECT_EQ(results_.result(key_).value(), "whole");
  EXPECT_FALSE(fs::exists(results_.jobFolder(key_) / "calibration.yaml"));
  EXPECT_TRUE(fs::is_empty(results_.work()));
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

TEST_F(ResultsFolderTest, chunksHoldEveryJobOnceAndAreReadBack) {
  std::vector<BatchJob> jobs(23);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    jobs[i].key = "key" + std::to_string(i);
    jobs[i].bag = "/a folder/it's " + std::to_string(i) + ".bag";
    jobs[i].steps = {"check", "calibrate"};
  }
  EngineOptions options;
  options.chunk = 5;
  const std::vector<Chunk> chunks = writeChunks(results_, jobs, options, 1000);
  ASSERT_EQ(chunks.size(), 5u);
  std::size_t next = 0;
  for (const Chunk& chunk : chunks) {
    const ChunkToDo todo = readChunk(chunk.file);
    EXPECT_EQ(todo.chunk.ended, chunk.ended);
    for (const BatchJob& job : todo.chunk.jobs) {
      EXPECT_EQ(job.key, jobs[next].key);
      EXPECT_EQ(job.bag, jobs[next].bag);
      EXPECT_EQ(job.steps, jobs[next++].steps);
    }
  }
  EXPECT_EQ(next, jobs.size());
  EXPECT_EQ(writeChunks(results_, jobs, options, 2).size(), 2u);  // an engine that takes two
}

/// Slurm's commands as scripts: what they answer stands in files.
class SlurmCommands {
 public:
  explicit SlurmCommands(const fs::path& folder) : folder_(folder), path_(std::getenv("PATH")) {
    fs::create_directories(folder);
    script("scontrol", "echo 'MaxArraySize = 1001'");
    script("sbatch", "echo 17");
    script("scancel", ":");
    script("squeue", "echo asked >>" + (folder / "log").string() + "; cat " + (folder / "rows").string());
    ::setenv("PATH", (folder.string() + ":" + path_).c_str(), 1);
  }
  ~SlurmCommands() { ::setenv("PATH", path_.c_str(), 1); }
  void answer(const std::string& rows) { std::ofstream(folder_ / "rows") << rows; }
  void fail() { fs::remove(folder_ / "rows"); }
  /// What the engine says when it has asked once more.
  bool running(Engine& engine) const {
    const auto asked = [&] {
      std::error_code ignored;
      const auto size = fs::file_size(folder_ / "log", ignored);
      return ignored ? 0 : size;
    };
    bool runs = true;
    for (const auto before = asked(); asked() == before;) {
      runs = engine.running();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return runs;
  }

 private:
  void script(const std::string& name, const std::string& line) const {
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << line << "\n";
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  fs::path folder_;
  std::string path_;
};

TEST_F(ResultsFolderTest, anArrayOfSlurmHasEndedWhenTheQueueSaysSoAndNotWhenItDoesNotAnswer) {
  SlurmCommands slurm(results_.path() / "bin");
  EngineOptions options;
  options.engine = "slurm";
  const std::unique_ptr<Engine> engine = engineOf(options, results_);
  engine->start(writeChunks(results_, {BatchJob()}, options, 1000), "/bin/true");
  slurm.answer("17\n");
  EXPECT_TRUE(slurm.running(*engine));
  slurm.fail();  // a controller that restarts
  EXPECT_TRUE(slurm.running(*engine));
  EXPECT_TRUE(fs::exists(results_.work() / "slurm_job"));
  slurm.answer("117\n16\n");
  EXPECT_FALSE(slurm.running(*engine));
  EXPECT_FALSE(fs::exists(results_.work() / "slurm_job"));
}

TEST(ShellLine, isReadBackByAShell) { EXPECT_EQ(shellLine({"a b", "it's", "$x"}), "'a b' 'it'\\''s' '$x'"); }

TEST(Engine, refusesWhatItCannotDo) {
  const ResultsFolder results("/tmp");
  EngineOptions options;
  options.engine = "sluurm";
  EXPECT_THROW(engineOf(options, results), InputError);
  options.engine = "ssh";
  EXPECT_THROW(engineOf(options, results), InputError);  // no hosts
}

}  // namespace
}  // namespace mm
