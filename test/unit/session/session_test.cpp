#include "session/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "session_files.h"

namespace mm {
namespace {

using ::testing::HasSubstr;

Session contacts(int count) {
  Session s(Machine::load("three_axis"));
  s.source = "made.bag";
  Feature ball;
  ball.name = "b0";
  ball.radius = 4e-3;
  s.artifact.features.push_back(ball);
  for (int i = 0; i < count; ++i) {
    Observation o;
    o.time = i;
    o.row = i + 1;
    o.position = {0.0, 0.0, 0.0};
    o.feature = 0;
    s.observations.push_back(o);
  }
  return s;
}

std::string refusal(Session s) {
  return test::messageOf<InputError>([&] { s.prepare(); });
}

TEST(Session, RefusesBadValuesByRow) {
  Session s = contacts(3);
  s.observations[1].position[2] = NAN;
  EXPECT_THAT(refusal(s), HasSubstr("made.bag: row 2: the reading of joint 'z'"));
  s = contacts(3);
  s.observations[2].feature = 1;
  EXPECT_THAT(refusal(s), HasSubstr("row 3: its feature"));
  s = contacts(1);
  s.observations[0].position.pop_back();
  EXPECT_THAT(refusal(s), HasSubstr("2 joint readings"));
  s = contacts(1);
  s.observations[0].time = INFINITY;
  EXPECT_THAT(refusal(s), HasSubstr("time"));
  s = contacts(1);
  s.observations[0].kind = ObservationKind::kPosition;
  EXPECT_THAT(refusal(s), HasSubstr("no component"));
  s = contacts(1);
  s.temperatures.push_back({"bed", "degC", {1.0, 0.0}, {20.0, 20.0}});
  EXPECT_THAT(refusal(s), HasSubstr("'bed' is not ascending"));
  EXPECT_THAT(refusal(contacts(0)), HasSubstr("the session is empty"));
}

TEST(Session, PreparingTwiceChangesNothing) {
  Session s = contacts(3);
  s.observations[0].velocity = {1.0, NAN, 0.0};
  s.observations[1].velocity = {0.0, NAN, -1.0};
  s.observations[2].velocity = {0.0, NAN, 0.0};
  s.prepare();
  const auto first = s.observations[2].travel;
  EXPECT_EQ(first, (std::vector<double>{1.0, 0.0, -1.0}));
  s.prepare();
  EXPECT_EQ(s.observations[2].travel, first);
}

TEST(Session, OrdersSeriesAndSetupsAlikeWhateverTheirOrigin) {
  Session s = contacts(2);
  for (Observation& o : s.observations) {
    o.kind = ObservationKind::kDeviation;
    o.feature = -1;
    o.deviation = {1e-6, NAN, NAN};
  }
  s.setups = {"unused", "late", "early"};
  s.observations[0].setup = 2;
  s.observations[1].setup = 1;
  s.temperatures = {{"z", "degC", {0.0}, {20.0}}, {"empty", "degC", {}, {}}, {"a", "degC", {0.0}, {20.0}}};
  s.prepare();
  EXPECT_EQ(s.setups, (std::vector<std::string>{"early", "late"}));
  EXPECT_EQ(s.observations[0].setup, 0);
  ASSERT_EQ(s.temperatures.size(), 2u);
  EXPECT_EQ(s.temperatures[0].name, "a");
}

TEST(Session, AFreeBallWithoutAStartGetsOneFromItsContacts) {
  const double r = 5e-3;  // ball and tip together
  Session s = contacts(6);
  s.artifact.features[0].known = false;
  s.artifact.features[0].position.setConstant(kNotMeasured);
  for (int i = 0; i < 6; ++i) {  // only the upper half, as on a plate
    const double azimuth = i, elevation = 0.25 * i;
    s.observations[i].position = {1e-3 + r * std::cos(elevation) * std::cos(azimuth),
                                  2e-3 + r * std::cos(elevation) * std::sin(azimuth),
                                  3e-3 + r * std::sin(elevation)};
  }
  s.prepare();
  EXPECT_LT((s.artifact.features[0].position - Eigen::Vector3d(1e-3, 2e-3, 3e-3)).norm(), 1e-9);
}

TEST(Series, IsLinearBetweenStampsAndConstantBeyond) {
  const Series s{"bed", "degC", {0.0, 10.0, 10.0, 20.0}, {20.0, 30.0, 40.0, 50.0}};
  EXPECT_DOUBLE_EQ(s.at(5.0), 25.0);
  EXPECT_DOUBLE_EQ(s.at(10.0), 30.0);
  EXPECT_DOUBLE_EQ(s.at(15.0), 45.0);
  EXPECT_DOUBLE_EQ(s.at(-5.0), 20.0);
  EXPECT_DOUBLE_EQ(s.at(25.0), 50.0);
  EXPECT_TRUE(std::isnan(Series{}.at(0.0)));
}

}  // namespace
}  // namespace mm
