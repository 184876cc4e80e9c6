#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "base/error.h"
#include "benchmark_session.h"
#include "benchmark_trial.h"
#include "formula_judge.h"
#include "long_tests.h"
#include "session/plan.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

using Names = std::set<std::string>;

std::string shippedPlan() {
  std::ifstream in("config/plans/nine_ball_plate.yaml");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Plan planOf(const SessionVariant& variant) {
  return Plan::parse(varied(shippedPlan(), "plan", variant), "plan", {}, Machine::load("three_axis"));
}

Simulation run(SessionVariant variant) {
  if (variant.contacts == 0) variant.contacts = 90;
  const Machine machine = Machine::load("three_axis");
  return simulate(machine, planOf(variant), {});
}

InstrumentSettings settingsOf(const SessionVariant& variant) {
  return InstrumentSettings::parse(varied(shippedPlan(), "plan", variant), "plan");
}

UncataloguedTruth over(std::vector<std::string> variables) { return {"", std::move(variables), "z"}; }

TEST(FormulaJudge, FindsTheVariablesAndNothingElse) {
  EXPECT_EQ(variablesOfFormula("k1*x*y"), (Names{"x", "y"}));
  EXPECT_EQ(variablesOfFormula("k1*sign(x_velocity)*exp(-(bed-20.5)/1.5e-3) + k12*sin (2*pi*t/300)"),
            (Names{"x_velocity", "bed", "t"}));
  EXPECT_EQ(variablesOfFormula("2.5e3*k2+e*1E-2*humidity"), (Names{"humidity"}));
  EXPECT_EQ(variablesOfFormula("k*k1x"), (Names{"k", "k1x"}));
  EXPECT_TRUE(variablesOfFormula("").empty());
}

TEST(FormulaJudge, WantsJustTheRightVariables) {
  const UncataloguedTruth truth = over({"x", "y travel direction", "temperature bed", "time"});
  EXPECT_TRUE(justTheVariables({"x", "y_velocity", "bed", "t"}, truth));
  EXPECT_FALSE(justTheVariables({"x", "y_velocity", "bed"}, truth));
  EXPECT_FALSE(justTheVariables({"x", "y_velocity", "bed", "t", "z"}, truth));
  EXPECT_FALSE(justTheVariables({"x", "y", "bed", "t"}, truth));
  EXPECT_FALSE(justTheVariables({}, truth));
  EXPECT_TRUE(justTheVariables({"x_velocity"}, over({"x speed", "x travel direction"})));
  EXPECT_TRUE(justTheVariables({"humidity"}, over({"humidity"})));
}

TEST(FormulaJudge, SpeedOfTheTipAndApproachAreMadeOfVelocities) {
  for (const char* name : {"tip speed", "approach"}) {
    EXPECT_TRUE(justTheVariables({"x_velocity", "y_velocity", "z_velocity"}, over({name})));
    EXPECT_TRUE(justTheVariables({"z_velocity"}, over({name})));
    EXPECT_FALSE(justTheVariables({"z_velocity", "z"}, over({name})));
    EXPECT_FALSE(justTheVariables({}, over({name})));
  }
}

/// A profile over these variables, with this held-out RMS (m).
ProfileResult profileOver(std::vector<std::string> variables, double heldOut) {
  ProfileResult profile;
  profile.direction = "z";
  profile.variables = std::move(variables);
  profile.heldOutAfter = heldOut;
  return profile;
}

TEST(UnknownJudgement, WantsAProfileOverTheRightVariables) {
  const UncataloguedTruth truth = over({"x", "temperature bed"});
  Diagnosis d;
  EXPECT_FALSE(judge(d, truth, 1e-6).profile);
  EXPECT_FALSE(judge(d, truth, 1e-6).justTheVariables);
  d.profiles = {profileOver({"x", "bed"}, 1.1e-6)};
  const UnknownJudgement right = judge(d, truth, 1e-6);
  EXPECT_TRUE(right.profile && right.justTheVariables && right.rightDirection && right.explained);
  EXPECT_TRUE(right.formula.empty());
  EXPECT_NEAR(right.heldOut, 1.1, 1e-9);
  d.profiles = {profileOver({"x"}, 1.3e-6), profileOver({"bed"}, 1.1e-6)};  // together
  EXPECT_TRUE(judge(d, truth, 1e-6).justTheVariables);
  EXPECT_TRUE(judge(d, truth, 1e-6).explained);
  d.profiles = {profileOver({"x"}, 1.2e-6)};
  EXPECT_FALSE(judge(d, truth, 1e-6).justTheVariables);
  EXPECT_FALSE(judge(d, truth, 1e-6).explained);
  d.profiles = {profileOver({"x", "bed"}, 1.1e-6), profileOver({"y"}, 1.0e-6)};  // the first alone
  EXPECT_TRUE(judge(d, truth, 1e-6).justTheVariables);
  d.profiles = {profileOver({"y"}, 1.1e-6), profileOver({"x", "bed"}, 1.0e-6)};
  EXPECT_FALSE(judge(d, truth, 1e-6).justTheVariables);
  d.profiles[0].direction = "x";
  EXPECT_FALSE(judge(d, truth, 1e-6).rightDirection);
}

TEST(UnknownJudgement, WhatFollowsTheTimeAloneIsToldRightlyAsTheLargestDriftAlongItsDirection) {
  const UncataloguedTruth truth = over({"time"});  // along z
  Diagnosis d;
  d.heldOut = 1.1e-6;
  DriftResult x, z;
  x.direction = "x", x.std = 0.2e-6;
  z.direction = "z", z.std = 0.9e-6;
  d.drift = {x, z};
  EXPECT_TRUE(judge(d, truth, 1e-6).byDrift);
  EXPECT_TRUE(judge(d, truth, 1e-6).justTheVariables && judge(d, truth, 1e-6).explained);
  EXPECT_FALSE(judge(d, over({"x", "time"}), 1e-6).byDrift);  // drift says nothing of where
  d.drift[0].std = 1e-6;
  EXPECT_FALSE(judge(d, truth, 1e-6).byDrift);
  d.drift.clear();
  EXPECT_FALSE(judge(d, truth, 1e-6).justTheVariables);
  d.drift = {z};
  d.missing.resize(1);  // a cause was named instead
  EXPECT_FALSE(judge(d, truth, 1e-6).byDrift);
}

TEST(UnknownJudgement, AFormulaIsJudgedWhereOneIsGiven) {
  Diagnosis d;
  d.formulas.emplace_back();
  d.formulas[0].effect = EffectSpec("formula").set("direction", "z").set("formula", "k1*x*bed");
  EXPECT_TRUE(judge(d, over({"x", "temperature bed"}), 1e-6).formulaRight);
  EXPECT_FALSE(judge(d, over({"x"}), 1e-6).formulaRight);
  EXPECT_FALSE(judge(d, over({"x", "temperature bed"}), 1e-6).justTheVariables);  // there is no profile
}

TEST(BenchmarkSession, WithoutNoiseItIsNotRoughEither) {
  const std::string plan = withoutNoise("instrument: {noise: {laser_um: 2}, rough: all}");
  const InstrumentSettings settings = InstrumentSettings::parse(plan, "plan");
  EXPECT_TRUE(settings.rough.none());
  for (const double size : {settings.noise.repeatability, settings.noise.laser, settings.noise.reference,
                            settings.noise.referenceAngular})
    EXPECT_EQ(size, 0.0);
}

TEST(SessionVariant, WithoutChangesItIsThePlan) {
  const Plan plan = planOf({}), shipped = Plan::parse(shippedPlan(), "plan", {}, Machine::load("three_axis"));
  ASSERT_EQ(plan.moves.size(), shipped.moves.size());
  for (std::size_t i = 0; i < plan.moves.size(); ++i)
    EXPECT_EQ(plan.moves[i].target, shipped.moves[i].target);
  EXPECT_DOUBLE_EQ(plan.artifact.repeatability, 0.3e-6);
}

TEST(SessionVariant, OneSidedContactsMoveOneWay) {
  SessionVariant variant;
  variant.oneSided = true;
  const Simulation s = run(variant);
  ASSERT_EQ(s.states.size(), 90u);
  for (const TrueState& state : s.states)
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT(state.approach(k), 0.0);
      EXPECT_LT(state.travel[static_cast<std::size_t>(k)], 0.0) << "what a reversal does is a constant";
    }
  variant.oneSided = false;
  std::set<double> sides;
  for (const TrueState& state : run(variant).states) sides.insert(state.travel[0]);
  EXPECT_GT(sides.size(), 1u) << "and is shown from both sides";
}

