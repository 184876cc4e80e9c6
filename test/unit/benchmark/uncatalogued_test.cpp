#include "uncatalogued.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "base/error.h"
#include "diagnosis/diagnose.h"
#include "model/observed_domain.h"
#include "nine_ball_plate.h"
#include "session/plan.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

const Machine& machine() {
  static const Machine loaded = Machine::load("three_axis");
  return loaded;
}

/// The shipped session with fewer contacts a ball and without noise of the contacts.
const Plan& plan() {
  static const Plan read = [] {
    std::ifstream in("config/plans/nine_ball_plate.yaml");
    std::ostringstream text;
    text << in.rdbuf();
    std::string yaml = text.str();
    const auto replace = [&](const std::string& from, const std::string& to) {
      const std::size_t at = yaml.find(from);
      if (at == std::string::npos) throw InputError("the plan has no '" + from + "'");
      yaml.replace(at, from.size(), to);
    };
    replace("points: 75", "points: 40");
    replace("every: 60", "every: 32");
    replace("noise: {repeatability_um: 0.3", "noise: {repeatability_um: 0");
    return Plan::parse(yaml, "nine_ball_plate", {}, machine());
  }();
  return read;
}

SimulationRequest requestOf(const std::string& hide, std::uint64_t seed) {
  SimulationRequest request;
  request.kinds = &judgedKinds();
  if (!hide.empty()) request.hide = {hide};
  request.seed = seed;
  return request;
}

Simulation simulatedWith(const std::string& hide, std::uint64_t seed = 1) {
  return simulate(machine(), plan(), requestOf(hide, seed));
}

/// The instrument alone: who asks for its errors needs no session of it.
SimulatedInstrument built(const std::string& hide, std::uint64_t seed) {
  return makeInstrument(machine(), plan(), requestOf(hide, seed));
}

Eigen::Vector3d unitOf(const std::string& direction, const TrueState& state) {
  return direction == "approach" ? state.approach : Eigen::Vector3d::Unit(direction[0] - 'x');
}

bool lists(const UncataloguedTruth& truth, const std::string& name) {
  return std::find(truth.variables.begin(), truth.variables.end(), name) != truth.variables.end();
}

/// The error along its direction; the joints of this machine are the axes of workpiece.
double errorOf(const Source& source, const Condition& condition, const UncataloguedTruth& truth) {
  Distortion d(3);
  source(condition, d);
  const Eigen::Vector3d error = d.tipShift + Eigen::Vector3d(d.travel[0], d.travel[1], d.travel[2]);
  if (truth.direction != "approach") return error.dot(Eigen::Vector3d::Unit(truth.direction[0] - 'x'));
  return error.dot(
      Eigen::Vector3d(condition.velocity[0], condition.velocity[1], condition.velocity[2]).normalized());
}

/// Largest change of the error over the conditions when each is altered.
template <typename Change>
double changeBy(const Source& source, const UncataloguedTruth& truth,
                const std::vector<Condition>& conditions, Change change) {
  double largest = 0.0;
  for (const Condition& condition : conditions) {
    Condition altered = condition;
    change(altered);
    largest =
        std::max(largest, std::abs(errorOf(source, altered, truth) - errorOf(source, condition, truth)));
  }
  return largest;
}

std::vector<Condition> conditionsOf(const Simulation& s) {
  std::vector<Condition> conditions;
  for (const TrueState& state : s.states) conditions.push_back(s.truth->condition(state));
  return conditions;
}

TEST(Uncatalogued, ThereAreManyKindsAndNoneIsOfTheCatalogue) {
  std::set<std::string> types, causes;
  for (const UncataloguedKind& kind : uncataloguedKinds()) {
    EXPECT_TRUE(isUncatalogued(kind.type)) << kind.type;
    EXPECT_FALSE(kind.variables.empty()) << kind.type;
    types.insert(kind.type);
    causes.insert(kind.cause);
  }
  EXPECT_EQ(types.size(), uncataloguedKinds().size());
  EXPECT_EQ(causes.size(), uncataloguedKinds().size());
  EXPECT_GE(types.size(), 24u);
  for (const SourceKind& kind : sourceKinds()) EXPECT_FALSE(isUncatalogued(kind.type)) << kind.type;
}

