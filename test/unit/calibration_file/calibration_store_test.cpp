#include "calibration_file/calibration_store.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <random>

#include "base/error.h"
#include "base/read_file.h"
#include "calibration_file/atomic_file.h"
#include "example_calibration.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class Store : public testing::Test {
 protected:
  Store() : folder_(fs::temp_directory_path() / ("mm_store_" + std::to_string(::getpid()))), store_(folder_) {
    fs::remove_all(folder_);
  }
  ~Store() override { fs::remove_all(folder_); }

  std::string add(double rms) {
    Calibration c = test::exampleCalibration(rms);
    return store_.add(c);
  }
  void damage(const std::string& id) {
    std::fstream file(folder_ / (id + ".yaml"), std::ios::in | std::ios::out);
    file.seekp(500);
    file.put('#');
  }
  double activeRms() { return store_.active().calibration->rms; }

  fs::path folder_;
  CalibrationStore store_;
};

TEST_F(Store, isEmptyWithoutAFolder) {
  EXPECT_FALSE(store_.active().calibration.has_value());
  EXPECT_FALSE(store_.candidate().calibration.has_value());
  EXPECT_TRUE(store_.history().empty());
  EXPECT_THROW(store_.promote(), InputError);
  EXPECT_THROW(store_.rollback(), InputError);
}

TEST_F(Store, NothingLeadsBackToWhatWasNeverActive) {
  add(1e-6);
  const std::string active = store_.promote(), never = add(2e-6);
  try {
    store_.rollback(never);
    ADD_FAILURE() << "it was never active";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("was never active"), std::string::npos) << e.what();
  }
  EXPECT_EQ(store_.linked("active"), active);
  fs::remove(folder_ / "promotions");  // as of a folder whose record was lost
  EXPECT_EQ(store_.rollback(active), active);
}

TEST_F(Store, keepsPromotesAndRollsBack) {
  const std::string first = add(1e-6);
  EXPECT_FALSE(store_.active().calibration.has_value());
  EXPECT_EQ(store_.candidate().calibration->rms, 1e-6);
  EXPECT_EQ(store_.promote(), first);
  EXPECT_EQ(activeRms(), 1e-6);
  EXPECT_FALSE(store_.candidate().calibration.has_value());

  const std::string second = add(2e-6), third = add(3e-6);
  EXPECT_EQ(activeRms(), 1e-6);
  EXPECT_EQ(store_.candidate().calibration->id, third);
  EXPECT_EQ(store_.promote(second), second);
  EXPECT_EQ(store_.promote(), third);
  EXPECT_EQ(activeRms(), 3e-6);
  EXPECT_EQ(store_.rollback(), second);
  EXPECT_EQ(store_.rollback(), first);
  EXPECT_EQ(activeRms(), 1e-6);
  EXPECT_THROW(store_.rollback(), InputError);
  EXPECT_EQ(store_.rollback(third), third);
  EXPECT_EQ(store_.rollback(), first);

  const auto history = store_.history();
  ASSERT_EQ(history.size(), 3u);
  int active = 0;
  for (const auto& entry : history) active += entry.active && entry.id == first;
  EXPECT_EQ(active, 1);
}

TEST_F(Store, givesTwoCalibrationsOfOneIdTwoFiles) {
  Calibration a = test::exampleCalibration(1e-6), b = test::exampleCalibration(2e-6);
  a.id = b.id = "mine";
  EXPECT_EQ(store_.add(a), "mine");
  EXPECT_EQ(store_.add(a), "mine");
  EXPECT_EQ(store_.add(b), "mine-2");
  EXPECT_EQ(store_.load("mine").rms, 1e-6);
  EXPECT_EQ(store_.load("mine-2").rms, 2e-6);
}

TEST_F(Store, refusesIdsThatLeadElsewhere) {
  add(1e-6);
  for (const char* id : {"../active", "a/b", ".hidden", "a b"})
    EXPECT_THROW(store_.promote(id), InputError) << id;
  EXPECT_THROW(store_.promote("absent"), InputError);
}

TEST_F(Store, refusesADamagedFileByNameAndKeepsTheLastGoodOneActive) {
  const std::string first = add(1e-6);
  store_.promote();
  const std::string second = add(2e-6);
  store_.promote();
  const std::string third = add(3e-6);
  damage(third);
  EXPECT_THROW(store_.promote(third), InputError);
  EXPECT_NE(store_.candidate().warning.find(third), std::string::npos);
  EXPECT_EQ(activeRms(), 2e-6);

  damage(second);
  const auto active = store_.active();
  ASSERT_TRUE(active.calibration.has_value());
  EXPECT_EQ(active.calibration->rms, 1e-6);
  EXPECT_NE(active.warning.find(second + ".yaml"), std::string::npos) << active.warning;
  EXPECT_NE(active.warning.find("'" + first + "' is active instead"), std::string::npos) << active.warning;
  EXPECT_TRUE(store_.active().warning.empty());  // it stays so
  EXPECT_EQ(fs::read_symlink(folder_ / "active"), first + ".yaml");

  fs::remove(folder_ / (first + ".yaml"));
  EXPECT_THROW(store_.active(), InputError);
}

TEST_F(Store, namesTheDefaultFolder) {
  ::setenv("MM_CALIBRATIONS", "/tmp/mine", 1);
  EXPECT_EQ(CalibrationStore::defaultFolder(), "/tmp/mine");
  ::unsetenv("MM_CALIBRATIONS");
  ::setenv("HOME", "/somewhere", 1);
  EXPECT_EQ(CalibrationStore::defaultFolder(), "/somewhere/.measuring_machine/calibrations");
}

