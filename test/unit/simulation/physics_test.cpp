#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "session/session.h"
#include "simulation/chain.h"
#include "simulation/probe.h"
#include "simulation/profile.h"
#include "simulation/quantity.h"
#include "simulation/screw.h"
#include "simulation/thermal.h"

namespace mm {
namespace {

TEST(Play, HysteresisLoopHasTheFullGapAndAStandstillAfterReversal) {
  Play play(4e-6);
  play.centre(0.0);
  play.follow(1e-3);
  EXPECT_DOUBLE_EQ(play.slide(), 1e-3 - 2e-6);
  play.follow(1e-3 - 1e-6);  // a reversal smaller than the gap moves nothing
  EXPECT_DOUBLE_EQ(play.slide(), 1e-3 - 2e-6);
  play.follow(1e-3 - 4e-6);  // now it is just taken up
  EXPECT_NEAR(play.slide(), 1e-3 - 2e-6, 1e-18);
  play.follow(0.5e-3);
  EXPECT_DOUBLE_EQ(play.slide(), 0.5e-3 + 2e-6);
  play.follow(0.5e-3 + 2e-6);
  EXPECT_DOUBLE_EQ(play.slide(), 0.5e-3 + 2e-6);
  play.follow(1e-3);
  EXPECT_DOUBLE_EQ(play.slide(), 1e-3 - 2e-6);
}

TEST(PeriodicLead, RepeatsWithItsPeriodAndHasItsAmplitude) {
  const Source lead = periodicLead(0, 2e-6, 1e-3, 0.7);
  const auto error = [&](double q) {
    Condition c;
    c.drive = c.slide = {q};
    Distortion d(1);
    lead(c, d);
    return d.travel[0];
  };
  double low = 1.0, high = -1.0;
  for (int i = 0; i < 1000; ++i) {
    const double q = 1e-6 * i;
    EXPECT_NEAR(error(q), error(q + 5e-3), 1e-15);
    low = std::min(low, error(q));
    high = std::max(high, error(q));
  }
  EXPECT_NEAR(0.5 * (high - low), 2e-6, 0.15e-6);  // the second harmonic adds a little
}

TEST(Profile, KeepsItsSizeAndHasNoTrendWhereAsked) {
  for (int seed = 0; seed < 20; ++seed) {
    Random random(seed, "profile");
    const Profile profile = Profile::integratedWaves(-0.02, 0.02, 3e-6, random);
    double largest = 0.0, sum = 0.0, moment = 0.0;
    for (int i = 0; i <= 512; ++i) {
      const double q = -0.02 + 0.04 * i / 512, value = profile.at(q);
      largest = std::max(largest, std::abs(value));
      sum += value;
      moment += value * q;
    }
    EXPECT_NEAR(largest, 3e-6, 1e-12);
    EXPECT_NEAR(sum / 513, 0.0, 1e-12);
    EXPECT_NEAR(moment / 513, 0.0, 1e-13);
  }
}

TEST(ThermalModel, OneBodyFollowsTheAnalyticExponential) {
  Ambient room;
  room.start = 22.0;
  const double capacity = 300.0, conductance = 0.5, power = 4.0;
  ThermalModel model({{"motor", capacity, conductance, power, 0.0}}, {}, {}, room);
  double t = 0.0;
  for (int i = 0; i < 200; ++i) {
    model.advance(17.0, 1.0);
    t += 17.0;
    EXPECT_NEAR(model.temperatures()[0],
                22.0 + power / conductance * -std::expm1(-t * conductance / capacity), 1e-6);
  }
  EXPECT_NEAR(model.recorded(600.0)[0], 22.0 + 8.0 * -std::expm1(-1.0), 1e-3);
}

TEST(ThermalModel, WithoutSourcesHeatOnlyGoesRound) {
  Ambient room;
  ThermalModel model({{"a", 100.0, 0.0, 0.0, 0.0}, {"b", 50.0, 0.0, 3.0, 0.0}}, {{0, 1, 0.2}}, {}, room);
  model.advance(100.0, 1.0);  // 300 J into b
  model.advance(1e5, 0.0);
  EXPECT_NEAR(model.temperatures()[0], 22.0, 1e-9);
  EXPECT_NEAR(model.temperatures()[1], 22.0, 1e-9);
}

TEST(ThermalModel, AFollowerLagsBehindItsBody) {
  Ambient room;
  room.ramp = 1e-3;  // K/s: far from the start the follower is lag * ramp behind
  ThermalModel model({}, {}, {}, room);
  model.addFollowers({{0, 200.0}});
  for (int i = 0; i < 1000; ++i) model.advance(3.0, 0.0);
  EXPECT_NEAR(model.temperatures()[0] - model.temperatures()[1], 0.2, 1e-6);
}

TEST(SeatedProbe, LobesAreThreefoldAndVanishAlongTheStylus) {
  SeatedProbe probe;
  probe.setLobing(3, 1e-6, 0.4);
  double cosine = 0.0, sine = 0.0, mean = 0.0;
  for (int i = 0; i < 360; ++i) {
    const double a = i * kDegree;
    const double p = probe.preTravel({std::cos(a), std::sin(a), 0.0});
    EXPECT_NEAR(p, probe.preTravel({std::cos(a + 2.0 * kPi / 3.0), std::sin(a + 2.0 * kPi / 3.0), 0.0}),
                1e-14);
    cosine += p * std::cos(3.0 * a) / 180.0;
    sine += p * std::sin(3.0 * a) / 180.0;
    mean += p / 360.0;
  }
  EXPECT_NEAR(std::hypot(cosine, sine), 1e-6, 2e-9);
  EXPECT_NEAR(mean, 0.0, 1e-9);
  EXPECT_EQ(probe.preTravel({0.0, 0.0, -1.0}), 0.0);
}

TEST(Chain, AgreesWithTheMachineAtAnyReadings) {
  for (const char* name : {"three_axis", "five_axis"}) {
    const Machine machine = Machine::load(name);
    const Chain chain(machine);
    Random random(3, name);
    for (int i = 0; i < 50; ++i) {
      std::vector<double> q;
      for (const Joint& joint : machine.joints()) q.push_back(random.uniform(joint.lower, joint.upper));
      const ProbePose expected = machine.nominal(q.data(), kNotMeasured), pose = chain.nominal(q);
      EXPECT_LT((pose.position - expected.position).norm(), 1e-12);
      EXPECT_LT((pose.orientation - expected.orientation).norm(), 1e-12);
    }
  }
}

TEST(Chain, ATiltOfARotaryJointActsAboutItsAxisPoint) {
  const Machine machine = Machine::load("five_axis");
  const Chain chain(machine);
  Distortion d(machine.jointCount());
  const int a = machine.findJoint("a");
  d.tilt[a] = Eigen::Vector3d(0.0, 0.0, 1e-3);
  const std::vector<double> zero(machine.joints().size(), 0.0);
  // The head's pivot stands at the origin: the tip at (120, 10, 20) mm turns about z there.
  const Eigen::Vector3d moved = chain.pose(zero, d).position - chain.nominal(zero).position;
  EXPECT_NEAR(moved.x(), -10e-6, 0.1e-6);
  EXPECT_NEAR(moved.y(), 120e-6, 0.1e-6);
  EXPECT_NEAR(moved.z(), 0.0, 1e-12);
}

TEST(Quantity, ReadsUnitsAndRefusesOthers) {
  EXPECT_DOUBLE_EQ(parseQuantity("3um", "m", "here"), 3e-6);
  EXPECT_DOUBLE_EQ(parseQuantity("-2 ppm/K", "1/K", "here"), -2e-6);
  EXPECT_THROW(parseQuantity("3", "m", "here"), std::runtime_error);
  EXPECT_THROW(parseQuantity("3arcsec", "m", "here"), std::runtime_error);
  EXPECT_THROW(parseQuantity("um", "m", "here"), std::runtime_error);
}

TEST(Random, StreamsAreIndependentAndNormal) {
  Random a(1, "a"), b(1, "b"), again(1, "a");
  double sum = 0.0, square = 0.0, product = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double x = a.normal(), y = b.normal();
    EXPECT_EQ(x, again.normal());
    sum += x;
    square += x * x;
    product += x * y;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.03);
  EXPECT_NEAR(square / n, 1.0, 0.04);
  EXPECT_NEAR(product / n, 0.0, 0.03);
}

}  // namespace
}  // namespace mm
