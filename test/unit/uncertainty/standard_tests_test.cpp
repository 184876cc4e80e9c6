#include "uncertainty/standard_tests.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "uncertainty/diagonal_tests.h"
#include "uncertainty/length_tests.h"
#include "uncertainty/rotation_tests.h"
#include "uncertainty/thermal_tests.h"

namespace mm {
namespace {

constexpr double kMinutes = 60.0;

Observation reading(ObservationKind kind, double time, const std::vector<double>& position) {
  Observation o;
  o.kind = kind;
  o.time = time;
  o.position = position;
  o.velocity.assign(position.size(), 0.0);
  return o;
}

/// Positions of one place of three_axis every five minutes for two hours; `x` (m) by the time in h.
Session oneplaceSession(const std::function<double(double)>& x) {
  Session session(Machine::load("three_axis"));
  session.setups = {"indicators"};
  for (int i = 0; i <= 24; ++i) {
    Observation o = reading(ObservationKind::kPosition, 5.0 * kMinutes * i, {0.0, 0.0, 0.0});
    o.setup = 0;
    o.reference = Eigen::Vector3d(x(o.time / 3600.0), 0.0, 0.5);
    session.observations.push_back(o);
  }
  return session;
}

void logSpeed(Session& session, double fromHour, double toHour) {
  Series speed;
  speed.name = "spindle";
  speed.unit = "rpm";
  for (const Observation& o : session.observations) {
    const double hour = o.time / 3600.0;
    speed.time.push_back(o.time);
    speed.value.push_back(hour > fromHour && hour <= toHour ? 6000.0 : 0.0);
  }
  session.covariates.push_back(speed);
}

TEST(StandardTests, IdleMachine) {
  Session session = oneplaceSession([](double hour) { return 2e-6 * hour; });
  session.prepare();
  const std::vector<ThermalTest> tests = thermalTests(session);
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].kind, ThermalTestKind::kEnvironment);
  ASSERT_EQ(tests[0].courses.size(), 3u);
  EXPECT_EQ(tests[0].courses[0].name, "X");
  EXPECT_NEAR(tests[0].courses[0].measured.value.back(), 4.0, 1e-9);  // 2 um/h for 2 h
  EXPECT_NEAR(tests[0].courses[2].measured.value.back(), 0.0, 1e-9);  // where the instrument stands: no drift
  ASSERT_EQ(standardTests(session).size(), 1u);
  EXPECT_EQ(standardTests(session)[0].test, "iso230-3");
  EXPECT_EQ(standardTests(session)[0].inWords,
            "ISO 230-3, ETVE (idle machine): 25 readings at one position over 2.0 h");
}

TEST(StandardTests, SpindleThatTurned) {
  Session session = oneplaceSession([](double hour) { return 1e-6 * hour; });
  logSpeed(session, 0.24, 1.5);  // stands at 0.1667 h for the last time
  session.prepare();
  const std::vector<ThermalTest> tests = thermalTests(session);
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].kind, ThermalTestKind::kSpindle);
  EXPECT_EQ(tests[0].spindle, "spindle");
  EXPECT_NEAR(tests[0].heated.from, 10.0 / 60.0, 1e-9);
  EXPECT_NEAR(tests[0].heated.to, 1.5, 1e-9);
}

TEST(StandardTests, ASpindleThatStoodIsNone) {
  Session session = oneplaceSession([](double) { return 0.0; });
  logSpeed(session, 3.0, 4.0);
  session.prepare();
  ASSERT_EQ(thermalTests(session).size(), 1u);
  EXPECT_EQ(thermalTests(session)[0].kind, ThermalTestKind::kEnvironment);
}

TEST(StandardTests, NothingOfAMachineThatMovesOrOfAShortTest) {
  Session session = oneplaceSession([](double hour) { return 1e-6 * hour; });
  for (std::size_t i = 0; i < session.observations.size(); ++i)
    session.observations[i].position = {1e-3 * static_cast<double>(i), 2e-3 * static_cast<double>(i), 0.0};
  session.prepare();
  EXPECT_TRUE(thermalTests(session).empty());
  Session brief = oneplaceSession([](double) { return 0.0; });
  brief.observations.resize(10);  // 45 min without a temperature
  brief.prepare();
  EXPECT_TRUE(thermalTests(brief).empty());
}

