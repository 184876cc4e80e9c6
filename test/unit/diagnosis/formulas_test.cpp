// Effects that no entry of the catalogue describes, made by the simulated instrument's own physics.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

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

/// A session of the nine-ball plate, or another plan, whose readings are spoiled by the test's own physics.
/// @param error true minus indicated at a contact, m along the axes of a Cartesian machine.
Diagnosis spoiled(const std::function<Eigen::Vector3d(const Observation&)>& error, std::uint64_t seed) {
  const Machine machine = Machine::load("three_axis");
  Session session =
      simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), {{}, seed}).session;
  const Domain domain = observedDomain(session);
  const char* const names[] = {"x", "y", "z"};
  for (Observation& o : session.observations) {
    const Eigen::Vector3d e = error(o);
    for (int k = 0; k < 3; ++k) o.position[static_cast<std::size_t>(domain.findJoint(names[k]))] -= e[k];
  }
  session.prepare();
  return diagnose(session, Model(machine, observedDomain(session), std::vector<EffectPtr>{}), {});
}

std::string named(const Diagnosis& d) {
  std::string text = d.sentence;
  for (const CandidateResult& m : d.missing) text += "\n" + m.effect.yaml();
  for (const FormulaResult& f : d.formulas) text += "\n" + f.effect.yaml();
  return text;
}

/// A dent in a rail is narrower than any polynomial of the catalogue: the formula alone is the answer, not
/// the pieces that imitate it.
TEST(UnknownEffects, ADentIsAFormulaAndNotItsPieces) {
  const Machine machine = Machine::load("three_axis");
  const int x =
      observedDomain(simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), {}).session)
          .findJoint("x");
  const Diagnosis d = spoiled(
      [&](const Observation& o) {
        const double u = (1e3 * o.position[static_cast<std::size_t>(x)] - 4.0) / 3.0;
        return Eigen::Vector3d(0.0, 0.0, 4e-6 / (1.0 + u * u * u * u));
      },
      31);
  EXPECT_EQ(d.verdict, Verdict::kUnknownEffect) << named(d);
  EXPECT_TRUE(d.missing.empty()) << named(d);
  ASSERT_FALSE(d.formulas.empty()) << named(d);
  EXPECT_EQ(d.formulas[0].effect.text("direction"), "z") << named(d);
  EXPECT_LT(d.formulas[0].heldOutAfter, 1.15 * kNoise) << named(d);
}

TEST(NamedCause, AScrewMayErrAtItsSecondHarmonicToo) {
  const Diagnosis d = spoiled(
      [](const Observation& o) {
        const double turn = 2.0 * 3.14159265 * o.position[1] / 1.7e-3;
        return Eigen::Vector3d(0.0, 1.5e-6 * std::sin(turn) + 0.9e-6 * std::cos(2.0 * turn + 0.7), 0.0);
      },
      32);
  ASSERT_EQ(d.missing.size(), 2u) << named(d);
  for (const CandidateResult& m : d.missing) EXPECT_EQ(m.effect.type, "lead_screw_periodic") << named(d);
  EXPECT_EQ(d.missing[0].effect.text("period_mm"), "unknown") << named(d);
  EXPECT_NEAR(std::stod(d.missing[1].effect.text("period_mm")), 0.85, 0.01) << named(d);
  EXPECT_LT(d.missing[1].heldOutAfter, 1.1 * kNoise) << named(d);
}

/// More travel sideways, where the stylus bends, than along the stylus: no play of an axis.
TEST(NamedCause, PreTravelThatDependsOnTheSlopeIsTheProbes) {
  const Diagnosis d = spoiled(
      [](const Observation& o) {
        return Eigen::Vector3d(1.2e-6 * std::hypot(o.approach.x(), o.approach.y()) * o.approach);
      },
      33);
  ASSERT_EQ(d.missing.size(), 1u) << named(d);
  EXPECT_EQ(d.missing[0].effect.yaml(), "{type: probe_lobing, order: 0}") << named(d);
}

/// A laser that is not linear over its range.
TEST(UnknownEffects, ALaserThatBendsIsSeenInItsReading) {
  const Machine machine = Machine::load("five_axis");
  Session session =
      simulate(machine, Plan::load("config/plans/five_axis_ball.yaml", machine), {{}, 34}).session;
  for (Observation& o : session.observations) {
    const double mm = 1e3 * o.laserReading;
    o.laserReading -= 1.5e-6 * std::sin(1.3 * mm);
  }
  session.prepare();
  const Domain domain = observedDomain(session);
  const Diagnosis d = diagnose(session, Model(machine, domain, std::vector<EffectPtr>{}), {});
  ASSERT_FALSE(d.formulas.empty()) << named(d);
  const std::string formula = d.formulas[0].effect.text("formula");
  EXPECT_NE(formula.find("reading"), std::string::npos) << named(d);
  EXPECT_TRUE(d.missing.empty()) << named(d);
  EXPECT_LT(d.formulas[0].heldOutAfter, 0.6 * d.formulas[0].heldOutBefore) << named(d);
}

}  // namespace
}  // namespace mm
