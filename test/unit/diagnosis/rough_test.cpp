// Sessions as rough as real ones: noise with memory, imperfect balls, heavy tails. The simulation's roughness
// shares no code and no kernel with the diagnosis.
#include <gtest/gtest.h>

#include "diagnosis/diagnose.h"
#include "effects/inputs.h"
#include "effects/registry.h"
#include "long_tests.h"
#include "model/observed_domain.h"
#include "nine_ball_plate.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

constexpr double kPlanNoise = 0.3e-6;  // m, of the plan

/// Kinds of noise, each of which must mislead nobody.
constexpr const char* kKinds[] = {"drift", "correlated", "form", "tails", "quantised"};

Diagnosis rough(const std::vector<std::string>& hide, const std::string& how, std::uint64_t seed,
                const std::vector<EffectSpec>& model = {}, bool whole = false) {
  const Machine machine = Machine::load("three_axis");
  SimulationRequest request;
  request.hide = hide;
  request.seed = seed;
  request.rough = how;
  const Simulation s = simulate(machine, test::everydayPlate(machine, whole), request);
  Diagnosis d = diagnose(s.session, Model(machine, observedDomain(s.session), model), {});
  d.base = {};  // it refers to the session
  return d;
}

bool silent(const Diagnosis& d) { return d.missing.empty() && d.profiles.empty() && d.formulas.empty(); }

TEST(Rough, NothingIsClaimedWhereNothingIsHidden) {
  // every day: DriftIsTold… asks it of drift, Diagnose.ClaimsNothing… of white noise
  const std::vector<const char*> everyDay = {"form"};
  for (const char* how :
       mm_test::thoroughTests() ? std::vector<const char*>(std::begin(kKinds), std::end(kKinds)) : everyDay)
    // one session of each kind; a second of each only at full length: the claim is about the kinds
    for (std::uint64_t seed = 31; seed <= (mm_test::longTests() ? 32 : 31); ++seed) {
      const Diagnosis d = rough({}, how, seed);
      EXPECT_TRUE(silent(d)) << how << " " << seed << ": " << d.sentence;
    }
}

TEST(Rough, BacklashAtTwiceTheNoiseIsNamedAlone) {
  MM_THOROUGH_ONLY("every day it is asked in white noise: Diagnose.FindsHiddenBacklash…");
  for (const char* how : kKinds) {
    const Diagnosis d = rough({"backlash:x=2.4um"}, how, 33);
    ASSERT_EQ(d.missing.size(), 1u) << how << ": " << d.sentence;
    EXPECT_EQ(d.missing[0].effect, EffectSpec("backlash").set("axis", "x")) << how;
    EXPECT_TRUE(d.profiles.empty()) << how << ": " << d.sentence;
    EXPECT_GT(d.missing[0].odds, 0.5) << how;
    // k = 3, and 0.1 um: the simulated gap varies along the screw
    EXPECT_NEAR(d.missing[0].parameters[0].value, 2.4, 3.0 * d.missing[0].parameters[0].std + 0.1) << how;
  }
}

TEST(Rough, DriftIsToldAndTheNoiseIsWhatIsLeftOfIt) {
  const Machine machine = Machine::load("three_axis");
  const Domain domain = observedDomain(simulate(machine, test::everydayPlate(machine), {{}, 34, ""}).session);
  const Diagnosis d = rough({}, "drift", 34);
  EXPECT_TRUE(silent(d)) << d.sentence;
  EXPECT_FALSE(d.drift.empty()) << d.sentence;
  EXPECT_NEAR(d.noise / kPlanNoise, 1.0, 0.1);
  for (const DriftResult& r : d.drift) {
    EXPECT_GT(r.std, 0.3 * kPlanNoise);
    EXPECT_LT(r.std, 4.0 * kPlanNoise);
    EXPECT_GT(r.timeConstant, 0.0);
    for (const DriftResult::Perhaps& p : r.perhaps)  // what stands still is no drift
      EXPECT_TRUE(inputsOf(*createEffect(p.effect, domain), domain).dependsOnTime()) << p.effect.yaml();
  }
}

TEST(Rough, HeavyTailsAreSeen) { EXPECT_GT(rough({}, "tails", 36).tailDof, 0.0); }

TEST(Rough, TheSecondHarmonicOfAScrewInTheModelIsAScrewToo) {
  const Diagnosis d =
      rough({"lead_screw_periodic:x=1um,period=1mm", "lead_screw_periodic:x=1um,period=2mm"}, "", 38,
            {EffectSpec("lead_screw_periodic").set("axis", "x").set("period_mm", 2.0)}, true);
  ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
  EXPECT_EQ(d.missing[0].effect.type, "lead_screw_periodic") << d.sentence;
  EXPECT_TRUE(d.profiles.empty());
}

}  // namespace
}  // namespace mm
