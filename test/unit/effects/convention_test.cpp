// Signs and forms that are conventions of the catalogue or of the papers, each worked out by hand.
#include <gtest/gtest.h>

#include <functional>

#include "base/error.h"
#include "base/units.h"
#include "effects_support.h"

namespace mm {
namespace {

class Convention : public ::testing::Test {
 protected:
  Convention()
      : machine(Machine::load("three_axis")), domain(domainOf(machine, false)), layout(machine.layout()) {
    std::mt19937_64 random(5);
    state = randomState(machine, domain, random);
  }
  std::vector<double> values(const std::string& yaml, const std::vector<double>& p) {
    return evaluate(*createEffect(specOf(yaml), domain), domain, state, p).values;
  }
  void place(double x, double y, double z) {  // three_axis: the tip is where the readings say
    state.position = {x, y, z};
    state.tip = {x, y, z};
  }

  Machine machine;
  Domain domain;
  ErrorLayout layout;
  State state;
};

TEST_F(Convention, backlashLagsTheTravelByHalfTheGap) {
  state.travel[0] = 1.0;
  EXPECT_DOUBLE_EQ(values("{type: backlash, axis: x}", {8e-6})[layout.axis(0)], -4e-6);
  state.travel[0] = -1.0;
  EXPECT_DOUBLE_EQ(values("{type: backlash, axis: x}", {8e-6})[layout.axis(0)], 4e-6);
}

TEST_F(Convention, carriageThatTipsLagsTheTravelByHalfTheAngle) {
  state.tip = {0.0, 0.0, 0.1};
  state.travel[0] = 1.0;
  const auto error = values("{type: angular_reversal, axis: x, about: y}", {8e-6});
  EXPECT_DOUBLE_EQ(error[layout.volume(0)], -4e-7) << "-4 urad about y, 0.1 m above it";
  EXPECT_DOUBLE_EQ(error[layout.orientation(1)], -4e-6);
}

TEST_F(Convention, carriageThatShiftsAsideLagsByHalfTheStep) {
  state.travel[0] = 1.0;
  EXPECT_DOUBLE_EQ(values("{type: straightness_reversal, axis: x, direction: z}", {8e-6})[layout.axis(2)],
                   -4e-6);
  state.travel[0] = -1.0;
  EXPECT_DOUBLE_EQ(values("{type: straightness_reversal, axis: x, direction: z}", {8e-6})[layout.axis(2)],
                   4e-6);
}

TEST_F(Convention, lateTriggerReadsTooFar) {
  state.velocity = {0.01, -0.02, 0.0};
  const auto error = values("{type: speed_lag}", {1e-3});
  EXPECT_DOUBLE_EQ(error[layout.axis(0)], -1e-5);
  EXPECT_DOUBLE_EQ(error[layout.axis(1)], 2e-5);
  EXPECT_DOUBLE_EQ(error[layout.axis(2)], 0.0);
}

TEST_F(Convention, speedOfAJointThatNeverMovedIsZeroWhereNotLogged) {
  domain.lower[2] = domain.upper[2] = 0.0;
  state.velocity = {0.01, 0.0, kNan};
  EXPECT_DOUBLE_EQ(values("{type: speed_lag}", {1e-3})[layout.axis(2)], 0.0);
  state.velocity = {kNan, 0.0, kNan};
  EXPECT_TRUE(std::isnan(values("{type: speed_lag}", {1e-3})[layout.axis(0)]));
}

TEST_F(Convention, tipIsDisplacedInTheAxesOfTheProbe) {
  const auto error = values("{type: tip_offset}", {1e-6, -2e-6, 3e-6});
  for (int k = 0; k < 3; ++k) EXPECT_DOUBLE_EQ(error[layout.probe(k)], (k == 1 ? -2e-6 : (k + 1) * 1e-6));
}

TEST_F(Convention, largerTipStandsFurtherFromTheBall) {
  const auto error = values("{type: probe_radius}", {2e-6});
  for (int slot = 0; slot < layout.size(); ++slot)
    EXPECT_DOUBLE_EQ(error[slot], slot == layout.distance() ? 2e-6 : 0.0);
}

TEST_F(Convention, ballRadiusCountsOnItsBallOnly) {
  state.feature = 0;
  EXPECT_DOUBLE_EQ(values("{type: ball_radius, ball: b0}", {2e-6})[layout.distance()], 2e-6);
  EXPECT_DOUBLE_EQ(values("{type: ball_radius, ball: b1}", {2e-6})[layout.distance()], 0.0);
}

TEST_F(Convention, artifactExpansionGrowsPositionAndRadius) {
  state.feature = 0;
  state.featurePosition = {0.1, -0.2, 0.3};
  state.featureRadius = 0.004;
  state.temperature[1] = 25.0;
  const auto error = values("{type: artifact_expansion, sensor: frame}", {1e-5});
  EXPECT_NEAR(error[layout.feature(0)], 5e-6, 1e-18);
  EXPECT_NEAR(error[layout.feature(1)], -10e-6, 1e-18);
  EXPECT_NEAR(error[layout.distance()], 2e-7, 1e-18);
}

TEST_F(Convention, crossTalkAndScale) {
  place(0.01, 0.02, -0.01);
  EXPECT_DOUBLE_EQ(values("{type: scale, axis: y}", {1e-4})[layout.axis(1)], 2e-6);
  EXPECT_DOUBLE_EQ(values("{type: squareness, axis: x, of: y}", {1e-4})[layout.axis(0)], 2e-6);
}

TEST_F(Convention, rotationIsRightHandedAboutTheOrigin) {
  place(0.01, 0.02, 0.005);
  state.temperature = {25.0, 23.0, 30.0};
  const auto error = values("{type: thermal_bending, axis: z, about: z, sensors: [bed, frame]}", {1e-5});
  EXPECT_NEAR(error[layout.volume(0)], -2e-5 * 0.02, 1e-18);  // k x lever = (-y, x, 0)
  EXPECT_NEAR(error[layout.volume(1)], 2e-5 * 0.01, 1e-18);
  EXPECT_NEAR(error[layout.orientation(2)], 2e-5, 1e-18);
}

TEST_F(Convention, legendreDegreeAloneOverTheObservedRange) {
  domain.lower[0] = -0.02;
  domain.upper[0] = 0.04;
  state.position[0] = 0.04;  // u = 1
  for (const char* degree : {"2", "3", "4", "5"})
    EXPECT_NEAR(values(std::string("{type: positioning_polynomial, axis: x, degree: ") + degree + "}",
                       {1e-6})[layout.axis(0)],
                1e-6, 1e-20);
  state.position[0] = 0.025;  // u = 0.5
  EXPECT_NEAR(values("{type: positioning_polynomial, axis: x, degree: 2}", {1.0})[layout.axis(0)], -0.125,
              1e-14);
  EXPECT_NEAR(values("{type: straightness, axis: x, direction: z, degree: 3}", {1.0})[layout.axis(2)],
              -0.4375, 1e-14);
}

TEST_F(Convention, jumpStaysFromItsTimeOn) {
  const auto at = [&](double time) {
    state.time = time;
    return values("{type: jump, direction: y, at_s: 100}", {3e-6})[layout.axis(1)];
  };
  EXPECT_EQ(at(99.9), 0.0);
  EXPECT_EQ(at(100.0), 3e-6);
  EXPECT_EQ(at(1e4), 3e-6);
}

TEST_F(Convention, sagGrowsFromTheObservedMinimum) {
  domain.lower[1] = -0.01;
  state.position[1] = 0.02;
  EXPECT_NEAR(values("{type: gravity_sag, direction: z, with: y, power: 2}", {1.0})[layout.axis(2)], 9e-4,
              1e-17);
  EXPECT_NEAR(values("{type: gravity_sag, direction: z, with: y, power: 3}", {1.0})[layout.axis(2)], 2.7e-5,
              1e-17);
}

TEST_F(Convention, tableIsLinearBetweenItsPositionsAndConstantBeyond) {
  domain.positions[0] = {-0.01, 0.0, 0.02};
  const std::vector<double> p{1e-6, 3e-6, 7e-6};
  const auto at = [&](double x) {
    state.position[0] = x;
    return values("{type: position_table, axis: x}", p)[layout.axis(0)];
  };
  EXPECT_NEAR(at(-0.01), 1e-6, 1e-18);
  EXPECT_NEAR(at(-0.005), 2e-6, 1e-18);
  EXPECT_NEAR(at(0.005), 4e-6, 1e-18);
  EXPECT_NEAR(at(0.05), 7e-6, 1e-18);
  EXPECT_NEAR(at(-0.05), 1e-6, 1e-18);
}

TEST_F(Convention, straightnessTableCountsFromTheLineThroughItsEnds) {
  domain.positions[0] = {-0.01, 0.0, 0.01, 0.02};
  const auto at = [&](const char* knots, double x) {
    state.position[0] = x;
    return values(std::string("{type: straightness_table, axis: x, direction: z") + knots + "}",
                  {4e-6, -2e-6})[layout.axis(2)];
  };
  EXPECT_EQ(at("", -0.01), 0.0);
  EXPECT_NEAR(at("", -0.0025), 3e-6, 1e-18);
  EXPECT_NEAR(at("", 0.005), 1e-6, 1e-18);
  EXPECT_NEAR(at("", 0.015), -1e-6, 1e-18);
  EXPECT_EQ(at("", 0.05), 0.0);
  domain.lower[0] = -0.03;
  domain.upper[0] = 0.03;  // knots: 4 are at -30, -10, 10 and 30 mm
  EXPECT_NEAR(at(", knots: 4", -0.02), 2e-6, 1e-18);
  EXPECT_NEAR(at(", knots: 4", 0.0), 1e-6, 1e-18);
}

TEST_F(Convention, lobesActAlongTheApproach) {
  state.orientation.setIdentity();
  const double phi = 0.3, eps = 0.4;
  state.approach = {std::cos(eps) * std::cos(phi), std::cos(eps) * std::sin(phi), std::sin(eps)};
  const auto error = values("{type: probe_lobing, order: 3}", {2e-6, 1e-6});
  const double size = std::cos(eps) * (2e-6 * std::sin(0.9) + 1e-6 * std::cos(0.9));
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(error[layout.volume(k)], size * state.approach[k], 1e-18);
}

TEST_F(Convention, warmUpAndGrowth) {
  state.time = 600.0;
  EXPECT_NEAR(values("{type: warm_up, direction: y}", {5e-6, 600.0})[layout.axis(1)],
              5e-6 * (1.0 - std::exp(-1.0)), 1e-18);
  state.position[0] = 0.2;
  EXPECT_NEAR(values("{type: scale_warm_up, axis: x}", {50e-6, -2e-6, 600.0})[layout.axis(0)],
              (50e-6 * 0.2 - 2e-6) * (1.0 - std::exp(-1.0)), 1e-18);
  state.temperature[0] = 26.0;
  EXPECT_NEAR(values("{type: thermal_growth, direction: z, sensor: bed}", {1e-6})[layout.axis(2)], 6e-6,
              1e-18);
  // the ramp's lagged value: 21 + r (t - tau (1 - exp(-t/tau))), r = 1 mK/s
  const double lagged = 21.0 + 1e-3 * (600.0 - 300.0 * (1.0 - std::exp(-2.0)));
  EXPECT_NEAR(
      values("{type: thermal_growth, direction: z, sensor: bed, lag: true}", {1e-6, 300.0})[layout.axis(2)],
      1e-6 * (lagged - 20.0), 1e-18);
  state.position[0] = 0.2;
  EXPECT_NEAR(
      values("{type: thermal_expansion, axis: x, sensor: bed, lag: true}", {10e-6, 300.0})[layout.axis(0)],
      10e-6 * 0.2 * (lagged - 20.0), 1e-18);
  EXPECT_NEAR(values("{type: thermal_transient, direction: z, sensor: bed}", {1e-6, 300.0})[layout.axis(2)],
              1e-6 * (26.0 - lagged), 1e-18);
}

TEST_F(Convention, cyclesAndWearInTime) {
  state.time = 600.0;
  const auto cycle = values("{type: time_cycle, direction: y}", {5e-6, 2e-6, 800.0});  // three quarters of it
  EXPECT_NEAR(cycle[layout.axis(1)], -5e-6, 1e-18);
  EXPECT_NEAR(values("{type: tip_wear}", {1e-9})[layout.distance()], -600e-9, 1e-18);
  EXPECT_NEAR(values("{type: tip_wear, slows: true}", {4e-6, 600.0})[layout.distance()],
              -4e-6 * (1.0 - std::exp(-1.0)), 1e-18);
}

TEST_F(Convention, covariateCountsFromZeroOrFromTheMiddleOfADistantRange) {
  state.covariate = {50.0, 30.0};  // humidity 38 … 55: middle 46.5; load 0 … 100
  EXPECT_NEAR(values("{type: covariate_offset, direction: x, covariate: humidity}", {1e-6})[layout.axis(0)],
              3.5e-6, 1e-18);
  EXPECT_NEAR(values("{type: covariate_offset, direction: x, covariate: load}", {1e-6})[layout.axis(0)],
              30e-6, 1e-18);
}

/// MMT (13), first line, written out independently with C2 and phi.
TEST_F(Convention, mmtDeviationIsEquation13) {
  place(0.013, 0.021, -0.008);
  const double X = 0.013, Y = 0.021, Z = -0.008, Pr = 1e-3, C1 = 2e-4, C2 = 3e-4, phi = 0.7, Cyx = 0.05,
               Czx = -0.04;
  const double ayx = 0.01, azx = -0.02;
  const std::vector<double> p{C1, C2 * std::cos(phi), C2 * std::sin(phi), Cyx, Czx, ayx, azx};
  const double angles = Y * std::cos(kPi / 2 + ayx) + Z * std::cos(kPi / 2 + azx);
  const double expected =
      C1 * X + Cyx * Y * Y + Czx * Z * Z + C2 * X * std::sin(2 * kPi * X / Pr + phi) + angles;
  const auto error = values("{type: mmt_deviation, axis: x, lead_mm: 1}", p);
  EXPECT_NEAR(error[layout.axis(0)], expected, 1e-18);
  EXPECT_EQ(error[layout.axis(1)], 0.0);
  const double printed = C1 * X + Cyx * Y + Czx * Z + C2 * std::sin(X / Pr + phi) + angles;
  EXPECT_NEAR(
      values("{type: mmt_deviation, axis: x, lead_mm: 1, exponent: 1, amplitude_exponent: 0, argument: 1}",
             p)[0],
      printed, 1e-17);
}

TEST_F(Convention, mmtParametersBearTheNamesOfTheChromosome) {
  const auto names = [&](const char* yaml) {
    std::vector<std::string> out;
    const EffectPtr effect = createEffect(specOf(yaml), domain);
    for (const Parameter& p : effect->parameters()) out.push_back(p.name);
    return out;
  };
  EXPECT_EQ(names("{type: mmt_deviation, axis: x, lead_mm: 1}"),
            (std::vector<std::string>{"Cxx1", "Sxx", "Kxx", "Cyx", "Czx", "alpha_yx", "alpha_zx"}));
  EXPECT_EQ(names("{type: mmt_deviation, axis: y, lead_mm: 1}"),
            (std::vector<std::string>{"Cyy1", "Syy", "Kyy", "Cxy", "Czy", "alpha_xy", "alpha_zy"}));
}

TEST_F(Convention, periodStartsLieCloseEnoughForADescent) {
  const EffectPtr effect =
      createEffect(specOf("{type: lead_screw_periodic, axis: x, period_mm: unknown}"), domain);
  const auto starts = effect->nature().searchStarts;
  const double range = domain.upper[0] - domain.lower[0];  // 40 mm
  for (std::size_t i = 1; i < starts.size(); ++i)
    EXPECT_LE(std::abs(1.0 / starts[i][0] - 1.0 / starts[i - 1][0]), 1.0 / (3.0 * range) * (1.0 + 1e-9));
  EXPECT_NEAR(starts.front()[0], 2.0 * range, 1e-9);
  EXPECT_LT(starts.back()[0], 1.02 * range / 60.0);
  EXPECT_GE(starts.back()[0], 0.05e-3);
}

TEST(RotaryConvention, motionIsInTheFixedSideAcrossTheAxis) {
  const Machine machine(panTiltUrdf(), "pan_tilt");
  const Domain domain = domainOf(machine, false);
  const ErrorLayout at = machine.layout();
  std::mt19937_64 random(1);
  State state = randomState(machine, domain, random);
  state.position = {0.5, 0.25};
  const EffectPtr wobble = createEffect(specOf("{type: rotary_wobble, joint: tilt, harmonic: 2}"), domain);
  EXPECT_EQ(wobble->parameters()[0].name, "z_cos");  // tilt turns about y
  const auto tilted = evaluate(*wobble, domain, state, {1e-5, 2e-5, 3e-5, 4e-5}).values;
  EXPECT_NEAR(tilted[at.jointRotation(1, 2)], 1e-5 * std::cos(0.5) + 2e-5 * std::sin(0.5), 1e-18);
  EXPECT_NEAR(tilted[at.jointRotation(1, 0)], 3e-5 * std::cos(0.5) + 4e-5 * std::sin(0.5), 1e-18);
  EXPECT_EQ(tilted[at.jointRotation(1, 1)], 0.0);
  const EffectPtr scale = createEffect(
      specOf("{type: rotary_eccentricity, joint: pan, harmonic: 1, reading_only: true}"), domain);
  const auto led = evaluate(*scale, domain, state, {1e-5, 2e-5}).values;
  EXPECT_NEAR(led[at.axis(0)], 1e-5 * std::cos(0.5) + 2e-5 * std::sin(0.5), 1e-18);
  for (int slot = 0; slot < at.size(); ++slot) EXPECT_TRUE(slot == at.axis(0) || led[slot] == 0.0) << slot;
  const auto turned =
      evaluate(*createEffect(specOf("{type: rotary_eccentricity, joint: pan, harmonic: 1}"), domain), domain,
               state, {1e-6, 0, 0, 0, 0, 1e-5})
          .values;
  EXPECT_NEAR(turned[at.jointTranslation(0, 0)], 1e-6 * std::cos(0.5), 1e-18);
  EXPECT_NEAR(turned[at.axis(0)], 1e-5 * std::sin(0.5), 1e-18);
}

/// LASER Table 2 with the solution that fits it: 6.34 um over its 12 components.
TEST(LaserConvention, mountReproducesTable2) {
  const Machine machine = Machine::load("five_axis");
  const Domain domain = domainOf(machine, true);
  const EffectPtr mount = createEffect(specOf("{type: laser_mount}"), domain);
  const std::vector<double> p{-0.15446 * kDegree, -0.0544e-3, 120.0563e-3, 10.3326e-3,
                              19.5227e-3,         0.0267,     0.0405,      0.9988};
  ASSERT_EQ(mount->parameterCount(), 8);
  struct Row {
    double t, a, b;
    Eigen::Vector3d s1;
  };
  const Row table[] = {{0.0, 0, 0, {0.001743, 0.002189, -4.725415}},
                       {0.2, 90, 0, {0.088509, -30.046754, 4.432010}},
                       {0.4, -90, 0, {-0.012881, 9.609871, 25.132104}},
                       {0.6, 90, 90, {-139.878714, -130.717940, 4.430974}}};
  const Eigen::Vector3d s0(120.0261e-3, 10.5916e-3, 14.7853e-3);
  double sum = 0.0, nominal = 0.0;
  for (const Row& row : table) {
    State state;
    state.position.assign(5, 0.0);
    for (int k = 0; k < 3; ++k)
      state.position[machine.findJoint(std::string(1, "xyz"[k]))] = row.s1[k] * kMillimetre;
    state.position[machine.findJoint("a")] = row.a * kDegree;
    state.position[machine.findJoint("b")] = row.b * kDegree;
    const auto errors = evaluate(*mount, domain, state, p).values;
    sum += (machine.measure(state.position.data(), row.t * kMillimetre, errors.data()).position - s0)
               .squaredNorm();
    nominal += (machine.nominal(state.position.data(), row.t * kMillimetre).position - s0).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(sum / 12.0) * 1e6, 6.34, 0.02);
  EXPECT_GT(std::sqrt(nominal / 12.0) * 1e6, 100.0);
}

TEST(LaserConvention, mountStartsAtTheChainWhateverTheTurnOfTheProbe) {
  const char* urdf =
      R"(<robot name="arm"><link name="workpiece"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="probe_tip"/>
  <joint name="z" type="prismatic"><parent link="workpiece"/><child link="l1"/><axis xyz="0 0 1"/><limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
  <joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="a" type="revolute"><parent link="l2"/><child link="l3"/><origin xyz="0.01 0.03 0"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="m" type="fixed"><parent link="l3"/><child link="probe_tip"/><origin xyz="0.1 0.02 0.03" rpy="1.2 0.3 -0.4"/></joint></robot>)";
  const Machine machine(urdf, "arm");
  const Domain domain = domainOf(machine, true);
  const EffectPtr mount = createEffect(specOf("{type: laser_mount}"), domain);
  std::mt19937_64 random(2);
  const State state = randomState(machine, domain, random);
  EXPECT_NEAR(mount->parameters()[1].start, 0.03, 1e-15);  // y32 is absolute
  std::vector<double> p = starts(*mount);
  const auto pose = [&] {
    const auto errors = evaluate(*mount, domain, state, p).values;
    return machine.measure(state.position.data(), 0.002, errors.data()).position;
  };
  EXPECT_NEAR((pose() - machine.nominal(state.position.data(), 0.002).position).norm(), 0.0, 1e-15);
  // (7) by hand, with another mount
  p = {0.01, 0.031, 0.11, 0.015, 0.02, 0.2, -0.1, 2.0};
  const double z = state.position[0], b = state.position[1] + 0.01, a = state.position[2];
  const Eigen::Vector3d beam = Eigen::Vector3d(0.2, -0.1, 2.0).normalized();
  Eigen::Matrix3d r21, r32;
  r21 << std::cos(b), -std::sin(b), 0, std::sin(b), std::cos(b), 0, 0, 0, 1;
  r32 << 1, 0, 0, 0, std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a);
  const Eigen::Vector3d q0 =
      Eigen::Vector3d(0, 0, z) +
      r21 * (r32 * (0.002 * beam + Eigen::Vector3d(0.11, 0.015, 0.02)) + Eigen::Vector3d(0.01, 0.031, 0));
  EXPECT_NEAR((pose() - q0).norm(), 0.0, 1e-15);
}

