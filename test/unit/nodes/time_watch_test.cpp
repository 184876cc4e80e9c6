#include "nodes/time_watch.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

TEST(ClockStart, ADriverThatComesUpAgainNeverTurnsTheClockBack) {
  constexpr double kBegan = 1.7e9, kDied = kBegan + 600.0, kBack = kDied + 1.0;
  for (const double factor : {0.001, 1.0, 10.0, 1000.0}) {
    EXPECT_EQ(clockStart(kBegan, kBegan, factor), kBegan) << "the first";
    const double lastSaid = kBegan + (kDied - kBegan) * factor;  // at most, by the one that died
    EXPECT_GT(clockStart(kBegan, kBack, factor), lastSaid) << factor;
  }
}

TEST(ClockStart, AWallClockThatWasSetBackDoesNotEither) { EXPECT_EQ(clockStart(1.7e9, 1.6e9, 10.0), 1.7e9); }

}  // namespace
}  // namespace mm
