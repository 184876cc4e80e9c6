#include "nodes/homing_watch.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

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
  EXPECT_TRUE(watch.take(0, {true, kFirst})) << "how it moved before is not known";
  EXPECT_TRUE(watch.take(1, {true, kSecond}));
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(watch.take(0, {true, kFirst}));
    EXPECT_FALSE(watch.take(1, {true, kSecond}));
    EXPECT_EQ(watch.zero(), kSecond);
  }
}

TEST(HomingWatch, AnotherHomingAndAnotherLifeAreAnotherZero) {
  HomingWatch watch(1);
  watch.take(0, {false, 0});
  EXPECT_TRUE(watch.take(0, {true, kFirst}));
  EXPECT_TRUE(watch.take(0, {true, kSecond})) << "homed while nobody listened";
  EXPECT_TRUE(watch.take(0, {false, 0})) << "killed and started again";
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
