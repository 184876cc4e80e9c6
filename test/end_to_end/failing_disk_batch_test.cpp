// A batch on a disk that fails at the n-th read or write of all its processes together: what was done before
// stays, nothing is done twice or lost, and the same line goes on from there until everything is done.
#include <cstdlib>

#include "failing_disk.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class FailingBatch : public FailingDisk {
 protected:
  static constexpr const char* kLine = "batch manifest.yaml -o results --jobs 1 --json";

  void SetUp() override {
    if (std::system("command -v snakemake >/dev/null") != 0)
      GTEST_SKIP() << "Snakemake is not installed; scripts/setup installs it";
    folder_->write("first.yaml",
                   "sessions: [{bags: t.bag}]\nmodel: m.yaml\nmethod: least_squares\nsteps: [calibrate]\n");
    folder_->write("manifest.yaml",
                   "sessions: [{bags: s.bag}, {bags: t.bag}]\nmodel: m.yaml\nmethod: "
                   "least_squares\nsteps: [calibrate]\n");
    fs::remove_all(results());
    run("batch first.yaml -o results --jobs 1");
    fs::copy(results(), copy(), fs::copy_options::recursive);
  }
  void TearDown() override {
    fs::remove_all(results());
    fs::remove_all(copy());
  }
  static fs::path results() { return fs::path(whole_) / "results"; }
  static fs::path copy() { return fs::path(whole_) / "before"; }

  /// Every finished job: its result.json.
  static std::map<std::string, std::string> finished(const fs::path& folder) {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "jobs"))
      if (entry.path().filename() == "result.json")
        all[entry.path().parent_path().filename().string()] = textOf(entry.path().string());
    return all;
  }

  /// The tables say what the folders hold.
  static void everythingIsDone() {
    const Answer fleet = typed("fleet results --json");
    ASSERT_EQ(fleet.status, 0) << fleet.error;
    const nlohmann::json told = fleet.json();
    EXPECT_EQ(told.at("done"), 2) << told;
    EXPECT_EQ(finished(results()).size(), 2u);
    for (const auto& [key, text] : finished(results()))
      EXPECT_EQ(nlohmann::json::parse(text).at("status"), "done") << text;
    EXPECT_FALSE(fs::exists(results() / "work")) << "was left behind";
  }
};

TEST_F(FailingBatch, TheSameLineGoesOn) {
  const auto before = finished(results());
  ASSERT_EQ(before.size(), 1u);
  const Answer plain = typedOn({}, kLine);
  ASSERT_EQ(plain.status, 0) << plain.error;
  everythingIsDone();
  std::vector<DiskFault> all = faults(reads(), writes());
  // How many operations the jobs beside it make varies: only of the first is it certain whom it meets.
  for (const bool reading : {true, false}) all.push_back({reading, DiskFault::Way::kLasting, 1, EIO, false});
  int refused = 0, failed = 0;
  for (const DiskFault& fault : all) {
    if (fault.anew && !mm_test::longTests() && fault.n % 2 == 0) continue;
    // every day a disk that stays broken from this write on stands for one write that fails
    if (!mm_test::thoroughTests() && !fault.reads && fault.way == DiskFault::Way::kOnce) continue;
    SCOPED_TRACE(fault.inWords());
    fs::remove_all(results());
    if (!fault.anew) fs::copy(copy(), results(), fs::copy_options::recursive);
    const Answer answer = typedOn(fault, kLine);
    EXPECT_TRUE(answer.status == 0 || answer.status == 1 || answer.status == 2)
        << answer.status << answer.error;
    for (const auto& [key, text] : before) {
      if (fault.anew) break;
      EXPECT_EQ(finished(results())[key], text) << "lost, or done twice";
    }
    if (fault.way == DiskFault::Way::kLasting && fault.n == 1) {
      EXPECT_EQ(answer.status, 2) << answer.out;
    }
    if (answer.status == 0) everythingIsDone();
    if (answer.status == 2) {
      ++refused;
      expectOneLine(answer, fault);
    }
    if (answer.status == 1) {
      ++failed;
      EXPECT_FALSE(answer.error.empty());
      EXPECT_EQ(answer.json().at("left").get<int>() + answer.json().at("failed").get<int>() > 0, true);
    }
    if (answer.status != 0) {  // the disk is mended
      const Answer again = typed(kLine);
      EXPECT_EQ(again.status, 0) << again.error << answer.error;
      everythingIsDone();
    }
    if (HasFailure()) return;
  }
  std::printf("%5zu runs, %d refused, %d with failed jobs\n", all.size(), refused, failed);
  EXPECT_GE(refused, 2) << "a disk that fails from the first read, and from the first write";
}

}  // namespace
}  // namespace mm