TEST(SessionVariant, FreeCentresAreFree) {
  SessionVariant variant;
  variant.freeCentres = true;
  const Simulation s = run(variant);
  ASSERT_EQ(s.session.artifact.features.size(), 9u);
  EXPECT_TRUE(s.session.artifact.poseKnown);
  for (const Feature& feature : s.session.artifact.features) EXPECT_FALSE(feature.known);
}

TEST(SessionVariant, ContactsAreAsManyAsTheBallsAllow) {
  for (const int contacts : {160, 675, 5000}) {
    SessionVariant variant;
    variant.contacts = contacts;
    const Plan plan = planOf(variant);
    EXPECT_NEAR(plan.measurements(), contacts, 4.5);
    const auto pauses = std::count_if(plan.moves.begin(), plan.moves.end(),
                                      [](const PlanMove& move) { return move.wait == 120.0; });
    EXPECT_NEAR(static_cast<double>(pauses), 11.0, 1.0);
  }
}

TEST(SessionVariant, NoiseIsOtherThanStated) {
  SessionVariant variant;
  variant.outliers = variant.heavyTails = true;
  const NoiseSettings noise = settingsOf(variant).noise;
  EXPECT_DOUBLE_EQ(noise.outlierShare, 0.03);
  EXPECT_DOUBLE_EQ(noise.outlierSize, 20e-6);
  EXPECT_DOUBLE_EQ(noise.studentDof, 3.0);
  SessionVariant twice, none, wrong;
  twice.statedNoise = "2";
  none.statedNoise = "none";
  wrong.statedNoise = "much";
  EXPECT_DOUBLE_EQ(planOf(twice).artifact.repeatability, 0.6e-6);
  EXPECT_DOUBLE_EQ(settingsOf(twice).noise.repeatability, 0.3e-6);
  EXPECT_TRUE(std::isnan(planOf(none).artifact.repeatability));
  EXPECT_THROW(planOf(wrong), InputError);
}