TEST(Uncatalogued, SizeIsTheRmsAlongTheDirectionAndNothingGoesElsewhere) {
  for (const UncataloguedKind& kind : uncataloguedKinds()) {
    const Simulation s = simulatedWith(kind.type + "=2um", 7);
    ASSERT_EQ(s.hidden.size(), 1u);
    ASSERT_EQ(s.missed, 0) << kind.type;
    const UncataloguedTruth truth = uncataloguedTruth(s.hidden[0], machine());
    double mean = 0.0, square = 0.0, aside = 0.0;
    const double count = static_cast<double>(s.states.size());
    for (std::size_t i = 0; i < s.states.size(); ++i) {
      const Eigen::Vector3d error = s.truePositions[i] - s.truth->nominal(s.states[i]);
      const Eigen::Vector3d unit = unitOf(truth.direction, s.states[i]);
      const double along = error.dot(unit);
      mean += along / count;
      square += along * along / count;
      aside = std::max(aside, (error - along * unit).norm());
    }
    EXPECT_NEAR(std::sqrt(square - mean * mean), 2e-6, 0.06e-6) << s.hidden[0].text();
    EXPECT_NEAR(mean, 0.0, 0.1e-6) << s.hidden[0].text();
    EXPECT_LT(aside, 1e-10) << s.hidden[0].text();
  }
}

TEST(Uncatalogued, TheErrorDependsOnJustTheVariablesItStates) {
  const std::vector<Condition> conditions = conditionsOf(simulatedWith(""));
  const char* const joints[] = {"x", "y", "z"};
  constexpr double kNothing = 1e-13, kSomething = 2e-8;  // m, of an error of 2 um
  for (const UncataloguedKind& kind : uncataloguedKinds()) {
    const SimulatedInstrument s = built(kind.type + "=2um", 11);
    const UncataloguedTruth truth = uncataloguedTruth(s.hidden[0], machine());
    const Truth hidden = s.machine.truth();
    ASSERT_EQ(hidden.physics().sources.size(), 1u);
    const Source& source = hidden.physics().sources[0];
    const auto expect = [&](double change, const std::string& name, bool stated) {
      if (stated)
        EXPECT_GT(change, kSomething) << s.hidden[0].text() << " by " << name;
      else
        EXPECT_LT(change, kNothing) << s.hidden[0].text() << " by " << name;
    };
    for (int j = 0; j < 3; ++j) {
      const std::string joint = joints[j];
      const bool tip = lists(truth, "tip speed") || lists(truth, "approach");
      expect(changeBy(source, truth, conditions, [&](Condition& c) { c.drive[j] += 0.7e-3; }), joint,
             lists(truth, joint));
      expect(changeBy(source, truth, conditions, [&](Condition& c) { c.velocity[j] *= -1.7; }),
             joint + " speed",
             tip || lists(truth, joint + " speed") || lists(truth, joint + " travel direction"));
    }
    expect(changeBy(source, truth, conditions, [](Condition& c) { c.time += 100.0; }), "time",
           lists(truth, "time"));
    for (std::size_t b = 0; b < 4; ++b) {
      const std::string name =
          ThermalModel::usualBodies().size() > b ? ThermalModel::usualBodies()[b].name : "air";
      expect(changeBy(source, truth, conditions, [&](Condition& c) { c.bodies[b] += 0.3; }),
             "temperature " + name, lists(truth, "temperature " + name));
    }
    expect(changeBy(source, truth, conditions, [](Condition& c) { c.covariates[0] += 1.0; }), "humidity",
           lists(truth, "humidity"));
  }
}

