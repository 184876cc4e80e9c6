// An effect of the model that is not uniform is told as such, and what follows it can be added.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosed.h"
#include "diagnosis/diagnose.h"
#include "long_tests.h"
#include "model/observed_domain.h"
#include "nine_ball_plate.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

using test::diagnosed;

const EffectSpec kBacklash = EffectSpec("backlash").set("axis", "x");

/// The nine-ball plate, with a play of x that has one size and, on top of it, one that grows along x.
/// @param slope m of play a m of travel.
Session plateWithPlay(double slope) {
  const Machine machine = Machine::load("three_axis");
  Session s = simulate(machine, test::everydayPlate(machine), {{"backlash:x=3um"}, 41, ""}).session;
  const auto x = static_cast<std::size_t>(machine.findJoint("x"));
  for (Observation& o : s.observations)  // the slide stays back by half the play: it reads further than it is
    if (o.velocity[x] != 0.0)
      o.position[x] += 0.5 * std::copysign(1.0, o.velocity[x]) * slope * o.position[x];
  return s;
}

TEST(Variations, APlayThatGrowsAlongItsAxisIsToldAndFollowedByTheFormulaThatIsNamed) {
  const Session s = plateWithPlay(1.5e-4);  // 5.4 um from one end of 36 mm to the other
  const Diagnosis d = diagnosed(s, {kBacklash});
  ASSERT_EQ(d.variations.size(), 1u) << d.sentence;
  EXPECT_EQ(d.variations[0].effect, kBacklash);
  EXPECT_EQ(d.variations[0].along, "x");
  // half of the play, of which contacts along x see all and others little: 1.35 um at either end
  EXPECT_GT(d.variations[0].rms, 0.15e-6);
  EXPECT_LT(d.variations[0].rms, 1.35e-6);
  const double ofTheMean = d.noise / std::sqrt(static_cast<double>(s.observations.size()));
  EXPECT_NEAR(d.variations[0].std, ofTheMean, 0.3 * ofTheMean);
  EXPECT_NE(d.sentence.find("is not uniform"), std::string::npos) << d.sentence;
  EXPECT_EQ(d.sentence.find("Nothing is missing"), std::string::npos) << d.sentence;

  const Diagnosis after = diagnosed(s, {kBacklash, d.variations[0].formula});
  EXPECT_TRUE(after.variations.empty()) << after.sentence;
  EXPECT_EQ(after.verdict, Verdict::kExplained) << after.sentence;
  EXPECT_LT(after.base.figures.rms, 0.9 * d.base.figures.rms);
  EXPECT_NEAR(after.base.x[1], -0.5 * 0.15, 0.01);  // k1, um a mm: half the slope, against the travel
}

TEST(Variations, AnotherShapeOfAnEffectIsToldWithTheEffectThatFollows) {
  const Machine machine = Machine::load("three_axis");
  Session s = simulate(machine, test::everydayPlate(machine), {{}, 43, ""}).session;
  const auto x = static_cast<std::size_t>(machine.findJoint("x"));
  for (Observation& o : s.observations) {  // a lead that changes: a parabola, and a cubic beside it
    const double at = o.position[x] / 18e-3;
    o.position[x] += 4e-6 * (1.5 * at * at - 0.5) + 1.2e-6 * (2.5 * at * at * at - 1.5 * at);
  }
  const EffectSpec parabola = EffectSpec("positioning_polynomial").set("axis", "x").set("degree", 2);
  const Diagnosis d = diagnosed(s, {parabola});
  const EffectSpec cubic = EffectSpec("positioning_polynomial").set("axis", "x").set("degree", 3);
  EXPECT_TRUE(d.missing.empty()) << d.sentence;
  ASSERT_EQ(d.variations.size(), 1u) << d.sentence;
  EXPECT_EQ(d.variations[0].effect, parabola) << d.sentence;
  EXPECT_EQ(d.variations[0].formula, cubic) << d.sentence;
  EXPECT_EQ(d.sentence.find("Nothing is missing"), std::string::npos) << d.sentence;
  const Diagnosis after = diagnosed(s, {parabola, cubic});
  EXPECT_EQ(after.verdict, Verdict::kExplained) << after.sentence;
  EXPECT_TRUE(after.variations.empty()) << after.sentence;
}

