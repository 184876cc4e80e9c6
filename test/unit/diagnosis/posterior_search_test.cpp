// The posterior over sets of causes, on sessions of the simulated instrument.
#include "diagnosis/posterior_search.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "model/observed_domain.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

Diagnosis drawn(const std::vector<std::string>& hide, std::uint64_t seed) {
  const Machine machine = Machine::load("three_axis");
  const Simulation s =
      simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), {hide, seed, ""});
  const Model model(machine, observedDomain(s.session), std::vector<EffectSpec>());
  DiagnoseOptions options;
  return diagnose(s.session, model, options);
}

/// Causes that are given more than an even chance.
long likely(const Diagnosis& d) {
  return std::count_if(d.candidates.begin(), d.candidates.end(),
                       [](const CandidateResult& c) { return c.odds > 0.5; });
}

TEST(PosteriorSearch, SaysNothingWhereNothingIsHidden) {
  const Diagnosis d = drawn({}, 11);
  EXPECT_EQ(d.verdict, Verdict::kExplained) << d.sentence;
  EXPECT_TRUE(d.missing.empty() && d.profiles.empty());
  EXPECT_EQ(likely(d), 0);
}

TEST(PosteriorSearch, ACauseThatActsIsSureAndThoseThatImitateItAreNot) {
  const Diagnosis d = drawn({"backlash:x=3um"}, 5);
  ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
  EXPECT_EQ(d.missing[0].effect, EffectSpec("backlash").set("axis", "x"));
  EXPECT_GT(d.missing[0].odds, 0.99 * kOfThisWorld);
  for (const CandidateResult& c : d.candidates)
    EXPECT_LE(c.odds, kOfThisWorld) << "no model is surer than it has been right: " << c.effect.yaml();
  EXPECT_NEAR(d.missing[0].parameters[0].value, 3.0, 4.0 * d.missing[0].parameters[0].std + 0.03);
  EXPECT_EQ(likely(d), 1);  // given all others, no other cause is likely
}

}  // namespace
}  // namespace mm
