#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "fitted_model.h"
#include "report/iso_tests.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using test::fitted;

constexpr double kPi = 3.14159265358979323846;

/// A circle about a centre 7 um and -4 um beside the nominal one, radial deviation `mean` + 3 cos 2 theta um.
void addTurn(std::vector<CirclePoint>& points, double mean, bool counterClockwise) {
  for (int i = 0; i < 36; ++i) {
    const double angle = kPi / 18.0 * (counterClockwise ? i : 36 - i);
    const double radial = mean + 3.0 * std::cos(2.0 * angle);
    points.push_back(
        {angle, 7.0 + radial * std::cos(angle), -4.0 + radial * std::sin(angle), counterClockwise});
  }
}

// Worked by hand: about its own centre the counter-clockwise path runs from 5 - 3 to 5 + 3 um, the other
// 2 um further out; the least-squares circle of both has a radius 6 um too large.
TEST(ReportCircle, FiguresOfTheStandardWorkedByHand) {
  std::vector<CirclePoint> points;
  addTurn(points, 5.0, true);
  addTurn(points, 7.0, false);
  const CircleFigures f = circleFigures(points, 100.0);
  constexpr double kSmall = 5e-3;
  EXPECT_NEAR(f.counterClockwise.circular, 6.0, kSmall);  // G
  EXPECT_NEAR(f.counterClockwise.largest, 8.0, kSmall);   // F max
  EXPECT_NEAR(f.counterClockwise.smallest, 2.0, kSmall);  // F min
  EXPECT_NEAR(f.clockwise.circular, 6.0, kSmall);
  EXPECT_NEAR(f.clockwise.largest, 10.0, kSmall);
  EXPECT_NEAR(f.clockwise.smallest, 4.0, kSmall);
  EXPECT_NEAR(f.bidirectional, 8.0, kSmall);  // G(b): 10 - 2
  EXPECT_NEAR(f.meanRadial, 6.0, kSmall);     // D
  EXPECT_NEAR(f.hysteresis, 2.0, kSmall);     // H
}

TEST(ReportCircle, OneSenseHasNoHysteresisAndAnArcIsNoCircle) {
  std::vector<CirclePoint> points;
  addTurn(points, 5.0, true);
  const CircleFigures one = circleFigures(points, 100.0);
  EXPECT_NEAR(one.counterClockwise.circular, 6.0, 5e-3);
  EXPECT_TRUE(std::isnan(one.clockwise.circular));
  EXPECT_TRUE(std::isnan(one.hysteresis));
  points.resize(30);  // 60 degrees are missing
  EXPECT_TRUE(std::isnan(circleFigures(points, 100.0).counterClockwise.circular));
}

/// What an instrument in the plane of x and y finds on a circle of 15 mm, both ways: x leans by `lean` (rad)
/// as y moves, and x has play of `gap` (m).
Session circleSession(double lean, double gap) {
  Session session(Machine::load("three_axis"));
  session.source = "circle.csv";
  for (int i = 0; i < 144; ++i) {
    const bool ccw = i < 72;
    const double angle = kPi / 36.0 * (ccw ? i : 72 - (i - 72)), sense = ccw ? 1.0 : -1.0;
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = 0.5 * i;
    o.row = i + 2;
    o.position = {15e-3 * std::cos(angle), 10e-3 + 15e-3 * std::sin(angle), 0.0};
    o.velocity = {-sense * 1e-3 * std::sin(angle), sense * 1e-3 * std::cos(angle), 0.0};
    const double travel = o.velocity[0] > 1e-9 ? 1.0 : o.velocity[0] < -1e-9 ? -1.0 : 0.0;
    o.deviation = {lean * (o.position[1] - 10e-3) - 0.5 * gap * travel, 0.0, kNotMeasured};
    o.setup = -1;
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

TEST(ReportCircle, AMachineThatIsNotSquareDrawsAnEllipse) {
  const Session session = circleSession(400e-6, 0.0);
  const auto tests = circleTests(fitted(session));
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].first + tests[0].second, "xy");
  EXPECT_NEAR(tests[0].radius, 15.0, 1e-6);
  // lean R sin cos = lean R / 2 sin 2 theta: G is lean R, 6 um, the same both ways
  EXPECT_NEAR(tests[0].measured.counterClockwise.circular, 6.0, 0.05);
  EXPECT_NEAR(tests[0].measured.clockwise.circular, 6.0, 0.05);
  EXPECT_NEAR(tests[0].measured.hysteresis, 0.0, 0.01);
  const auto left = circleTests(fitted(session, {EffectSpec("cross_talk").set("axis", "x").set("of", "y")}));
  ASSERT_EQ(left.size(), 1u);
  EXPECT_NEAR(left[0].measured.counterClockwise.circular, 6.0, 0.05);
  EXPECT_NEAR(left[0].calibrated.counterClockwise.circular, 0.0, 0.01);
}

TEST(ReportCircle, PlayIsTheDifferenceOfBothWays) {
  const auto tests = circleTests(fitted(circleSession(0.0, 4e-6)));
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_NEAR(tests[0].measured.hysteresis, 4.0, 0.1);  // the gap, where x moves radially: near the x axis
}

/// The same ellipse by a ball bar, as it is imported: contacts with a ball of the nominal radius.
Session ballBarSession(double lean) {
  Session session(Machine::load("three_axis"));
  session.source = "ball_bar.csv";
  session.artifact.name = "ball_bar";
  Feature centre{FeatureKind::kBall, "centre"};
  centre.radius = 15e-3;
  centre.position = {0.0, 10e-3, 0.0};
  centre.known = false;
  session.artifact.features.push_back(centre);
  for (int i = 0; i < 72; ++i) {
    const double angle = kPi / 36.0 * i, reading = 15e-3 - lean * 15e-3 * std::sin(angle) * std::cos(angle);
    Observation o;
    o.kind = ObservationKind::kContact;
    o.feature = 0;
    o.time = 0.5 * i;
    o.row = i + 2;
    o.position = {reading * std::cos(angle), 10e-3 + reading * std::sin(angle), 0.0};
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

TEST(ReportCircle, AnImportedBallBarIsACircle) {
  const Session session = ballBarSession(400e-6);
  const auto tests = circleTests(fitted(session));
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].first + tests[0].second, "xy");
  EXPECT_NEAR(tests[0].radius, 15.0, 1e-3);
  EXPECT_NEAR(tests[0].measured.counterClockwise.circular, 6.0, 0.05);
  EXPECT_NEAR(tests[0].measured.counterClockwise.largest, 3.0, 0.05);
  const auto left = circleTests(fitted(session, {EffectSpec("cross_talk").set("axis", "x").set("of", "y")}));
  ASSERT_EQ(left.size(), 1u);
  EXPECT_NEAR(left[0].calibrated.counterClockwise.circular, 0.0, 0.05);
  Session plate = session;  // a touched ball is no circle of ISO 230-4
  plate.artifact.name = "plate";
  EXPECT_TRUE(circleTests(fitted(plate)).empty());
}

TEST(ReportCircle, PositionsOnALineAreNoCircle) {
  Session session = circleSession(400e-6, 0.0);
  for (Observation& o : session.observations) o.position[1] = 0.3 * o.position[0];
  EXPECT_TRUE(circleTests(fitted(session)).empty());
}

}  // namespace
}  // namespace mm
