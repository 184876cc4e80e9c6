// LASER on the simulated machine, judged at fresh states and by what the simulation hid.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "base/units.h"
#include "compensation/compensator.h"
#include "design/point_set.h"
#include "design/session_doubts.h"
#include "estimation/ball_centres.h"
#include "long_tests.h"
#include "simulation/simulate.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

/// What (7) describes, hidden in the chain: probe zero, beam, omega_B and y32.
const std::vector<std::string> kMount = {"laser_mount=200um,beam=3000arcsec", "rotary_zero:b=-120arcsec",
                                         "rotary_axis_offset:a/y=-60um"};

ModelSpec mountModel() {
  ModelSpec spec;
  spec.effects.emplace_back("laser_mount");
  return spec;
}

struct Measured {
  explicit Measured(std::uint64_t seed, const std::string& changed = {})
      : machine(Machine::load("five_axis")),
        plan(changed.empty() ? Plan::load("config/plans/five_axis_ball.yaml", machine)
                             : Plan::parse(changed, "plan.yaml", ".", machine)),
        simulation(simulate(machine, plan, {kMount, seed, ""})) {}
  CalibrationResult fit(const Session& session) const {
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    return calibrate(session, modelFor(session, mountModel().effects), options);
  }
  Machine machine;
  Plan plan;
  Simulation simulation;
};

/// RMS of the three-dimensional error (m) of the corrected surface point at states that were not measured.
double freshError(const Measured& m, const Session& fitted) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  const Recalibration done = recalibrate(fitted, mountModel(), options);
  const Compensator compensator(done.calibration);
  std::mt19937_64 generator(99);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Domain& domain = done.calibration.domain;
  double sum = 0.0;
  constexpr int kStates = 200;
  for (int i = 0; i < kStates; ++i) {
    TrueState at;
    State state = compensator.blankState();
    for (std::size_t j = 0; j < domain.joints.size(); ++j) {
      at.position.push_back(domain.lower[j] + unit(generator) * (domain.upper[j] - domain.lower[j]));
      at.travel.push_back(1.0);
      at.velocity.push_back(0.0);
    }
    at.laserReading = (8.0 * unit(generator) - 4.0) * kMillimetre;
    state.position = at.position;
    state.travel = at.travel;
    state.laserReading = at.laserReading;
    compensator.model().place(state);
    sum += (compensator.apply(state).corrected.position - m.simulation.truth->position(at)).squaredNorm();
  }
  return std::sqrt(sum / kStates);
}

TEST(LaserMountSimulated, TwelvePosturesOfThirtyContactsGiveTheFieldWithinAFifthOfAMicrometre) {
  double square = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Measured m(seed);
    ASSERT_EQ(m.simulation.session.observations.size(), 360u);
    square += std::pow(freshError(m, m.simulation.session), 2) / 5.0;
  }
  EXPECT_LE(std::sqrt(square), 0.2e-6);
}

TEST(LaserMountSimulated, TheTwoStepsOfThePaperGiveTheSameMount) {
  // one reading in a posture, as in the paper: both ends of the range over the postures
  std::string plan =
      "artifact: {name: ball, balls: [{name: s0, centre: free, centre_mm: [-65, -25, 0], radius_mm: 6.0}]}\n"
      "probe: laser\npostures:\n";
  for (const auto& [reading, at] :
       {std::pair("-4",
                  "[{b_deg: -90, a_deg: -90}, {b_deg: -60, a_deg: 90}, {b_deg: -45, a_deg: -90}, {b_deg: 0, "
                  "a_deg: 60}, {b_deg: -30, a_deg: -60}, {b_deg: -90, a_deg: 60}]"),
        std::pair(
            "4",
            "[{b_deg: -90, a_deg: -30}, {b_deg: -60, a_deg: -45}, {b_deg: -45, a_deg: 45}, {b_deg: -30, "
            "a_deg: 90}, {b_deg: 0, a_deg: -90}, {b_deg: 0, a_deg: 0}]")})
    plan += std::string("  - {feature: s0, points: 30, cone_deg: 40, readings_mm: [") + reading +
            "], at: " + at + "}\n";
  plan += "instrument: {noise: {repeatability_um: 0, laser_um: 0.4}}\n";
  const Measured m(3, plan);
  const Session centres =
      centresByPosture(m.simulation.session, modelFor(m.simulation.session, mountModel().effects));
  ASSERT_EQ(centres.observations.size(), 12u);
  const CalibrationResult together = m.fit(m.simulation.session), steps = m.fit(centres);
  for (int k = 0; k < 8; ++k)
    EXPECT_NEAR(steps.x[k], together.x[k], 5.0 * std::hypot(steps.std(k), together.std(k))) << k;
  EXPECT_LT(steps.figures.rms, 1e-6);
}

std::string planOf(const std::string& at, const std::string& readings = "[-4, 4]") {
  return "artifact: {name: ball, balls: [{name: s0, centre: free, centre_mm: [-65, -25, 0], radius_mm: "
         "6.0}]}\n"
         "probe: laser\npostures:\n  - {feature: s0, points: 20, cone_deg: 40, readings_mm: " +
         readings + ", at: " + at + "}\ninstrument: {noise: {repeatability_um: 0, laser_um: 0.4}}\n";
}

bool says(const std::vector<std::string>& doubts, const std::string& what) {
  for (const std::string& d : doubts)
    if (d.find(what) != std::string::npos) return true;
  return false;
}

