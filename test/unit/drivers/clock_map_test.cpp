#include "drivers/clock_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mm {
namespace {

TEST(ClockMap, FollowsTheFastestStatesOfADriftingClock) {
  std::mt19937 random(1);
  std::exponential_distribution<double> wait(1.0 / 2e-3);
  ClockMap map;
  double worst = 0.0, before = -1e9;
  for (int i = 0; i < 60000; ++i) {
    const double truth = 1000.0 + 1e-3 * i, device = (truth - 900.0) * (1.0 + 50e-6);
    map.add(device, truth + 0.1e-3 + wait(random));
    const double mapped = map.toHost(device);
    ASSERT_GT(mapped, before) << "mapped times ascend";
    before = mapped;
    if (i > 10000) worst = std::max(worst, std::abs(mapped - truth));
  }
  EXPECT_LT(worst, 1.0e-3) << "the smallest delay, and the drift within the window: 50 ppm of 10 s";
}

TEST(ClockMap, SaysHowLateStatesAre) {
  ClockMap map;
  for (int i = 0; i < 1000; ++i) map.add(0.01 * i, 50.0 + 0.01 * i + 1e-3);
  EXPECT_NEAR(map.late(), 0.0, 1e-9);
  map.add(10.0, 60.0 + 0.3);
  EXPECT_NEAR(map.late(), 0.299, 1e-3);
  map.add(0.5, 70.0);  // the device began again
  EXPECT_NEAR(map.toHost(0.5), 70.0, 1e-12);
}

/// A process that stood still for three seconds reads what was sent meanwhile all at once.
TEST(ClockMap, BeginsWithStatesThatWaited) {
  ClockMap map;
  for (int i = 0; i < 300; ++i) map.add(0.01 * i, 53.0 + 1e-6 * i);
  EXPECT_NEAR(map.toHost(2.99), 53.0, 2.1e-2) << "the last of them came as it was made";
  for (int i = 300; i < 400; ++i) map.add(0.01 * i, 50.0 + 0.01 * i);
  EXPECT_NEAR(map.toHost(4.0), 54.0, 2.1e-2);
}

}  // namespace
}  // namespace mm
