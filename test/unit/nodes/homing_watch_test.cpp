#include "nodes/homing_watch.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

using Change = HomingWatch::Change;
constexpr std::int64_t kFirst = 1000, kSecond = 2000;

// before: the last driver that spoke was believed for all
TEST(HomingWatch, OneDriverThatIsNotHomedKeepsTheMachineWithoutAZero) {
  HomingWatch watch(3);
  for (int round = 0; round < 3; ++round) {
    for (const int joint : {0, 1}) watch.take(joint, {true, kFirst});
    watch.take(2, {false, 0});
    EXPECT_TRUE(watch.anyNotHomed());
    for (const int joint : {0, 1}) watch.take(joint, {true, kFirst});
    EXPECT_TRUE(watch.anyNotHomed()) << "whoever spoke last";
  }
  watch.take(2, {true, kSecond});
  EXPECT_FALSE(watch.anyNotHomed());
}

// before: the direction of travel was forgotten at every message
TEST(HomingWatch, DriversThatWereHomedAtDifferentTimesDisturbNoOther) {
  HomingWatch watch(2);
  EXPECT_EQ(watch.take(0, {true, kFirst}), Change::kForget) << "how it moved before is not known";
  EXPECT_EQ(watch.take(1, {true, kSecond}), Change::kForget);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(watch.take(0, {true, kFirst}), Change::kNone);
    EXPECT_EQ(watch.take(1, {true, kSecond}), Change::kNone);
    EXPECT_EQ(watch.zero(), kSecond);
  }
}

TEST(HomingWatch, AHomingThatWasSeenCountsAnewAndAnotherLifeIsForgotten) {
  HomingWatch watch(1);
  watch.take(0, {false, 0});
  EXPECT_EQ(watch.take(0, {true, kFirst}), Change::kCountAnew);
  EXPECT_EQ(watch.take(0, {true, kSecond}), Change::kForget) << "homed while nobody listened";
  EXPECT_EQ(watch.take(0, {false, 0}), Change::kForget) << "killed and started again";
}

TEST(HomingWatch, AStatusCountsWhereTheStatesDoNotSay) {
  HomingWatch watch(2);
  EXPECT_FALSE(watch.anyNotHomed());
  EXPECT_TRUE(watch.isOf(0, kFirst));
  watch.takeStatus(0, {false, 0});
  EXPECT_TRUE(watch.anyNotHomed());
  watch.takeStatus(0, {true, kFirst});
  EXPECT_FALSE(watch.anyNotHomed());
  EXPECT_EQ(watch.zero(), kFirst);
  watch.take(0, {true, kSecond});
  watch.takeStatus(0, {false, 0});  // of the life before
  EXPECT_FALSE(watch.anyNotHomed());
  EXPECT_FALSE(watch.isOf(0, kFirst));
  EXPECT_TRUE(watch.isOf(0, kSecond));
}

}  // namespace
}  // namespace mm