TEST(Uncatalogued, AnErrorByTheDirectionOfTravelIsTheSameAtEverySpeed) {
  const Simulation s = simulatedWith("uncatalogued_friction_lever:x/y=2um", 3);
  const Source& source = s.truth->physics().sources[0];
  const auto errorAt = [&](Condition c, double velocity) {
    c.velocity = {velocity, 1e-3, -1e-3};
    Distortion d(3);
    source(c, d);
    return d.travel[0];
  };
  double sum = 0.0;
  const std::vector<Condition> conditions = conditionsOf(s);
  for (const Condition& c : conditions) {
    EXPECT_NEAR(errorAt(c, 1e-3), errorAt(c, 4e-3), 1e-12);
    EXPECT_NEAR(errorAt(c, -1e-3), errorAt(c, -4e-3), 1e-12);
    sum += std::pow((errorAt(c, 1e-3) - errorAt(c, -1e-3)) / 2.0, 2);
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(conditions.size())), 2e-6, 0.15e-6);
}

TEST(Uncatalogued, WhatWasHiddenCanBeHiddenAgainAndScales) {
  for (const UncataloguedKind& kind : uncataloguedKinds()) {
    const Simulation first = simulatedWith(kind.type, 5);
    HiddenSource twice = first.hidden[0];
    twice.numbers[0].value *= 2.0;
    const SimulatedInstrument again = built(twice.text(), 5);
    const Truth larger = again.machine.truth();
    EXPECT_EQ(again.hidden[0].text(), twice.text());
    const std::vector<Condition> conditions = conditionsOf(first);
    const UncataloguedTruth truth = uncataloguedTruth(twice, machine());
    const double expected = std::abs(twice.numbers[0].value);
    for (std::size_t i = 0; i < conditions.size(); i += 37) {
      const double one = errorOf(first.truth->physics().sources[0], conditions[i], truth);
      const double two = errorOf(larger.physics().sources[0], conditions[i], truth);
      EXPECT_NEAR(two, 2.0 * one, 0.01 * expected) << twice.text();
    }
  }
}

TEST(Uncatalogued, RandomNeverDrawsThem) {
  for (std::uint64_t seed = 1; seed <= 150; ++seed)
    EXPECT_FALSE(isUncatalogued(built("random", seed).hidden[0].type));
}

TEST(Uncatalogued, ADiagnosisTellsAProfileOverTheVariables) {
  constexpr double kPlanNoise = 0.3e-6;  // m, of the plan
  const Simulation s = simulate(
      machine(), test::everydayPlate(machine()),
      requestOf("{type: uncatalogued_damp_bow, axis: x, direction: z, covariate: humidity, size: 3 um}", 37));
  const std::vector<EffectSpec> nothing;
  const Diagnosis d = diagnose(s.session, Model(machine(), observedDomain(s.session), nothing), {});
  EXPECT_EQ(d.verdict, Verdict::kUnknownEffect) << d.sentence;
  ASSERT_FALSE(d.profiles.empty()) << d.sentence;
  EXPECT_EQ(d.profiles[0].direction, "z");
  std::vector<std::string> variables = d.profiles[0].variables;
  std::sort(variables.begin(), variables.end());
  EXPECT_EQ(variables, (std::vector<std::string>{"humidity", "x"})) << d.sentence;
  EXPECT_LT(d.heldOut, 1.15 * kPlanNoise);
  EXPECT_FALSE(d.profiles[0].curve.empty());
}

TEST(Uncatalogued, WhatThePlanCannotShowIsRefused) {
  const Plan standing = Plan::parse("reference: {joint: x, positions_mm: [10, 150], runs: 1}\n", "reference",
                                    {}, Machine::load("five_axis"));
  for (const char* text : {"uncatalogued_friction_lever:x/y=1um",  // nothing is touched
                           "uncatalogued_diagonal_ribs:y/z=1um",   // y and z stand still
                           "uncatalogued_nothing", "uncatalogued_guide_load:x/x=1um"})
    EXPECT_THROW(simulate(Machine::load("five_axis"), standing, requestOf(text, 1)), InputError) << text;
  EXPECT_THROW(
      simulate(Machine::load("five_axis"), standing, requestOf("uncatalogued_diagonal_ribs:y/z=1um", 1)),
      SourceNotShown)
      << "by which a benchmark draws another";
}

}  // namespace
}  // namespace mm