/// x at -10, 0 and 10 mm every ten minutes for three hours: a drift of 3 um/h, and the length of 20 mm
/// between the ends grows by 2 um/h. Then one hour at rest in which all of it goes back.
Session strokesSession() {
  Session session(Machine::load("three_axis"));
  for (int i = 0; i <= 24; ++i)
    for (const double x : {-10e-3, 0.0, 10e-3}) {
      Observation o = reading(ObservationKind::kDeviation, 10.0 * kMinutes * i, {x, 0.0, 0.0});
      const double hour = i / 6.0, heat = hour <= 3.0 ? hour : 3.0 * (4.0 - hour);
      o.deviation = {7e-6 + heat * (3e-6 + 1e-6 * x / 10e-3), kNotMeasured, kNotMeasured};
      o.travel = {1.0, 0.0, 0.0};
      session.observations.push_back(o);
    }
  return session;
}

TEST(StandardTests, FiveTargetsOrMoreArePositioningRuns) {
  ThermalTest test;
  test.kind = ThermalTestKind::kLinearAxis;
  test.joint = "x";
  test.readings = 68;
  test.places = 11;
  test.to = 0.9;
  EXPECT_EQ(inWords(test),
            "ISO 230-2, linear axis x: displacement against time as in ISO 230-3 from 68 readings at 11 "
            "positions over 0.9 h");
}

TEST(StandardTests, LinearAxisAndItsExpansion) {
  Session session = strokesSession();
  session.prepare();
  const std::vector<ThermalTest> tests = thermalTests(session);
  ASSERT_EQ(tests.size(), 1u);
  const ThermalTest& test = tests[0];
  EXPECT_EQ(test.kind, ThermalTestKind::kLinearAxis);
  EXPECT_EQ(inWords(test), "ISO 230-3, linear axis x: 75 readings at 3 positions over 4.0 h");
  ASSERT_EQ(test.courses.size(), 4u);
  EXPECT_NEAR(test.courses[0].at, -10.0, 1e-9);
  EXPECT_TRUE(test.courses[3].between);
  EXPECT_NEAR(test.heated.to, 3.0, 0.35);
  const auto figuresOf = [](const ThermalCourse& c) {
    return driftFigures(c.measured, {0.0, 3.0}, kNotMeasured);
  };
  const DriftFigures low = figuresOf(test.courses[0]), high = figuresOf(test.courses[2]),
                     expansion = figuresOf(test.courses[3]);
  EXPECT_NEAR(low.firstHour.value, 2.0, 1e-6);
  EXPECT_NEAR(low.heated.value, 6.0, 1e-6);
  EXPECT_NEAR(high.heated.value, 12.0, 1e-6);
  EXPECT_NEAR(high.recovery.value, -12.0, 1e-6);
  EXPECT_NEAR(expansion.firstHour.value, 2.0, 1e-6);
  EXPECT_NEAR(expansion.heated.value, 6.0, 1e-6);
}

TEST(StandardTests, RotaryAxisThatSwungIsToldByItsTravel) {
  Session session(Machine::load("five_axis"));
  const std::size_t joints = session.machine.joints().size();
  const auto b = static_cast<std::size_t>(session.machine.findJoint("b"));
  for (int i = 0; i <= 24; ++i) {
    Observation o = reading(ObservationKind::kPosition, 5.0 * kMinutes * i, std::vector<double>(joints, 0.0));
    o.reference = session.nominalProbe(o).position + Eigen::Vector3d(0.0, 1e-6 * i, 0.0);
    o.travel.assign(joints, 0.0);
    o.travel[b] = 1.0;
    session.observations.push_back(o);
  }
  const std::vector<ThermalTest> tests = thermalTests(session);
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].kind, ThermalTestKind::kRotaryAxis);
  EXPECT_EQ(tests[0].joint, "b");
  EXPECT_NEAR(tests[0].courses[1].measured.value.back(), 24.0, 1e-6);
}

/// A point known in the workpiece at the origin, from which lengths are measured.
Session beamSession() {
  Session session(Machine::load("three_axis"));
  session.artifact.name = "indicators";
  session.artifact.poseKnown = true;
  Feature point;
  point.kind = FeatureKind::kPoint;
  point.name = "+x+y";
  const std::vector<double> far = {-20e-3, -15e-3, 0.0};
  point.position = session.machine.nominal(far.data(), kNotMeasured).position;
  session.artifact.features.push_back(point);
  session.setups = {"+x+y"};
  return session;
}

void addLength(Session& session, double along, double error, double direction) {
  const double way = along / std::sqrt(2.0);
  Observation o = reading(ObservationKind::kLength, 10.0 * static_cast<double>(session.observations.size()),
                          {-20e-3 + way, -15e-3 + way, 0.0});
  o.feature = 0;
  o.setup = 0;
  o.length = 0.123 + along + error;
  o.travel = {direction, direction, 0.0};
  session.observations.push_back(o);
}

