#include "drivers/probe_debounce.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

ProbeEdge edgeAt(double time, bool closed, double x = 1.0) {
  ProbeEdge edge;
  edge.time = time;
  edge.closed = closed;
  edge.probing = true;
  edge.position = {x, 0.0, 0.0};
  return edge;
}

class Switch : public ::testing::Test {
 protected:
  std::vector<ProbeEdge> at(double time, const std::vector<ProbeEdge>& edges = {}, bool closed = true,
                            bool probing = true) {
    AxesState state;
    state.time = time;
    state.probeClosed = closed;
    return probe_.take(edges, state, probing);
  }
  ProbeDebounce probe_;
};

TEST_F(Switch, ABouncingTripIsOneAtItsFirstEdge) {
  EXPECT_TRUE(at(10.0, {edgeAt(10.0, true, 1.0)}).empty());
  EXPECT_TRUE(at(10.002, {edgeAt(10.0004, false, 1.1), edgeAt(10.001, true, 1.2)}).empty())
      << "1 ms after the last edge";
  const auto trips = at(10.0031);
  ASSERT_EQ(trips.size(), 1u);
  EXPECT_EQ(trips[0].time, 10.0);
  EXPECT_EQ(trips[0].position[0], 1.0);
  EXPECT_TRUE(at(10.01).empty());
  EXPECT_EQ(probe_.bounces(), 2);
  EXPECT_EQ(probe_.complaint(), "");
}

TEST_F(Switch, ReleaseMayBounceToo) {
  ASSERT_EQ(at(1.01, {edgeAt(1.0, true)}).size(), 1u);
  EXPECT_TRUE(
      at(1.6, {edgeAt(1.500, false), edgeAt(1.501, true), edgeAt(1.502, false)}, false, false).empty());
  const auto second = at(2.01, {edgeAt(2.0, true, 7.0)});
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(second[0].position[0], 7.0);
}

TEST_F(Switch, TouchesThatAreToldTogetherAreTwo) {
  const auto trips = at(2.0, {edgeAt(1.0, true, 1.0), edgeAt(1.1, false), edgeAt(1.2, true, 2.0)});
  ASSERT_EQ(trips.size(), 2u);
  EXPECT_EQ(trips[1].position[0], 2.0);
}

TEST_F(Switch, AJoltIsNoTrip) {
  EXPECT_TRUE(at(1.01, {edgeAt(1.0, true), edgeAt(1.001, false)}, false).empty());
  EXPECT_EQ(probe_.jolts(), 0) << "it may close again";
  EXPECT_TRUE(at(1.03, {}, false).empty());
  EXPECT_EQ(probe_.jolts(), 1);
  EXPECT_NE(probe_.complaint().find("shock"), std::string::npos);
}

TEST_F(Switch, WhatHadNotSettledIsForgotten) {
  at(1.0, {edgeAt(1.0, true)});
  probe_.forget();
  EXPECT_TRUE(at(1.1).empty());
}

TEST_F(Switch, AStuckOneIsNoticed) {
  at(1.0, {}, true, false);
  at(5.9, {}, true, false);
  EXPECT_EQ(probe_.complaint(), "");
  at(6.1, {}, true, false);
  EXPECT_NE(probe_.complaint().find("stuck"), std::string::npos);
}

TEST_F(Switch, HeldAgainstTheBallByTheMoveIsNotStuck) {
  for (double t = 0.0; t < 20.0; t += 1.0) at(t);
  EXPECT_EQ(probe_.complaint(), "");
}

}  // namespace
}  // namespace mm
