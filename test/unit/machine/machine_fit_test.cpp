#include "machine/machine_fit.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

class MachineFit : public ::testing::Test {
 protected:
  std::string differenceWith(const std::string& what, const std::string& by) const {
    return differenceOf(machine_, Machine(replaced(machine_.urdf(), what, by), "copy"), "here");
  }
  Machine machine_ = Machine::load("three_axis");
};

TEST_F(MachineFit, commentsLooksAndLimitsDoNotCount) {
  EXPECT_EQ(differenceWith("<!-- Three", "<!-- A copy of three"), "");
  EXPECT_EQ(differenceWith("lower=\"-0.020\"", "lower=\"-0.019\""), "");
  EXPECT_EQ(differenceWith("rgba=\"0.55 0.6 0.65 1\"", "rgba=\"1 0 0 1\""), "");
}

TEST_F(MachineFit, whatTheChainDependsOnIsNamed) {
  EXPECT_EQ(
      differenceWith("<parent link=\"z_slide\"/><child link=\"probe_tip\"/>",
                     "<parent link=\"z_slide\"/><child link=\"probe_tip\"/><origin xyz=\"0.003 0 -0.010\"/>"),
      "its probe's tip stands at (0, 0, 0) mm, here at (3, 0, -10) mm");
  EXPECT_EQ(differenceWith("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 -1 0\"/>"),
            "joint y moves along (0, 1, 0), here along (0, -1, 0)");
  EXPECT_EQ(differenceWith("<joint name=\"z\"", "<joint name=\"w\""),
            "it has the joints x, y, z, here there are x, y, w");
  EXPECT_EQ(
      differenceWith("<parent link=\"x_slide\"/>", "<parent link=\"x_slide\"/><origin xyz=\"0 0 0.001\"/>"),
      "joint y stands at (0, 0, 0) mm, here at (0, 0, 1) mm");
  EXPECT_NE(differenceWith("<parent link=\"z_slide\"/><child link=\"probe_tip\"/>",
                           "<parent link=\"z_slide\"/><child link=\"probe_tip\"/><origin rpy=\"0 0.1 0\"/>"),
            "");
}

/// A joint that is turned about its own axis moves the tip as before, but its errors act along other
/// directions.
TEST_F(MachineFit, aJointMountedTurnedAboutItsOwnAxisIsAnother) {
  EXPECT_EQ(
      differenceWith("<parent link=\"workpiece\"/>", "<parent link=\"workpiece\"/><origin rpy=\"0.5 0 0\"/>"),
      "joint y is mounted turned otherwise than here");
}

TEST_F(MachineFit, serialsCountWhereBothStateOne) {
  const auto withSerial = [&](const std::string& serial) {
    return Machine(replaced(machine_.urdf(), "</robot>", "<serial>" + serial + "</serial></robot>"),
                   "three_axis");
  };
  EXPECT_EQ(serialOf(withSerial("MM-7")), "MM-7");
  EXPECT_EQ(serialOf(machine_), "");
  EXPECT_EQ(differenceOf(withSerial("MM-7"), withSerial("MM-8"), "here"),
            "its serial is 'MM-7', here 'MM-8'");
  EXPECT_EQ(differenceOf(withSerial("MM-7"), withSerial("MM-7"), "here"), "");
  EXPECT_EQ(differenceOf(withSerial("MM-7"), machine_, "here"), "");
}

/// Two machines that were typed with the same axes differ in nothing else; a serial that both state is more
/// than a name.
TEST_F(MachineFit, namesCountWhereNoSerialDecides) {
  EXPECT_EQ(differenceWith("<robot name=\"three_axis\">", "<robot name=\"another\">"),
            "its URDF calls it 'three_axis', here it is 'another'");
  const std::string urdf = replaced(machine_.urdf(), "</robot>", "<serial>MM-7</serial></robot>");
  const Machine renamed(replaced(urdf, "<robot name=\"three_axis\">", "<robot name=\"another\">"), "copy");
  EXPECT_EQ(differenceOf(Machine(urdf, "three_axis"), renamed, "here"), "");
}

}  // namespace
}  // namespace mm
