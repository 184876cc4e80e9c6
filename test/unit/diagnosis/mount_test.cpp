// The probe does not stand in the head where the kinematic chain says, or the scale of a rotary axis is
// eccentric.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>
#include <vector>

#include "base/units.h"
#include "diagnosed.h"
#include "long_tests.h"
#include "random_numbers.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

using test_support::RandomNumbers;

const std::vector<std::pair<double, double>> kPostures = {  // b, a in degrees
    {-90, -90}, {-90, -30}, {-90, 60},  {-60, 90}, {-60, -45}, {-45, -90},
    {-45, 45},  {-30, 90},  {-30, -60}, {0, -90},  {0, 0},     {0, 60}};

/// Contacts from above on one ball of 6 mm with a tip of 1 mm, by the chain of five_axis as it is drawn:
/// table x, y; head z, b about -z, a about x; the order of the joints is y x z b a. @param tip m, in the
/// frame of a. @param eccentric what the scale of a leads or lags at most, rad.
Session contactsOfFiveAxes(const Eigen::Vector3d& tip, std::uint64_t seed, double eccentric = 0.0) {
  constexpr double kNoise = 0.5e-6, kRadii = 7e-3;
  const Eigen::Vector3d centre(-65.02e-3, -25.03e-3, 0.01e-3);
  Session session(Machine::load("five_axis"));
  session.source = "test";
  session.artifact.poseKnown = false;
  session.artifact.tipRadius = 1e-3;
  session.artifact.repeatability = kNoise;
  Feature ball;
  ball.name = "s0";
  ball.known = false;
  ball.position = {-65e-3, -25e-3, 0.0};
  ball.radius = 6e-3;
  session.artifact.features = {ball};
  RandomNumbers random(seed);
  for (const auto& [b, a] : kPostures)
    for (int k = 0; k < 25; ++k) {
      const double turned = a * kDegree + eccentric * std::sin(a * kDegree);
      Eigen::Vector3d normal(random.normal(1.0), random.normal(1.0), std::abs(random.normal(1.0)));
      normal.normalize();
      const Eigen::Vector3d head = Eigen::AngleAxisd(-b * kDegree, Eigen::Vector3d::UnitZ()) *
                                   (Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitX()) * tip);
      const Eigen::Vector3d slides = centre + (kRadii + random.normal(kNoise)) * normal - head;
      Observation o;
      o.time = 6.0 * static_cast<double>(session.observations.size());
      o.row = static_cast<int>(session.observations.size()) + 2;
      o.feature = 0;
      o.approach = -normal;
      o.position = {-slides.y(), -slides.x(), slides.z(), b * kDegree, a * kDegree};
      const Eigen::Vector3d speed = -2e-3 * normal;
      o.velocity = {-speed.y(), -speed.x(), speed.z(), 0.0, 0.0};
      session.observations.push_back(o);
    }
  session.prepare();
  return session;
}

TEST(Mount, TheTipOfATouchProbeIsDisplacedInTheHead) {
  const Eigen::Vector3d hidden(20e-6, -15e-6, 30e-6);
  const Session session = contactsOfFiveAxes(Eigen::Vector3d(0.120, 0.010, 0.020) + hidden, 1);
  const Diagnosis d = test::diagnosed(session);
  ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
  EXPECT_EQ(d.missing[0].effect.type, "tip_offset") << d.sentence;
  ASSERT_EQ(d.missing[0].parameters.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    const NamedValue& found = d.missing[0].parameters[static_cast<std::size_t>(k)];
    EXPECT_NEAR(found.value, hidden[k] / kMicrometre, 3.5 * found.std) << found.name;
    EXPECT_LT(found.std, 1.0) << found.name;
  }
}

TEST(Mount, ATipThatStandsWhereItShouldIsNotNamed) {
  const Session session = contactsOfFiveAxes({0.120, 0.010, 0.020}, 3);
  const Diagnosis d = test::diagnosed(session);
  EXPECT_TRUE(d.missing.empty()) << d.sentence;
  EXPECT_EQ(d.sentence.rfind("Nothing is missing", 0), 0u) << d.sentence;
}

/// A scale that is off the centre of its bearing: an angle, and no displacement.
TEST(Mount, TheScaleOfARotaryAxisIsEccentric) {
  const Session session = contactsOfFiveAxes({0.120, 0.010, 0.020}, 4, 30.0 * kArcsecond);
  const Diagnosis d = test::diagnosed(session);
  ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
  EXPECT_EQ(d.missing[0].effect.type, "rotary_eccentricity") << d.sentence;
  EXPECT_EQ(d.missing[0].effect.text("joint"), "a") << d.sentence;
  EXPECT_EQ(d.missing[0].effect.text("reading_only"), "true") << d.sentence;
  ASSERT_EQ(d.missing[0].parameters.size(), 2u);
  const NamedValue& sine = d.missing[0].parameters[1];
  EXPECT_NEAR(sine.value, 30.0, 3.5 * sine.std) << d.sentence;
  EXPECT_LT(sine.std, 3.0);  // arcsec
}

/// The values of the mount are places and a direction, not small errors: they begin at the nominal ones.
TEST(Mount, OfALaserIsTheOneThatWasHidden) {
  const Machine machine = Machine::load("five_axis");
  SimulationRequest request;
  request.hide = {"laser_mount=60um"};
  for (const std::uint64_t seed :
       mm_test::thoroughTests() ? std::vector<std::uint64_t>{1, 8} : std::vector<std::uint64_t>{8}) {
    request.seed = seed;
    const Simulation s = simulate(machine, Plan::load("config/plans/five_axis_ball.yaml", machine), request);
    const Diagnosis d = test::diagnosed(s.session);
    ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
    EXPECT_EQ(d.missing[0].effect.type, "laser_mount") << d.sentence;
    const Eigen::Vector3d nominal(120.0, 10.0, 20.0);  // mm
    ASSERT_EQ(d.missing[0].parameters.size(), 8u);
    Eigen::Vector3d moved;
    for (int k = 0; k < 3; ++k) {
      const NamedValue& found = d.missing[0].parameters[static_cast<std::size_t>(2 + k)];
      moved[k] = found.value - nominal[k];
      EXPECT_LT(found.std, 1e-3) << found.name;
    }
    EXPECT_NEAR(moved.norm(), 0.060, 0.002) << seed;
  }
}

}  // namespace
}  // namespace mm
