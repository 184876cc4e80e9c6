// A folder of calibrations on a disk that fails at the n-th read or write: which are there, whole, and what
// was ever active stay; what is active is what it was or what was wanted; the next command goes on as if
// nothing had been.
#include "calibration_file/calibration_yaml.h"
#include "failing_disk.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class FailingStore : public FailingDisk {
 protected:
  void SetUp() override {
    kept_ = *folder_ / "kept";
    copy_ = *folder_ / "copy";
    fs::remove_all(kept_);
    run("promote c.yaml --store kept");
    run("promote t.yaml --store kept");
  }
  void TearDown() override {
    fs::remove_all(kept_);
    fs::remove_all(copy_);
  }

  static void copyTree(const fs::path& from, const fs::path& to) {
    fs::remove_all(to);
    fs::copy(from, to, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  }
  static std::string target(const fs::path& link) {
    std::error_code none;
    return fs::read_symlink(link, none).string();
  }

  void everyCalibrationIsWhole() const {
    for (const auto& entry : fs::directory_iterator(copy_))
      EXPECT_TRUE(fs::exists(fs::symlink_status(kept_ / entry.path().filename())) ||
                  entry.path().filename() == "candidate")
          << entry.path().filename() << " is lost";
    for (const auto& entry : fs::directory_iterator(kept_)) {
      if (!entry.is_regular_file() || entry.path().extension() != ".yaml") continue;
      EXPECT_NO_THROW(loadCalibration(entry.path())) << entry.path();
    }
    for (const char* link : {"active", "candidate"})
      if (!target(kept_ / link).empty()) {
        EXPECT_TRUE(fs::exists(kept_ / link)) << link << " leads nowhere";
      }
  }

  void sweep(const std::string& command) {
    SCOPED_TRACE(command);
    copyTree(kept_, copy_);
    const std::string list = textOf((kept_ / "promotions").string()), before = target(kept_ / "active");
    const Answer plain = typedOn({}, command);
    ASSERT_EQ(plain.status, 0) << plain.error;
    const std::vector<DiskFault> all = faults(reads(), writes());
    const std::string wanted = target(kept_ / "active"), candidate = target(kept_ / "candidate");
    int refused = 0;
    for (const DiskFault& fault : all) {
      SCOPED_TRACE(fault.inWords());
      copyTree(copy_, kept_);
      const Answer answer = typedOn(fault, command);
      const std::string active = target(kept_ / "active");
      EXPECT_TRUE(active == before || active == wanted) << active;
      if (answer.status == 0) {
        EXPECT_EQ(active, wanted);
        EXPECT_EQ(target(kept_ / "candidate").empty(), candidate.empty());
      } else {
        ++refused;
        expectOneLine(answer, fault);
      }
      EXPECT_EQ(textOf((kept_ / "promotions").string()).rfind(list, 0), 0u) << "lines of the list are lost";
      everyCalibrationIsWhole();
      // Typed again it goes on, and no temporary file of before is left.
      if (answer.status != 0 && active == before) {
        run(command);
        EXPECT_EQ(target(kept_ / "active"), wanted);
        for (const auto& entry : fs::directory_iterator(kept_))
          EXPECT_EQ(entry.path().filename().string().find(".mm-tmp-"), std::string::npos) << entry.path();
      }
      if (HasFailure()) return;
    }
    std::printf("%5zu runs, %5d refused: mm %s\n", all.size(), refused, command.c_str());
    EXPECT_GT(refused, static_cast<int>(all.size()) / 4);
    copyTree(copy_, kept_);
  }

  fs::path kept_, copy_;
};

TEST_F(FailingStore, PromoteOfAFile) {
  run("add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o more.yaml --force");
  sweep("promote more.yaml --store kept");
}
TEST_F(FailingStore, PromoteOfAnId) {
  std::string id;
  for (const auto& entry : fs::directory_iterator(kept_))
    if (entry.is_regular_file() && entry.path().extension() == ".yaml" &&
        entry.path().filename() != target(kept_ / "active"))
      id = entry.path().stem().string();
  sweep("promote " + id + " --store kept");
}
TEST_F(FailingStore, Rollback) { sweep("rollback --store kept"); }

}  // namespace
}  // namespace mm