TEST(StandardTests, DiagonalWorkedByHand) {
  // um at 10, 15, 20, 25, 30 mm: forward 0 1 2 3 5, backward (from the far end) 4 2 2 0 -1: at 30 … 10 mm.
  // Two runs alike, so the means are these: E forward 5, E backward 5, E = 5 - (-1) = 6; B = 3 - 2, … at 10:
  // 0 - (-1) = 1, 15: 1 - 0 = 1, 20: 2 - 2 = 0, 25: 3 - 2 = 1, 30: 5 - 4 = 1; largest 1, mean 0.8
  Session session = beamSession();
  const std::vector<double> forward = {0, 1, 2, 3, 5}, backward = {-1, 0, 2, 2, 4};
  for (int run = 0; run < 2; ++run) {
    for (int k = 0; k < 5; ++k)
      addLength(session, 10e-3 + 5e-3 * k, 1e-6 * forward[static_cast<std::size_t>(k)], 1.0);
    for (int k = 4; k >= 0; --k)
      addLength(session, 10e-3 + 5e-3 * k, 1e-6 * backward[static_cast<std::size_t>(k)], -1.0);
  }
  const std::vector<DiagonalTest> tests = diagonalTests(session);
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].name, "+x+y");
  const PositioningFigures& f = tests[0].measured.figures;
  EXPECT_NEAR(f.systematic, 6.0, 1e-6);
  EXPECT_NEAR(f.forward.systematic, 5.0, 1e-6);
  EXPECT_NEAR(f.backward.systematic, 5.0, 1e-6);
  EXPECT_NEAR(f.reversal, 1.0, 1e-6);
  EXPECT_NEAR(f.meanReversal, 0.8, 1e-6);
  EXPECT_NEAR(tests[0].measured.targets[0].at, 10.0, 1e-6);
  EXPECT_TRUE(lengthTests(session).empty());
  EXPECT_EQ(standardTests(session)[0].inWords, "ISO 230-6, diagonal +x+y: 20 readings at 5 positions");
}

TEST(StandardTests, LengthsWorkedByHand) {
  // face to face: the far one is measured k um too far at the length k * 5 mm, so E = -k um; left twice that
  Session session = beamSession();
  for (int k = 1; k <= 5; ++k) {
    addLength(session, 3e-3, 0.0, 1.0);
    addLength(session, 3e-3 + 5e-3 * k, 1e-6 * k, -1.0);
  }
  const auto left = [](int observation, int) {
    return observation % 2 == 0 ? 0.0 : 1e-6 * (observation + 1);
  };
  const std::vector<LengthLineTest> tests = lengthTests(session, left);
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].lengths, 5);
  ASSERT_EQ(tests[0].errors.size(), 5u);
  EXPECT_NEAR(tests[0].errors[2].length, 15.0, 1e-6);
  EXPECT_NEAR(tests[0].errors[2].error, -3.0, 1e-6);
  EXPECT_NEAR(tests[0].errors[2].left, -6.0, 1e-6);
  EXPECT_NEAR(tests[0].largest, 5.0, 1e-6);
  EXPECT_TRUE(diagonalTests(session).empty());  // no place was reached from both sides
}

TEST(StandardTests, RadialAndAxialErrorMotion) {
  // A point on a circle of 30 mm about an axis that stands anywhere: two lobes of 2 um and three of 1 um
  // along the axis are no circle and no tilt. Ranges 4 um and 2 um; the angles hit every extreme.
  Session session(Machine::load("five_axis"));
  const auto b = static_cast<std::size_t>(session.machine.findJoint("b"));
  const Eigen::Vector3d along = Eigen::Vector3d(0.1, -0.2, 1.0).normalized();
  const Eigen::Vector3d first = along.unitOrthogonal(), second = along.cross(first);
  for (int i = 0; i < 72; ++i) {
    std::vector<double> position(session.machine.joints().size(), 0.0);
    position[b] = 2.0 * M_PI * i / 72.0 - M_PI;
    Observation o = reading(ObservationKind::kPosition, 5.0 * i, position);
    const double radius = 30e-3 + 2e-6 * std::cos(2.0 * position[b]),
                 axial = 1e-6 * std::cos(3.0 * position[b]);
    o.reference = Eigen::Vector3d(0.1, 0.2, 0.3) +
                  radius * (std::cos(position[b]) * first + std::sin(position[b]) * second) + axial * along;
    session.observations.push_back(o);
  }
  const std::vector<RotationTest> tests = rotationTests(session);
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_EQ(tests[0].joint, "b");
  EXPECT_NEAR(tests[0].radius, 30.0, 1e-6);
  EXPECT_NEAR(tests[0].radialError, 4.0, 0.01);
  EXPECT_NEAR(tests[0].axialError, 2.0, 0.01);
  for (Observation& o : session.observations) o.position[0] = 1e-3 * o.time;  // something else moves
  EXPECT_TRUE(rotationTests(session).empty());
}

}  // namespace
}  // namespace mm
