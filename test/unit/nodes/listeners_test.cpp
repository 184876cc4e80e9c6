#include "nodes/listeners.h"

#include <gtest/gtest.h>

#include <thread>

namespace mm {
namespace {

using std::chrono::milliseconds;

TEST(Listeners, AConnectionThatComesAfterTheGoalIsWaitedFor) {
  Listeners listeners;
  const auto goesOn = [] { return false; };
  EXPECT_FALSE(listeners.listensWithin("/measure", milliseconds(1), goesOn));
  EXPECT_FALSE(listeners.listensWithin("/measure", milliseconds(20000), [] { return true; })) << "cancelled";
  std::thread late([&] { listeners.came("/measure"); });
  EXPECT_TRUE(listeners.listensWithin("/measure", milliseconds(20000), goesOn));
  late.join();
  EXPECT_FALSE(listeners.listens("/other"));
}

TEST(Listeners, ANodeThatComesAgainBeforeItsOldConnectionEndedListens) {
  Listeners listeners;
  listeners.came("/measure");
  listeners.came("/measure");
  listeners.left("/measure");
  EXPECT_TRUE(listeners.listens("/measure"));
  listeners.left("/measure");
  EXPECT_FALSE(listeners.listens("/measure"));
}

}  // namespace
}  // namespace mm
