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

TEST(ProbeDebounce, ABouncingTripIsOneContactAtItsFirstEdge) {
  ProbeDebounce probe;
  probe.edge(edgeAt(10.0, true, 1.0));
  probe.edge(edgeAt(10.0004, false, 1.1));
  probe.edge(edgeAt(10.001, true, 1.2));
  EXPECT_FALSE(probe.poll(10.002, true, true)) << "1 ms after the last edge";
  const auto contact = probe.poll(10.0031, true, true);
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->time, 10.0);
  EXPECT_EQ(contact->position[0], 1.0);
  EXPECT_FALSE(probe.poll(10.01, true, true));
  EXPECT_EQ(probe.bounces(), 2);
  EXPECT_EQ(probe.complaint(), "");
}

TEST(ProbeDebounce, ReleaseMayBounceToo) {
  ProbeDebounce probe;
  probe.edge(edgeAt(1.0, true));
  ASSERT_TRUE(probe.poll(1.01, true, true));
  probe.edge(edgeAt(1.500, false));
  probe.edge(edgeAt(1.501, true));
  probe.edge(edgeAt(1.502, false));
  EXPECT_FALSE(probe.poll(1.6, false, false));
  probe.edge(edgeAt(2.0, true, 7.0));
  const auto second = probe.poll(2.01, true, true);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->position[0], 7.0);
}

TEST(ProbeDebounce, AJoltIsNoContact) {
  ProbeDebounce probe;
  probe.edge(edgeAt(1.0, true));
  probe.edge(edgeAt(1.001, false));
  EXPECT_FALSE(probe.poll(1.01, false, true));
  EXPECT_FALSE(probe.poll(1.03, false, true));
  EXPECT_EQ(probe.refused(), 1);
  EXPECT_NE(probe.complaint().find("jolt"), std::string::npos);
}

TEST(ProbeDebounce, OnlyWithALatchedPosition) {
  for (const std::vector<double>& position :
       {std::vector<double>{}, std::vector<double>{1.0, std::nan(""), 0.0}}) {
    ProbeDebounce probe;
    ProbeEdge edge = edgeAt(1.0, true);
    edge.position = position;
    probe.edge(edge);
    EXPECT_FALSE(probe.poll(1.01, true, true));
    EXPECT_NE(probe.complaint().find("latched no position"), std::string::npos);
  }
}

TEST(ProbeDebounce, ATripWithoutAProbingMoveIsACollision) {
  ProbeDebounce probe;
  ProbeEdge edge = edgeAt(1.0, true);
  edge.probing = false;
  probe.edge(edge);
  EXPECT_FALSE(probe.poll(1.01, true, false));
  EXPECT_NE(probe.complaint().find("collision"), std::string::npos);
}

TEST(ProbeDebounce, AStuckProbeIsNoticed) {
  ProbeDebounce probe;
  EXPECT_FALSE(probe.poll(1.0, true, false));
  EXPECT_FALSE(probe.poll(5.9, true, false));
  EXPECT_EQ(probe.complaint(), "");
  EXPECT_FALSE(probe.poll(6.1, true, false));
  EXPECT_NE(probe.complaint().find("stuck"), std::string::npos);
}

TEST(ProbeDebounce, HeldAgainstTheBallByTheMoveIsNotStuck) {
  ProbeDebounce probe;
  for (double t = 0.0; t < 20.0; t += 1.0) probe.poll(t, true, true);
  EXPECT_EQ(probe.complaint(), "");
}

}  // namespace
}  // namespace mm