TEST(SessionVariant, TemperaturesGoWithTime) {
  SessionVariant variant;
  variant.timeTemperature = true;
  variant.contacts = 400;
  const Simulation s = run(variant);
  for (const Series& sensor : s.session.temperatures) {
    double t = 0.0, v = 0.0, tt = 0.0, vv = 0.0, tv = 0.0;
    const double n = static_cast<double>(sensor.time.size());
    for (std::size_t i = 0; i < sensor.time.size(); ++i) {
      const double a = sensor.time[i], b = sensor.value[i];
      t += a / n, v += b / n, tt += a * a / n, vv += b * b / n, tv += a * b / n;
    }
    EXPECT_GT((tv - t * v) / std::sqrt((tt - t * t) * (vv - v * v)), 0.9) << sensor.name;
  }
}

TrialOptions smallTrial(int effects) {
  SessionVariant variant;
  variant.contacts = 90;
  TrialOptions options;
  options.planYaml = varied(shippedPlan(), "plan", variant);
  options.planSource = "plan";
  options.effects = effects;
  return options;
}

TEST(Trial, HidesTheSameOnARoughMachine) {
  MM_THOROUGH_ONLY("every day Roughness.WhatIsHiddenIsTheSameOnARoughMachine stands for it");
  const Machine machine = Machine::load("three_axis");
  TrialOptions options = smallTrial(2);
  const Trial smooth = runTrial(machine, options, 4);
  options.rough = "all,quantised";
  const Trial rough = runTrial(machine, options, 4);
  ASSERT_EQ(smooth.hiddenText.size(), 2u);
  EXPECT_EQ(smooth.hiddenText, rough.hiddenText);
  EXPECT_EQ(smooth.seed, rough.seed);
  EXPECT_FALSE(sameCause(smooth.hidden[0], smooth.hidden[1]));
  EXPECT_EQ(smooth.score.hits.size(), 2u);
  EXPECT_GT(rough.heldOutEnd, smooth.heldOutEnd);
}

TEST(Trial, APairIsKeptHoweverAlikeItsEffectsAre) {
  // A linear and an exponential drift of one direction look much the same.
  TrialOptions options = smallTrial(2);
  options.only = {"{type: time_drift, direction: x}", "{type: warm_up, direction: x}"};
  const Trial trial = runTrial(Machine::load("three_axis"), options, 1);
  EXPECT_FALSE(trial.notShown);
  EXPECT_EQ(trial.seed, 1000u);
}

TEST(Trial, TheVerySameCauseIsNotHiddenTwice) {
  TrialOptions options = smallTrial(2);
  options.only = {"backlash:x"};
  EXPECT_TRUE(runTrial(Machine::load("three_axis"), options, 1).notShown);
}

TEST(Trial, AnOracleIsSureOfWhatIsLargeAndNotOfWhatIsLost) {
  const Machine machine = Machine::load("three_axis");
  TrialOptions options = smallTrial(1);
  options.only = {"backlash:x"};
  const Oracle oracle = oracleOf(machine, options, 60, 1);
  options.size = 2.0;
  EXPECT_GT(runTrial(machine, options, 1, &oracle).oracleGain.value(), 50.0);
  options.size = 0.01;
  EXPECT_LT(runTrial(machine, options, 1, &oracle).oracleGain.value(), Oracle::sure());
  EXPECT_FALSE(runTrial(machine, options, 1).oracleGain.has_value());
}

}  // namespace
}  // namespace mm
