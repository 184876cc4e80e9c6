#include "nodes/time_watch.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

TEST(NextLife, BeginsBeyondTheLastStampThatTheOneBeforeSaid) {
  constexpr double kStored = 1.7e9;  // s
  for (const double factor : {0.001, 1.0, 10.0, 1000.0}) {
    const double last = kStored + 1.0 * factor;  // it died just before it would have stored again
    EXPECT_GT(nextLife(kStored, factor), last) << factor;
    EXPECT_LT(nextLife(kStored, factor), last + 2.0 * factor) << "time does not leap either";
  }
}

}  // namespace
}  // namespace mm