/// A probe on three seats, and what else is hidden: the tip goes on by so much that the triangle of its seats
/// shows.
Session plateWithTripod(const std::vector<std::string>& hide, double secondLobe) {
  const Machine machine = Machine::load("three_axis");
  Session s = simulate(machine, test::everydayPlate(machine), {hide, 44, ""}).session;
  for (Observation& o : s.observations) {
    const double around = std::atan2(-o.approach.y(), -o.approach.x()),
                 sideways = std::hypot(o.approach.x(), o.approach.y());
    const double further = 2e-6 * sideways * (1.0 + std::cos(3.0 * around + 2.0)) +
                           secondLobe * sideways * std::cos(2.0 * around);
    for (int k = 0; k < 3; ++k) o.position[static_cast<std::size_t>(k)] += further * o.approach[k];
  }
  return s;
}

// Lobes of any order are near to each other, and the play of an axis sideways is near to two lobes: within
// the freedom of the shape nothing more is missing, and a model of one size without it asks what follows.
TEST(Variations, APlayBehindTheLobesOfAProbeIsToldAsTheLikelier) {
  const std::vector<EffectSpec> lobes = {EffectSpec("probe_lobing").set("order", 0),
                                         EffectSpec("probe_lobing").set("order", 3)};
  const EffectSpec play = EffectSpec("backlash").set("axis", "y");
  const Diagnosis d = diagnosed(plateWithTripod({"backlash:y=1.5um"}, 0.0), lobes);
  ASSERT_EQ(d.variations.size(), 1u) << d.sentence;
  ASSERT_FALSE(d.variations[0].instead.empty()) << d.sentence;
  EXPECT_EQ(d.variations[0].instead[0].effect, play) << d.sentence;
  EXPECT_GT(d.variations[0].instead[0].probability, 0.5);
  EXPECT_NE(d.sentence.find(", which backlash of y explains, odds"), std::string::npos) << d.sentence;

  // every day AnotherShape… asks for the effect that follows, Diagnose.FindsHiddenBacklash… that none is made
  // up
  if (!mm_test::thoroughTests()) return;
  const Diagnosis other = diagnosed(plateWithTripod({}, 0.3e-6), lobes);
  ASSERT_EQ(other.variations.size(), 1u) << other.sentence;
  EXPECT_EQ(other.variations[0].formula, EffectSpec("probe_lobing").set("order", 2)) << other.sentence;
  for (const Alternative& a : other.variations[0].instead) EXPECT_LT(a.probability, 0.5) << other.sentence;

  const Diagnosis plain = diagnosed(plateWithTripod({}, 0.0), lobes);
  EXPECT_TRUE(plain.variations.empty()) << plain.sentence;
}

/// Five runs in both directions over 21 targets (ISO 230-2): each target, each way, has an error of its own.
Session runs(double ofPlace, double noise) {
  Session session(Machine::load("three_axis"));
  session.source = "made up";
  constexpr int kTargets = 21;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  double own[2][kTargets];
  for (auto& way : own)
    for (double& e : way) e = ofPlace * normal(random);
  for (int i = 0; i < 10 * kTargets; ++i) {
    const int back = i / kTargets % 2, target = back != 0 ? kTargets - 1 - i % kTargets : i % kTargets;
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = i;
    o.row = i + 2;
    o.position.assign(3, 0.0);
    o.velocity.assign(3, 0.0);
    o.position[0] = 1.5e-3 * (target - kTargets / 2);
    o.velocity[0] = back != 0 ? -1e-3 : 1e-3;
    o.deviation.assign(3, kNotMeasured);
    o.deviationStd.assign(3, kNotMeasured);
    o.deviation[0] = own[back][target] + noise * normal(random);
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

TEST(Runs, WhatTheyAgreeOnIsNotExplainedAsDrift) {
  const Diagnosis d = diagnosed(runs(1e-6, 0.3e-6), {});
  ASSERT_EQ(d.base.repeated.from, "runs");
  EXPECT_NEAR(d.base.repeatability, 0.3e-6, 0.05e-6);
  EXPECT_NE(d.verdict, Verdict::kExplained) << d.sentence;
  if (!mm_test::thoroughTests())
    return;  // every day PlaceOrTime.NoiseWithMemoryIsDrift has runs that are explained
  const Diagnosis nothing = diagnosed(runs(0.0, 0.3e-6), {});
  EXPECT_EQ(nothing.verdict, Verdict::kExplained) << nothing.sentence;
}

}  // namespace
}  // namespace mm
