#include "nodes/joint_owners.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>

namespace mm {
namespace {

constexpr std::int64_t kSecond = 1000000000;
constexpr std::int64_t kStart = 1000 * kSecond;

class JointOwnersTest : public ::testing::Test {
 protected:
  struct Node {
    std::string name;
    boost::shared_ptr<int> states = boost::make_shared<int>(0), statuses = boost::make_shared<int>(0);
  };
  static Node comeUp(const std::string& name) { return {name}; }

  JointOwners::Verdict state(const Node& node, double t, const std::vector<int>& joints = {0, 1}) {
    return owners_.take({node.name, node.states}, {at(t), told_, homed_, 0}, joints, now_);
  }
  std::string status(const Node& node, double t, bool homed, double homedAt,
                     const std::vector<int>& joints = {0, 1}) {
    return owners_.take({node.name, node.statuses},
                        JointOwners::Status{at(t), homed, homed ? at(homedAt) : 0, joints, {1, -1}}, now_);
  }
  static std::int64_t at(double t) { return kStart + static_cast<std::int64_t>(t * 1e9); }

  JointOwners owners_{{"x", "y"}};
  Node driver_ = comeUp("/axis_driver"), stranger_ = comeUp("/rostopic_1");
  double now_ = 100.0;
  bool told_ = false, homed_ = false;
};

TEST_F(JointOwnersTest, OnlyTheDriverThatSaysSoIsBelieved) {
  EXPECT_EQ(state(stranger_, 0.0).why, "") << "alone, and the first";
  EXPECT_EQ(status(driver_, 1.0, true, 0.5), "");
  EXPECT_EQ(state(driver_, 1.0).why, "");
  const JointOwners::Verdict foreign = state(stranger_, 1.1);
  EXPECT_TRUE(foreign.foreign);
  EXPECT_EQ(
      foreign.why,
      "joint x belongs to /axis_driver, so joint states from /rostopic_1 are ignored; end one of the two");
  EXPECT_TRUE(state(stranger_, 1.1, {1}).foreign) << "of one joint";
  EXPECT_NE(status(comeUp("/play_1"), 1.2, true, 0.5), "") << "a second one that says so";
  ASSERT_NE(state(driver_, 1.2).status, nullptr);
  EXPECT_EQ(state(driver_, 1.3).status->travel, (std::vector<std::int8_t>{1, -1}));
  now_ += 60.0;
  const JointOwners::Verdict late = state(stranger_, 61.0);
  EXPECT_TRUE(late.foreign) << "no driver is replaced by what only sends";
  EXPECT_NE(late.why.find("has stopped"), std::string::npos) << late.why;
  EXPECT_EQ(status(comeUp("/play_1"), 61.0, true, 0.5), "") << "by another one, when it has gone";
}

TEST_F(JointOwnersTest, WithoutADriverThePublisherThatWasFirstIsTheOwnerUntilItHasGone) {
  Node first = comeUp("/joint_state_publisher");
  EXPECT_EQ(state(first, 0.0).why, "");
  EXPECT_TRUE(state(stranger_, 0.1).foreign);
  now_ += 5.0;
  EXPECT_TRUE(state(stranger_, 5.0).foreign) << "a slow one is there, all the same";
  first.states.reset();
  first.statuses.reset();
  const JointOwners::Verdict next = state(stranger_, 5.1);
  EXPECT_EQ(next.why, "");
  EXPECT_TRUE(next.forget);
  EXPECT_FALSE(owners_.anyNotHomed());
}

TEST_F(JointOwnersTest, JointsOfTwoDriversAreTwoOwners) {
  const Node other = comeUp("/y_driver");
  EXPECT_EQ(status(driver_, 0.0, true, -1.0, {0}), "");
  EXPECT_EQ(status(other, 0.0, false, 0.0, {1}), "");
  EXPECT_EQ(state(driver_, 0.0, {0}).why, "");
  EXPECT_EQ(state(other, 0.0, {1}).why, JointOwners::kUnhomed);
  EXPECT_TRUE(owners_.anyNotHomed());
  EXPECT_EQ(status(other, 2.0, true, 2.0, {1}), "");
  EXPECT_EQ(state(other, 2.0, {1}).why, "");
  EXPECT_FALSE(owners_.anyNotHomed());
  EXPECT_EQ(owners_.zero(), at(2.0));
  EXPECT_TRUE(state(driver_, 2.1, {0, 1}).foreign);
}

TEST_F(JointOwnersTest, AStateMustFitTheStatusOfItsDriver) {
  EXPECT_EQ(status(driver_, 0.0, true, -3.0), "");
  EXPECT_EQ(state(driver_, 0.0).why, "");
  EXPECT_EQ(state(driver_, -3600.0).why,
            "a joint state of /axis_driver is stamped 3600.0 s before its status");
  EXPECT_EQ(state(driver_, 3600.0).why, "a joint state of /axis_driver is stamped 3600.0 s after its status");
  EXPECT_EQ(state(driver_, -3.1).why, JointOwners::kUnhomed) << "from before the homing";
  EXPECT_EQ(state(driver_, 4.0).why, "");
}

TEST_F(JointOwnersTest, WhatAStateSaysOfItsHomingCountsBeforeTheStatusHasCome) {
  told_ = homed_ = true;
  EXPECT_EQ(status(driver_, 0.0, true, -3.0), "");
  EXPECT_EQ(state(driver_, 0.0).why, "");
  homed_ = false;
  EXPECT_EQ(state(driver_, 0.1).why, JointOwners::kUnhomed);
  EXPECT_TRUE(owners_.anyNotHomed());
  homed_ = true;  // homed again before any status has come
  const JointOwners::Verdict again = state(driver_, 0.2);
  EXPECT_NE(again.why.find("has not arrived yet"), std::string::npos) << again.why;
  EXPECT_EQ(status(driver_, 0.2, true, 0.2), "");
  const JointOwners::Verdict known = state(driver_, 0.3);
  EXPECT_EQ(known.why, "");
  EXPECT_TRUE(known.forget) << "another zero";
  EXPECT_FALSE(state(driver_, 0.4).forget);
}

TEST_F(JointOwnersTest, ADriverThatCameUpAgainIsNotBelievedByTheStatusOfTheLifeBefore) {
  EXPECT_EQ(status(driver_, 0.0, true, -3.0), "");
  EXPECT_EQ(state(driver_, 0.0).why, "");
  const Node again = comeUp("/axis_driver");
  const JointOwners::Verdict first = state(again, 1.0);
  EXPECT_NE(first.why.find("has not arrived yet"), std::string::npos) << first.why;
  EXPECT_TRUE(first.forget);
  EXPECT_EQ(status(again, 1.0, true, 0.9), "");
  EXPECT_EQ(state(again, 1.1).why, "");
  // once more, its status first
  const Node third = comeUp("/axis_driver");
  EXPECT_EQ(status(third, 2.0, true, 1.9), "");
  EXPECT_EQ(state(third, 2.0).why, "");
  // a connection that broke and is there again: the next status says what it was
  const Node mended{third.name, boost::make_shared<int>(0), third.statuses};
  EXPECT_NE(state(mended, 3.0).why, "");
  EXPECT_EQ(status(mended, 3.5, true, 1.9), "");
  EXPECT_EQ(state(mended, 3.6).why, "");
}

TEST_F(JointOwnersTest, AStatusThatIsOnItsWayIsAwaited) {
  owners_.awaitStatus(105.0);
  EXPECT_NE(state(stranger_, 0.0).why, "");
  EXPECT_FALSE(state(stranger_, 0.0).foreign);
  EXPECT_EQ(status(driver_, 0.0, true, -3.0), "");
  EXPECT_TRUE(state(stranger_, 0.1).foreign);
  EXPECT_EQ(state(driver_, 0.1).why, "");
  JointOwners nobody({"x"});
  nobody.awaitStatus(105.0);
  EXPECT_EQ(nobody.take({"/a", driver_.states}, {kStart, false, false, 0}, {0}, 105.1).why, "")
      << "but not for ever";
}

}  // namespace
}  // namespace mm
