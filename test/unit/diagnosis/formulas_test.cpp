// Effects that no entry of the catalogue describes, made by the simulated instrument's own physics.
#include <gtest/gtest.h>

#include "diagnosis/diagnose.h"
#include "model/observed_domain.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

constexpr double kNoise = 0.3e-6;  // m, of the plan

Diagnosis diagnosed(const std::vector<std::string>& hide, std::uint64_t seed) {
  const Machine machine = Machine::load("three_axis");
  const Session session =
      simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), {hide, seed}).session;
  return diagnose(session, Model(machine, observedDomain(session), std::vector<EffectPtr>{}), {});
}

struct Hidden {
  const char* text;
  const char* direction;
  std::vector<const char*> variables;
  std::vector<const char*> others;
};

class UnknownEffect : public testing::TestWithParam<Hidden> {};

TEST_P(UnknownEffect, IsSaidToBeOneAndAFormulaOfJustItsVariablesExplainsIt) {
  const Hidden& hidden = GetParam();
  const Diagnosis d = diagnosed({hidden.text}, 21);
  EXPECT_EQ(d.verdict, Verdict::kUnknownEffect) << d.sentence;
  ASSERT_FALSE(d.formulas.empty()) << d.sentence;
  const std::string formula = d.formulas[0].effect.text("formula");
  EXPECT_EQ(d.formulas[0].effect.text("direction"), hidden.direction) << formula;
  for (const char* variable : hidden.variables)
    EXPECT_NE(formula.find(variable), std::string::npos) << formula;
  for (const char* other : hidden.others) EXPECT_EQ(formula.find(other), std::string::npos) << formula;
  EXPECT_LT(d.formulas[0].heldOutAfter, 1.2 * kNoise) << formula;
  EXPECT_GT(d.formulas[0].heldOutBefore, 1.5 * kNoise) << formula;
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, UnknownEffect,
    testing::Values(
        Hidden{"{type: uncatalogued_guide_load, axis: x, across: y, size: 2 um}",
               "z",
               {"x", "y"},
               {"velocity", "bed", "frame", "air", "humidity"}},
        Hidden{"{type: uncatalogued_rocking_floor, axis: x, direction: y, size: 1.5 um, period: 450 s, "
               "phase: 1 rad}",
               "y",
               {"x", "t"},
               {"velocity", "bed", "frame", "air", "humidity"}},
        Hidden{
            "{type: uncatalogued_damp_warmth, direction: x, sensor: bed, covariate: humidity, size: 1.2 um}",
            "x",
            {"bed", "humidity"},
            {"velocity", "frame", "air", "y*", "z*"}}));

TEST(NamedCause, InAnotherShapeIsNoUnknownEffect) {
  // no Legendre polynomial of the catalogue
  const Diagnosis d = diagnosed({"straightness:x/z=2.5um"}, 22);
  ASSERT_FALSE(d.missing.empty()) << d.sentence;
  for (const CandidateResult& m : d.missing) EXPECT_EQ(m.effect.type, "straightness") << d.sentence;
  EXPECT_TRUE(d.formulas.empty()) << d.sentence;
  EXPECT_NE(d.verdict, Verdict::kUnknownEffect) << d.sentence;
}

}  // namespace
}  // namespace mm