TEST_F(Store, losesNothingWhenKilledAtAnyMoment) {
  add(0.0);
  store_.promote();
  std::mt19937 random(5);
  std::uniform_int_distribution<int> wait(0, 30000);
  int last = 0;  // number of the last calibration that is known to be active
  for (int kill = 0; kill < 20; ++kill) {
    int report[2];
    ASSERT_EQ(::pipe(report), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      for (int i = last + 1;; ++i) {
        Calibration c = test::exampleCalibration(i);
        store_.add(c);
        store_.promote();
        if (::write(report[1], &i, sizeof i) != sizeof i) _exit(1);
      }
    }
    ::close(report[1]);
    ASSERT_EQ(::read(report[0], &last, sizeof last), static_cast<ssize_t>(sizeof last));  // at work by now
    ::usleep(static_cast<useconds_t>(wait(random)));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    while (::read(report[0], &last, sizeof last) == static_cast<ssize_t>(sizeof last)) {
    }
    ::close(report[0]);

    const auto active = store_.active();
    ASSERT_TRUE(active.calibration.has_value());
    EXPECT_TRUE(active.warning.empty()) << active.warning;
    // The one that was reported, or the one that was being promoted when the writer was killed.
    EXPECT_TRUE(active.calibration->rms == last || active.calibration->rms == last + 1)
        << active.calibration->rms << " after " << last;
    last = static_cast<int>(active.calibration->rms);
    const auto history = store_.history();
    EXPECT_GT(history.size(), static_cast<std::size_t>(last));
    for (const auto& entry : history) EXPECT_TRUE(entry.damaged.empty()) << entry.damaged;
  }
  add(99e-6);
  store_.promote();
  EXPECT_EQ(activeRms(), 99e-6);
  for (const auto& item : fs::directory_iterator(folder_))
    EXPECT_EQ(item.path().string().find(kTemporaryMark), std::string::npos) << item.path();
}

TEST_F(Store, linksLeadToItsOwnCalibrationsAlone) {
  const std::string own = add(1e-6);
  store_.promote(own);
  const fs::path elsewhere = folder_ / "elsewhere";
  fs::create_directories(elsewhere);
  fs::copy_file(folder_ / (own + ".yaml"), elsewhere / "foreign.yaml");
  // By its whole path it is a calibration of the folder all the same.
  fs::remove(folder_ / "active");
  fs::create_symlink(fs::canonical(folder_) / (own + ".yaml"), folder_ / "active");
  EXPECT_EQ(activeRms(), 1e-6);
  // Elsewhere it is not, even where one of that name is here, too.
  fs::rename(elsewhere / "foreign.yaml", elsewhere / (own + ".yaml"));
  fs::remove(folder_ / "active");
  fs::create_symlink("elsewhere/" + own + ".yaml", folder_ / "active");
  EXPECT_THROW(store_.active(), InputError);
  EXPECT_FALSE(store_.history().front().active);
  // A calibration that is a link is kept, and listed.
  fs::create_symlink("elsewhere/" + own + ".yaml", folder_ / "linked.yaml");
  EXPECT_EQ(store_.history().size(), 2u);
  fs::create_symlink("nowhere.yaml", folder_ / "dangling.yaml");
  int damaged = 0;
  for (const auto& entry : store_.history()) damaged += !entry.damaged.empty();
  EXPECT_EQ(damaged, 1);
  EXPECT_EQ(store_.promote(own), own) << "mends the link";
  EXPECT_EQ(activeRms(), 1e-6);
}

TEST_F(Store, whoPromotesMayRefuse) {
  const std::string first = add(1e-6), second = add(2e-6);
  store_.promote(first);
  const auto refuse = [](const Calibration&) { throw InputError("of another machine"); };
  EXPECT_THROW(store_.promote(second, refuse), InputError);
  EXPECT_EQ(activeRms(), 1e-6);
  store_.promote(second);
  EXPECT_THROW(store_.rollback({}, refuse), InputError);
  EXPECT_EQ(activeRms(), 2e-6);
}

// Reading /proc/self/mem from its beginning is EIO, as of a disk that fails for a moment.
TEST_F(Store, AReadThatFailsRollsNothingBack) {
  const std::string first = add(1e-6), second = add(2e-6), third = add(3e-6);
  for (const std::string& id : {first, second, third}) store_.promote(id);
  const fs::path file = folder_ / (third + ".yaml"), aside = folder_ / "aside";
  fs::rename(file, aside);
  fs::create_symlink("/proc/self/mem", file);
  const CalibrationStore::Active found = store_.active();
  ASSERT_TRUE(found.calibration);
  EXPECT_EQ(found.calibration->id, second);
  EXPECT_NE(found.warning.find("Input/output error"), std::string::npos) << found.warning;
  EXPECT_NE(found.warning.find("for this program only"), std::string::npos) << found.warning;
  EXPECT_EQ(store_.linked("active"), third);
  fs::rename(aside, file);
  EXPECT_EQ(activeRms(), 3e-6);

  const fs::path before = folder_ / (second + ".yaml");
  fs::rename(before, aside);
  fs::create_symlink("/proc/self/mem", before);
  EXPECT_THROW(store_.rollback(), UnreadableFile) << "the one before that was not asked for";
  EXPECT_EQ(store_.linked("active"), third);
  fs::rename(aside, before);
  EXPECT_EQ(store_.rollback(), second);
}

}  // namespace
}  // namespace mm
