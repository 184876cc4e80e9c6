#include "ros_bridge/message_conversion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "ros_bridge/node_support.h"
#include "session_files.h"

namespace mm {
namespace {

using ::testing::HasSubstr;

measuring_machine::ProbeContact contactOfB1() {
  measuring_machine::ProbeContact c;
  c.name = {"x", "y", "z"};
  c.position = {1e-3, 2e-3, 3e-3};
  c.laser_reading = NAN;
  return c;
}

template <typename Message>
std::string refusal(const Message& message) {
  const Machine machine = Machine::load("three_axis");
  return test::messageOf<InputError>([&] { fromMessage(message, machine); });
}

TEST(MessageConversion, ContactsAreCheckedFieldByField) {
  auto c = contactOfB1();
  c.name[2] = "zz";
  EXPECT_THAT(refusal(c), HasSubstr("joint 'zz' is not a joint of machine 'three_axis'"));
  c = contactOfB1();
  c.name[2] = "x";
  EXPECT_THAT(refusal(c), HasSubstr("'x' is given twice"));
  c = contactOfB1();
  c.name.pop_back();
  EXPECT_THAT(refusal(c), HasSubstr("no reading of joint 'z'"));
  c = contactOfB1();
  c.position.pop_back();
  EXPECT_THAT(refusal(c), HasSubstr("'position' has 2 values for 3 joints"));
  c = contactOfB1();
  c.velocity = {1.0};
  EXPECT_THAT(refusal(c), HasSubstr("'velocity' has 1 values"));
  c = contactOfB1();
  c.approach.x = 0.5;
  EXPECT_THAT(refusal(c), HasSubstr("'approach' must be a unit vector"));
  c = contactOfB1();
  EXPECT_EQ(refusal(c), "");
}

TEST(MessageConversion, AnUnknownApproachIsNaN) {
  const Machine machine = Machine::load("three_axis");
  EXPECT_TRUE(fromMessage(contactOfB1(), machine).approach.hasNaN());
  auto c = contactOfB1();
  c.approach.y = 1.0;
  EXPECT_EQ(fromMessage(c, machine).approach, Eigen::Vector3d(0, 1, 0));
}

TEST(MessageConversion, AReferenceIsAPositionOrDeviations) {
  measuring_machine::ReferenceMeasurement r;
  r.name = {"z", "x", "y"};
  r.joint_position = {3.0, 1.0, 2.0};
  r.laser_reading = NAN;
  r.position = {NAN, NAN, NAN};
  EXPECT_THAT(refusal(r), HasSubstr("neither"));
  r.deviation = {NAN, 5e-6, NAN};
  const Machine machine = Machine::load("three_axis");
  const Observation o = fromMessage(r, machine);
  EXPECT_EQ(o.kind, ObservationKind::kDeviation);
  EXPECT_EQ(o.position, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_EQ(o.deviation[0], 5e-6);
  EXPECT_TRUE(std::isnan(o.deviationStd[0]));
  r.position[1] = 0.1;
  EXPECT_THAT(refusal(r), HasSubstr("more than one of"));
}

TEST(MessageConversion, ArtifactsAreCheckedFeatureByFeature) {
  measuring_machine::Artifact a;
  a.repeatability = NAN;
  a.features.resize(1);
  a.features[0].name = "b0";
  a.features[0].position_known = true;
  const auto refused = [&] { return test::messageOf<InputError>([&] { fromMessage(a); }); };
  EXPECT_THAT(refused(), HasSubstr("feature 'b0': 'radius' must be above 0"));
  a.features[0].radius = 4e-3;
  EXPECT_EQ(refused(), "");
  a.features[0].radius_std = -1;
  EXPECT_THAT(refused(), HasSubstr("standard deviation"));
  a.features[0].radius_std = 0;
  a.features.push_back(a.features[0]);
  EXPECT_THAT(refused(), HasSubstr("two features are called 'b0'"));
}

TEST(MessageConversion, StampsAreWholeNanoseconds) {
  EXPECT_EQ(nanoseconds(ros::Time(3, 7)), 3000000007LL);
  EXPECT_EQ(rosTime(3000000007LL), ros::Time(3, 7));
  EXPECT_THROW(rosTime(-1), InputError);
  EXPECT_THROW(rosTime(4294967296LL * 1000000000LL), InputError);
}

TEST(ParameterText, IsWhatOneWritesAndKeepsSmallNumbers) {
  EXPECT_EQ(textOf(XmlRpc::XmlRpcValue("bed 1")), "bed 1");
  EXPECT_EQ(textOf(XmlRpc::XmlRpcValue(12)), "12");
  EXPECT_EQ(textOf(XmlRpc::XmlRpcValue(12.5)), "12.5");
  EXPECT_EQ(textOf(XmlRpc::XmlRpcValue(1e-7)), "1e-07");
  EXPECT_EQ(textOf(XmlRpc::XmlRpcValue(true)), "true");
  XmlRpc::XmlRpcValue list;
  list.setSize(2);
  EXPECT_EQ(textOf(list), std::nullopt);
}

}  // namespace
}  // namespace mm