TEST(LaserConvention, mountLeavesOutWhatTheMachineDoesNotHave) {
  const Machine three = Machine::load("three_axis");
  const auto names = [&](bool laser) {
    std::string out;
    const EffectPtr mount = createEffect(specOf("{type: laser_mount}"), domainOf(three, laser));
    for (const Parameter& p : mount->parameters()) out += p.name + " ";
    return out;
  };
  EXPECT_EQ(names(true), "x43 y43 z43 l m n ");
  EXPECT_EQ(names(false), "x43 y43 z43 ");
}

TEST(LaserConvention, scaleAndIncidenceActOnTheReading) {
  const Machine machine = Machine::load("five_axis");
  const Domain domain = domainOf(machine, true);
  std::mt19937_64 random(4);
  State state = randomState(machine, domain, random);
  state.laserReading = 4e-4;
  const int slot = machine.layout().reading();
  EXPECT_NEAR(
      evaluate(*createEffect(specOf("{type: laser_scale}"), domain), domain, state, {0.01}).values[slot],
      4e-6, 1e-20);
  state.orientation.setIdentity();
  state.surfaceNormal = {std::sin(0.5), 0.0, -std::cos(0.5)};  // the beam is +z
  EXPECT_NEAR(
      evaluate(*createEffect(specOf("{type: laser_incidence}"), domain), domain, state, {1e-5}).values[slot],
      1e-5 * (1.0 - std::cos(0.5)), 1e-20);
}

}  // namespace
}  // namespace mm
