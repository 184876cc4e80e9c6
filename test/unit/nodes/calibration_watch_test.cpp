#include "nodes/calibration_watch.h"

#include <gtest/gtest.h>

#include "calibration_file/calibration_yaml.h"
#include "compensation_support.h"
#include "session_files.h"

namespace mm {
namespace {

Machine machineAt(double tip) {
  std::string urdf = Machine::load("three_axis").urdf();
  const std::string mount = "<child link=\"probe_tip\"/>";
  urdf.insert(urdf.find(mount) + mount.size(), "<origin xyz=\"0 0 " + std::to_string(tip) + "\"/>");
  return Machine(urdf, "three_axis");
}

class CalibrationWatchTest : public ::testing::Test {
 protected:
  std::string add(const Machine& machine, const std::string& space, double scale) {
    Calibration c = test::calibrationOf(machine, {EffectSpec("scale").set("axis", "x")});
    c.id.clear();
    c.created.clear();
    c.software.clear();
    c.sessionSpace = space;
    c.values[0].value = scale;
    return store_.add(c);
  }
  CalibrationWatch watchOf(const Machine& machine, const std::string& space) {
    return CalibrationWatch(store_, machine, space, 0.1);
  }
  test::Folder folder_;
  CalibrationStore store_{folder_.path("store")};
};

/// A copy of the URDF in which the probe stands elsewhere: its calibration is none of this machine.
TEST_F(CalibrationWatchTest, ACalibrationOfAShiftedProbeIsNotApplied) {
  store_.promote(add(machineAt(0.01044), "/", 1e-4));
  CalibrationWatch watch = watchOf(machineAt(0.0), "/");
  const auto pair = watch.refresh();
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->active, nullptr);
  EXPECT_NE(pair->warning.find("its probe's tip stands at (0, 0, 10.44) mm, here at (0, 0, 0) mm"),
            std::string::npos)
      << pair->warning;
  EXPECT_NE(watchOf(machineAt(0.01044), "/").refresh()->active, nullptr);
}

TEST_F(CalibrationWatchTest, WhatFitsStaysInUseBesideOneOfAnotherMachine) {
  const std::string own = add(machineAt(0.0), "/m2", 1e-4);
  store_.promote(own);
  CalibrationWatch watch = watchOf(machineAt(0.0), "/m2");
  ASSERT_EQ(watch.refresh()->active->id, own);
  store_.promote(add(machineAt(0.0), "/m1", 2e-4));
  const auto pair = watch.refresh();
  ASSERT_TRUE(pair && pair->active);
  EXPECT_EQ(pair->active->id, own);
  EXPECT_NE(pair->warning.find("namespace /m1, this machine is in /m2"), std::string::npos) << pair->warning;
  EXPECT_NE(pair->warning.find("'" + own + "', read before, stays in use"), std::string::npos);
  add(machineAt(0.0), "/m1", 3e-4);
  EXPECT_NE(watch.refresh()->candidateWarning.find("of another machine"), std::string::npos);
}

TEST_F(CalibrationWatchTest, ALinkThatLeadsOutOfTheFolderIsNotFollowed) {
  const std::string own = add(machineAt(0.0), "/", 1e-4);
  store_.promote(own);
  CalibrationStore other(folder_.path("other"));
  std::filesystem::create_directories(other.folder());
  std::filesystem::copy_file(store_.folder() / (own + ".yaml"), other.folder() / "foreign.yaml");
  std::filesystem::remove(store_.folder() / "active");
  std::filesystem::create_symlink("../other/foreign.yaml", store_.folder() / "active");
  CalibrationWatch watch = watchOf(machineAt(0.0), "/");
  const auto pair = watch.refresh();
  EXPECT_EQ(pair->active, nullptr);
  EXPECT_NE(pair->warning.find("leads to ../other/foreign.yaml, which is not in that folder"),
            std::string::npos)
      << pair->warning;
  EXPECT_EQ(store_.promote(own), own) << "which mends it";
  EXPECT_EQ(watch.refresh()->active->id, own);
}

// A disk that does not give a file once: reading /proc/self/mem from its beginning is EIO.
TEST_F(CalibrationWatchTest, WhatTheDiskDidNotGiveIsAskedForAgain) {
  const std::string first = add(machineAt(0.0), "/", 1e-4);
  store_.promote(first);
  const std::string second = add(machineAt(0.0), "/", 2e-4);
  store_.promote(second);
  CalibrationWatch watch = watchOf(machineAt(0.0), "/"), begun = watchOf(machineAt(0.0), "/");
  ASSERT_EQ(watch.refresh()->active->id, second);
  const std::string third = add(machineAt(0.0), "/", 3e-4);
  store_.promote(third);
  const std::filesystem::path file = store_.folder() / (third + ".yaml"), aside = store_.folder() / "aside";
  std::filesystem::rename(file, aside);
  std::filesystem::create_symlink("/proc/self/mem", file);
  auto pair = watch.refresh();
  ASSERT_TRUE(pair && pair->active);
  EXPECT_EQ(pair->active->id, second) << "what was read before stays in use";
  EXPECT_NE(pair->warning.find("Input/output error"), std::string::npos) << pair->warning;
  pair = begun.refresh();
  ASSERT_TRUE(pair && pair->active);
  EXPECT_EQ(pair->active->id, second) << "the one before, until it is given";
  EXPECT_EQ(store_.linked("active"), third) << "nothing is rolled back for a read that failed";
  for (CalibrationWatch* one : {&watch, &begun})
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(one->refresh()) << "said once";
  std::filesystem::rename(aside, file);
  for (CalibrationWatch* one : {&watch, &begun}) {
    pair = one->refresh();
    ASSERT_TRUE(pair && pair->active);
    EXPECT_EQ(pair->active->id, third);
    EXPECT_EQ(pair->warning, "");
    EXPECT_FALSE(one->refresh());
  }
}

}  // namespace
}  // namespace mm