TEST(LaserMountDoubts, GoodPosturesRaiseNone) {
  EXPECT_TRUE(postureDoubts(Measured(1).simulation.session).empty());
}

TEST(LaserMountDoubts, OneB) {
  const Measured m(1, planOf("[{b_deg: -45, a_deg: -60}, {b_deg: -45, a_deg: 0}, {b_deg: -45, a_deg: 60}]"));
  EXPECT_TRUE(says(postureDoubts(m.simulation.session), "every posture has b = -45 deg"));
  const PointSet set = [&] {
    const ModelSpec model = mountModel();
    return checkPointSet(m.simulation.session, &model);
  }();
  EXPECT_LT(set.identifiability.rank, set.identifiability.parameters);
  ASSERT_FALSE(set.advice.postures.empty());
  const int b = m.machine.findJoint("b");
  bool turns = false;
  for (const ProposedPosture& p : set.advice.postures) turns |= std::abs(p.position[b] + 45 * kDegree) > 0.5;
  EXPECT_TRUE(turns);
}

TEST(LaserMountDoubts, AOfOneSign) {
  const Measured m(1, planOf("[{b_deg: -60, a_deg: 30}, {b_deg: -45, a_deg: 60}, {b_deg: -30, a_deg: 75}]"));
  EXPECT_TRUE(says(postureDoubts(m.simulation.session), "a is of one sign"));
}

TEST(LaserMountDoubts, OneReading) {
  const Measured m(
      1, planOf("[{b_deg: -90, a_deg: 30}, {b_deg: -45, a_deg: -60}, {b_deg: 0, a_deg: 60}]", "[2]"));
  // contacts of one posture lie on the ball at one nominal reading; the true ones differ by the mount's error
  Session session = m.simulation.session;
  for (Observation& o : session.observations) o.laserReading = 2e-3;
  EXPECT_TRUE(says(postureDoubts(session), "every reading of the laser is 2 mm"));
}

TEST(LaserMountDoubts, ReadingOutOfRange) {
  Session session = Measured(1).simulation.session;
  session.observations[17].laserReading = 0.4;
  const std::vector<std::string> doubts = postureDoubts(session);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_NE(doubts[0].find("row " + std::to_string(session.observations[17].row) + ": reading 400 mm"),
            std::string::npos)
      << doubts[0];
}

TEST(LaserMountDoubts, WrongSignOfAJoint) {
  const Measured m(2);
  EXPECT_TRUE(fitDoubts(m.fit(m.simulation.session)).empty());
  const std::vector<const char*> everyday = {"b"}, all = {"a", "b", "z"};
  for (const char* name : mm_test::thoroughTests() ? all : everyday) {
    Session session = m.simulation.session;
    const int j = m.machine.findJoint(name);
    for (Observation& o : session.observations) o.position[j] = -o.position[j];
    const std::vector<std::string> doubts = fitDoubts(m.fit(session));
    const bool named = says(doubts, std::string("probably a sign error of ") + name) ||
                       says(doubts, std::string("or as well of ") + name);
    EXPECT_TRUE(named) << name << ": " << (doubts.empty() ? "nothing" : doubts[0]);
  }
}

TEST(LaserMountDoubts, BeamThatMissesTheBall) {
  const Measured m(2);
  Session session = m.simulation.session;
  Observation& o = session.observations[40];
  const Eigen::Matrix3d probe = m.machine.nominal(o.position.data(), o.laserReading).orientation;
  const auto jacobian = m.machine.jacobian(o.position.data(), o.laserReading);
  // 20 mm to the side of the ball, square to the beam
  const Eigen::Vector3d step = jacobian.block<3, 3>(0, 0).colPivHouseholderQr().solve(0.020 * probe.col(0));
  for (int k = 0; k < 3; ++k) o.position[k] += step[k];
  const std::vector<std::string> doubts = fitDoubts(m.fit(session));
  EXPECT_TRUE(says(doubts, "row " + std::to_string(o.row) + ": the beam passes the centre of 's0'"))
      << (doubts.empty() ? "nothing" : doubts[0]);
}

/// The weak direction of four poor postures is cured by what is proposed.
TEST(LaserMountPostures, TheProposedOnesCure) {
  const Measured poor(1, planOf("[{b_deg: 0, a_deg: 0}, {b_deg: -5, a_deg: 10}, {b_deg: 0, a_deg: 20}]"));
  const ModelSpec model = mountModel();
  const PointSet set = checkPointSet(poor.simulation.session, &model);
  ASSERT_FALSE(set.advice.postures.empty());
  std::string at = "[{b_deg: 0, a_deg: 0}, {b_deg: -5, a_deg: 10}, {b_deg: 0, a_deg: 20}";
  for (const ProposedPosture& p : set.advice.postures)
    at += ", {b_deg: " + std::to_string(p.position[poor.machine.findJoint("b")] / kDegree) +
          ", a_deg: " + std::to_string(p.position[poor.machine.findJoint("a")] / kDegree) + "}";
  const Measured cured(1, planOf(at + "]"));
  EXPECT_LT(freshError(cured, cured.simulation.session), 0.5e-6);
  const CalibrationResult before = poor.fit(poor.simulation.session),
                          after = cured.fit(cured.simulation.session);
  int better = 0;
  for (int k = 0; k < 8; ++k) better += after.std(k) < 0.3 * before.std(k);
  EXPECT_GE(better, 4);
}

}  // namespace
}  // namespace mm
