#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

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
  EXPECT_EQ(results_.removeLeftovers(), 1);
  EXPECT_TRUE(fs::exists(mine));
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
