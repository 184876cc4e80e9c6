#include "ros_bridge/axis_messages.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace mm {
namespace {

measuring_machine::ProbeLatch latch(const std::vector<std::string>& names, double time, double velocity,
                                    double uncertainty = 1e-6) {
  measuring_machine::ProbeLatch message;
  message.header.stamp = ros::Time(time);
  message.closed = true;
  message.name = names;
  message.position.assign(names.size(), 0.001);
  message.velocity.assign(names.size(), velocity);
  message.laser_reading = std::nan("");
  message.time_uncertainty = uncertainty;
  return message;
}

TEST(JoinLatches, SynchronisedLatchesOfTwoControllersAreOneContact) {
  const Machine machine = Machine::load("three_axis");
  const auto first = latch({"x", "y"}, 100.0, 3e-3);
  const std::vector<measuring_machine::ProbeLatch> others = {latch({"z"}, 99.0, 0.0),
                                                             latch({"z"}, 100.00001, 3e-3)};
  const auto joined = joinLatches(first, others, machine, {});
  EXPECT_EQ(joined.name, (std::vector<std::string>{"x", "y", "z"}));
  EXPECT_EQ(joined.velocity[2], 3e-3) << "the latch of the same trip, not the earlier one";
  EXPECT_EQ(toContactMessage(joined, machine).position.size(), 3u);
}

TEST(JoinLatches, ThoseThatAreNotSynchronisedAreRefused) {
  const Machine machine = Machine::load("three_axis");
  const auto first = latch({"x", "y"}, 100.0, 3e-3);
  for (const auto& other : {latch({"z"}, 100.001, 3e-3), latch({"z"}, 100.0, 3e-3, 1e-3)}) {
    try {
      joinLatches(first, {other}, machine, {});
      FAIL() << "3 um of way between the latches";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("joint 'z' was latched by another controller"), std::string::npos)
          << e.what();
    }
  }
  EXPECT_EQ(joinLatches(first, {latch({"z"}, 100.001, 0.0)}, machine, {}).name.size(), 3u)
      << "a joint at rest";
  EXPECT_THROW(toContactMessage(joinLatches(first, {}, machine, {}), machine), InputError)
      << "not latched at all";
}

}  // namespace
}  // namespace mm
