#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "machine/error.h"
#include "session/plan.h"
#include "simulation/simulate.h"
#include "tools/benchmark_session.h"
#include "tools/formula_judge.h"

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
    for (int k = 0; k < 3; ++k) EXPECT_LT(state.approach(k), 0.0);
}

TEST(SessionVariant, ContactsFromOneSideDoNotShowWhatReversalDoes) {
  SessionVariant variant;
  variant.contacts = 90;
  SimulationRequest request;
  const Machine machine = Machine::load("three_axis");
  for (const char* text : {"uncatalogued_reversal_heave:x/z=1um", "uncatalogued_reversal_heave:y/z=1um"}) {
    request.hide = {text};
    variant.oneSided = true;
    EXPECT_THROW(makeInstrument(machine, planOf(variant), request), SourceNotShown) << text;
    variant.oneSided = false;
    EXPECT_NO_THROW(makeInstrument(machine, planOf(variant), request)) << text;
  }
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

}  // namespace
}  // namespace mm
