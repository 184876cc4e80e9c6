#include "model/model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "base/error.h"
#include "base/units.h"
#include "effects/effect_words.h"
#include "effects/registry.h"
#include "model/observed_domain.h"
#include "model/session_states.h"

namespace mm {
namespace {

Observation contact(double time, std::vector<double> position, int feature) {
  Observation o;
  o.time = time;
  o.row = static_cast<std::int64_t>(time) + 2;
  o.velocity.assign(position.size(), 0.001);
  o.travel.assign(position.size(), 1.0);
  o.position = std::move(position);
  o.feature = feature;
  return o;
}

/// Three contacts on a ball, two temperatures, a humidity.
Session exampleSession() {
  Session session(Machine::load("three_axis"));
  session.source = "example";
  Feature ball, point;
  ball.name = "b0";
  ball.position = {0.001, 0.002, 0.0};
  ball.radius = 0.004;
  point.kind = FeatureKind::kPoint;
  point.name = "target";
  session.artifact.features = {point, ball};
  session.observations = {contact(10, {0.010, 0.0, 0.0}, 1), contact(20, {-0.010, 5e-7, 0.0}, 1),
                          contact(40, {-0.010, 0.020, 0.0}, 1)};
  session.observations[1].velocity = {-0.02, kNotMeasured, 0.0};
  session.observations[2].approach = {0, -1, 0};
  session.temperatures = {{"bed", "degC", {0, 20, 40}, {20, 22, 30}}, {"air", "degC", {}, {}}};
  session.covariates = {{"humidity", "percent", {0, 40}, {40, 60}}};
  return session;
}

TEST(ObservedDomain, isWhatTheSessionSaw) {
  const Domain d = observedDomain(exampleSession());
  ASSERT_EQ(d.joints.size(), 3u);
  EXPECT_EQ(d.lower, (std::vector<double>{-0.010, 0.0, 0.0}));
  EXPECT_EQ(d.upper, (std::vector<double>{0.010, 0.020, 0.0}));
  EXPECT_EQ(d.positions[0], (std::vector<double>{-0.010, 0.010}));
  ASSERT_EQ(d.positions[1].size(), 2u);  // 0.5 um apart is one place
  EXPECT_NEAR(d.positions[1][0], 2.5e-7, 1e-12);
  EXPECT_EQ(d.sensors, (std::vector<std::string>{"bed", "air"}));
  EXPECT_EQ(d.sensorLower[0], 21.0);
  EXPECT_EQ(d.sensorUpper[0], 30.0);
  EXPECT_TRUE(std::isnan(d.sensorLower[1]));
  EXPECT_EQ(d.covariateLower[0], 45.0);
  EXPECT_EQ(d.features, (std::vector<std::string>{"target", "b0"}));
  EXPECT_EQ(d.featureRadius, (std::vector<double>{0.0, 0.004}));
  EXPECT_EQ(d.duration, 40.0);
  EXPECT_EQ(d.maxSpeed, 0.02);
  EXPECT_FALSE(d.laser);
  EXPECT_EQ(d.tipUpper, Eigen::Vector3d(0.010, 0.020, 0.0));
}

TEST(ObservedDomain, listsNoPositionsOfASweep) {
  Session session = exampleSession();
  for (int i = 0; i < 70; ++i) session.observations.push_back(contact(50 + i, {0.001 * i, 0, 0}, 1));
  const Domain d = observedDomain(session);
  EXPECT_TRUE(d.positions[0].empty());
  EXPECT_EQ(d.positions[2].size(), 1u);
}

TEST(SessionStates, areTheInputsAtEachObservation) {
  const Session session = exampleSession();
  Domain domain = observedDomain(session);
  std::swap(domain.sensors[0], domain.sensors[1]);  // the model's order counts
  SessionStates states(session, domain);
  ASSERT_EQ(states.size(), 3u);
  EXPECT_TRUE(std::isnan(states[0].temperature[0]));
  EXPECT_DOUBLE_EQ(states[0].temperature[1], 21.0);
  EXPECT_DOUBLE_EQ(states[1].covariate[0], 50.0);
  EXPECT_EQ(states[1].travel[0], 1.0);
  EXPECT_EQ(states[2].feature, 1);
  EXPECT_EQ(states[2].featureRadius, 0.004);
  EXPECT_EQ(states[2].tip, Eigen::Vector3d(-0.010, 0.020, 0.0));
  ASSERT_NE(states[0].history, nullptr);
  EXPECT_DOUBLE_EQ(states[0].history->lagged(1, 0.0, 30.0, nullptr), 26.0);
  EXPECT_EQ(states[0].approach.norm(), 0.0);

  GeometricStart start;
  start.poses.resize(1);
  start.features = {{0, 0, 0}, {0.0, 0.0, 0.010}};
  start.offsets = {Eigen::Vector3d::Zero()};
  states.aim(start);
  EXPECT_LT((states[0].approach - Eigen::Vector3d(-1, 0, 1).normalized()).norm(), 1e-12);
  EXPECT_EQ(states[2].approach, Eigen::Vector3d(0, -1, 0));  // recorded
}

TEST(SessionStates, takeTheBeamOfALaserAsApproach) {
  Session session(Machine::load("five_axis"));
  session.observations = {contact(1, {0, 0, 0, 0.5, 0.3}, -1)};
  session.observations[0].laserReading = 0.001;
  const Domain domain = observedDomain(session);
  EXPECT_TRUE(domain.laser);
  const SessionStates states(session, domain);
  EXPECT_LT((states[0].approach - states[0].orientation.col(2)).norm(), 1e-15);
  EXPECT_LT(
      (states[0].tip - session.machine.nominal(session.observations[0].position.data(), 0.0).position).norm(),
      1e-15);
}

TEST(SessionStates, refuseAnotherMachine) {
  EXPECT_THROW(SessionStates(exampleSession(), observedDomain(Session(Machine::load("five_axis")))),
               InputError);
}

/// A state of some machine that has everything an effect can ask for.
State fullState(const Model& model, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  State state;
  for (const Joint& joint : model.domain().joints)
    state.position.push_back((joint.kind == JointKind::kLinear ? 0.02 : 1.0) * u(random));
  state.velocity.assign(state.position.size(), 0.01);
  state.travel.assign(state.position.size(), -1.0);
  state.temperature = {20 + 5 * u(random), 20 + 5 * u(random)};
  state.time = 100;
  state.laserReading = kNotMeasured;
  model.place(state);
  return state;
}

Model exampleModel(const std::string& machineName) {
  const Machine machine = Machine::load(machineName);
  Domain domain;
  domain.setMachine(machine);
  domain.lower.assign(machine.joints().size(), -0.02);
  domain.upper.assign(machine.joints().size(), 0.02);
  domain.positions.resize(machine.joints().size());
  domain.sensors = {"bed", "frame"};
  domain.sensorLower = {15, 15};
  domain.sensorUpper = {25, 25};
  domain.duration = 200;
  std::vector<EffectSpec> specs;
  for (const char* axis : {"x", "y", "z"})
    specs.push_back(EffectSpec("mmt_deviation").set("axis", axis).set("lead_mm", 1.0));
  specs.push_back(EffectSpec("backlash").set("axis", "x"));
  specs.push_back(EffectSpec("thermal_growth").set("direction", "z").set("sensor", "bed"));
  specs.push_back(EffectSpec("formula").set("direction", "y").set("formula", "k1*x*z + k2*sin(k3*frame)"));
  return {machine, domain, specs};
}

class Derivatives : public testing::TestWithParam<const char*> {};

TEST_P(Derivatives, agreeWithCentralDifferences) {
  const Model model = exampleModel(GetParam());
  ASSERT_EQ(model.parameterCount(), 26);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> u(-1, 1);
  Model::Workspace work;
  for (int i = 0; i < 20; ++i) {
    const State state = fullState(model, random);
    Eigen::VectorXd p = model.start();
    for (int k = 0; k < p.size(); ++k) p[k] += model.parameter(k).scale * u(random);
    Eigen::Matrix<double, 6, Eigen::Dynamic> byParameter;
    const ProbePose pose = model.corrected(state, p.data(), work, &byParameter);
    EXPECT_EQ((model.corrected(state, p.data(), work).position - pose.position).norm(), 0.0);
    for (int k = 0; k < p.size(); ++k) {
      const double h = 2e-4 * model.parameter(k).scale;
      Eigen::VectorXd up = p, down = p;
      up[k] += h;
      down[k] -= h;
      const Eigen::Vector3d moved = model.corrected(state, up.data(), work).position -
                                    model.corrected(state, down.data(), work).position;
      EXPECT_LT((byParameter.col(k).head<3>() * 2 * h - moved).norm(), 1e-4 * moved.norm() + 1e-16)
          << model.parameter(k).name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, Derivatives, testing::Values("three_axis", "five_axis"));

TEST(Model, isNominalPlusEquation13OfMmt) {
  const Model model = exampleModel("three_axis");
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> u(-1, 1);
  Model::Workspace work;
  for (int i = 0; i < 50; ++i) {
    State state = fullState(model, random);
    const double X = state.position[0], Y = state.position[1], Z = state.position[2], lead = 1e-3;
    const double scale = 1e-4 * u(random), c2 = 1e-4 * u(random), phi = 3 * u(random),
                 straightY = 0.01 * u(random), straightZ = 0.01 * u(random), alphaY = 1e-3 * u(random),
                 alphaZ = 1e-3 * u(random);
    Eigen::VectorXd p = Eigen::VectorXd::Zero(model.parameterCount());
    const double own[] = {scale, c2 * std::cos(phi), c2 * std::sin(phi), straightY, straightZ, alphaY,
                          alphaZ};
    for (int k = 0; k < 7; ++k) p[k] = own[k];
    const double dx = scale * X + straightY * Y * Y + straightZ * Z * Z +
                      c2 * X * std::sin(2 * kPi * X / lead + phi) + Y * std::cos(kPi / 2 + alphaY) +
                      Z * std::cos(kPi / 2 + alphaZ);
    const Eigen::Vector3d corrected = model.corrected(state, p.data(), work).position;
    EXPECT_LT((corrected - Eigen::Vector3d(X + dx, Y, Z)).norm(), 1e-15);
  }
}

TEST(Model, isUnknownWhereAnInputIs) {
  const Model model = exampleModel("three_axis");
  std::mt19937_64 random(8);
  State state = fullState(model, random);
  const Eigen::VectorXd p = model.start();
  Model::Workspace work;
  EXPECT_TRUE(model.corrected(state, p.data(), work).position.allFinite());
  state.temperature[0] = kNotMeasured;
  EXPECT_FALSE(model.corrected(state, p.data(), work).position.allFinite());
}

TEST(OwnedEffect, ActsFromItsSessionOnAndWithItsStylus) {
  Domain domain = domainOverTravel(Machine::load("three_axis"));
  domain.recordings = 2;
  domain.styli = {"A", "B"};
  const auto errorOf = [&](const EffectSpec& spec, int recording, int stylus, const Domain& in) {
    Model model(Machine::load("three_axis"), in, {spec});
    State state;
    state.position = {0.01, 0.0, 0.0};
    state.velocity = state.travel = {0.0, 0.0, 0.0};
    state.recording = recording;
    state.stylus = stylus;
    model.place(state);
    Model::Workspace work;
    const double p[] = {1e-3};
    return model.corrected(state, p, work).position.x() - 0.01;
  };
  const EffectSpec later = EffectSpec("scale").set("axis", "x").set("from_session", 2.0);
  EXPECT_EQ(errorOf(later, 0, 0, domain), 0.0);
  EXPECT_NEAR(errorOf(later, 1, 0, domain), 1e-5, 1e-12);
  EXPECT_NEAR(errorOf(later, State().recording, 0, domain), 1e-5, 1e-12) << "and what comes after them";
  Domain one = domain;
  one.recordings = 1;
  EXPECT_NEAR(errorOf(later, 0, 0, one), 1e-5, 1e-12) << "a session that is none of them is later";
  const EffectSpec ofB = EffectSpec("scale").set("axis", "x").set("stylus", "B");
  EXPECT_EQ(errorOf(ofB, 0, 0, domain), 0.0);
  EXPECT_NEAR(errorOf(ofB, 0, 1, domain), 1e-5, 1e-12);
  const EffectPtr effect = createEffect(later, domain);
  EXPECT_EQ(effect->spec().yaml(), "{type: scale, axis: x, from_session: 2}");
  EXPECT_EQ(inWords(effect->spec()), "scale of x, from session 2 on");
  EXPECT_THROW(createEffect(EffectSpec(later).set("from_session", 3.0), domain), InputError);
  EXPECT_THROW(createEffect(EffectSpec(later).set("from_session", "two"), domain), InputError);
  EXPECT_THROW(createEffect(EffectSpec(ofB).set("stylus", "C"), domain), InputError);
}

}  // namespace
}  // namespace mm
