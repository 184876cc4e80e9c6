#include "simulation/simulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "base/error.h"
#include "base/units.h"

namespace mm {
namespace {

Machine threeAxis() { return Machine::load("three_axis"); }

/// Two balls, `points` contacts each, with every quantity that a source may need.
std::string smallPlate(int points, const std::string& noise = "{repeatability_um: 0}",
                       const std::string& more = "") {
  return R"(
artifact:
  name: pair
  pose: known
  probe: {tip_radius_mm: 1.0}
  balls:
    - {name: b0, centre_mm: [-9, -6, -5], radius_mm: 4}
    - {name: b1, centre_mm: [9, 20, 3], radius_mm: 4}
clearance: {z_mm: 14}
touch: {points: )" +
         std::to_string(points) + R"(, cone_deg: 75, tilt_deg: 50, order: interleaved, speeds_mm_s: [1, 3]}
instrument:
  noise: )" +
         noise + R"(
  thermal:
    ambient: {start_degC: 21, ramp_K_per_h: 1, swing_K: 1, swing_period_min: 10}
    heat: [{body: bed, power_W: 5, from_min: 1, to_min: 5, every_min: 9}]
  covariates: [{name: humidity, unit: percent, mean: 45, swing: 5, period_min: 7}]
)" + more;
}

Simulation run(const std::string& yaml, const std::vector<std::string>& hide, std::uint64_t seed = 1,
               const Machine& machine = threeAxis()) {
  SimulationRequest request;
  request.hide = hide;
  request.seed = seed;
  return simulate(machine, Plan::parse(yaml, "plan.yaml", ".", machine), request);
}

std::string laserPlan(const std::string& noise = "{repeatability_um: 0, laser_um: 0}") {
  return R"(
probe: laser
artifact: {name: ball, balls: [{name: s0, centre_mm: [-65, -25, 0], radius_mm: 6}]}
postures: {points: 8, cone_deg: 40, readings_mm: [-4, 4], at: [{b_deg: -90, a_deg: -30}, {b_deg: -60, a_deg: 60}, {b_deg: 0, a_deg: 0}]}
instrument: {noise: )" +
         noise + "}\n";
}

/// RMS over the session of how far the readings alone miss the truth, less the mean: what a source does.
double missed(const Simulation& s) {
  double square = 0.0;
  std::vector<Eigen::Vector3d> errors;
  for (std::size_t i = 0; i < s.states.size(); ++i) {
    const Observation& o = s.session.observations[i];
    Eigen::Vector3d error = s.truePositions[i] - s.truth->nominal(s.states[i]);
    const Eigen::Vector3d nominalCentre = s.session.artifact.features[o.feature].position;
    const Eigen::Vector3d trueCentre = s.truth->featureCentre(o.feature, o.time);
    const Artifact& stated = s.session.artifact;
    const double radius =
        (s.truePositions[i] - trueCentre).norm() - stated.features[o.feature].radius - stated.tipRadius;
    error = error - (trueCentre - nominalCentre);
    errors.push_back(error + radius * Eigen::Vector3d::Ones());
  }
  for (const Eigen::Vector3d& e : errors) square += e.squaredNorm();
  return std::sqrt(square / errors.size());
}

TEST(Simulate, EveryContactIsAtTheSumOfTheRadiiInTruth) {
  const Simulation s =
      run(smallPlate(60), {"backlash:x=4um", "straightness:y/z=3um", "angular_motion:z/x=60arcsec",
                           "thermal_growth:z/frame=2um/K", "lead_screw_periodic:y=2um", "scale:z=300ppm"});
  ASSERT_EQ(s.session.observations.size(), 120u);
  for (std::size_t i = 0; i < s.truePositions.size(); ++i) {
    const Observation& o = s.session.observations[i];
    EXPECT_NEAR((s.truePositions[i] - s.truth->featureCentre(o.feature, o.time)).norm(), 5e-3, 1e-9);
  }
}

TEST(Simulate, TruthOfTheLatchedStateIsTheContact) {
  const Simulation s =
      run(smallPlate(40), {"backlash:x=4um", "backlash:z=3um", "speed_lag=1.5ms", "probe_lobing=2um",
                           "thermal_expansion:x/motor=40ppm/K", "warm_up:z=8um", "gravity_sag:z/y=5um",
                           "positioning_polynomial:y=4um", "squareness:x/y=60arcsec",
                           "thermal_bending:x/y/frame/bed=20arcsec/K"});
  for (std::size_t i = 0; i < s.states.size(); ++i) {
    const Eigen::Vector3d said = s.truth->position(s.states[i]);
    EXPECT_LT((said - s.truePositions[i]).norm(), 1e-8);  // temperatures between their records
    EXPECT_GT((s.truth->nominal(s.states[i]) - s.truePositions[i]).norm(), 0.05e-6);
  }
}

TEST(Simulate, ACleanMachineReadsTheTruth) {
  const Simulation s = run(smallPlate(30), {});
  for (std::size_t i = 0; i < s.states.size(); ++i)
    EXPECT_LT((s.truth->nominal(s.states[i]) - s.truePositions[i]).norm(), 1e-12);
}

TEST(Simulate, AControllerThatCorrectsStandsBesideWhatItReads) {
  SimulationRequest request;
  request.correction = [](const auto&, const auto& travel,
                          const std::map<std::string, double>& temperatures) {
    return std::vector<double>{5e-6, 2e-6 * travel[1], 1e-6 * temperatures.at("bed")};
  };
  const Plan plan = Plan::parse(smallPlate(30), "plan.yaml", ".", threeAxis());
  const Simulation s = simulate(threeAxis(), plan, request);
  for (std::size_t i = 0; i < s.states.size(); ++i) {
    const Eigen::Vector3d beside = s.truePositions[i] - s.truth->nominal(s.states[i]);
    EXPECT_NEAR(beside.x(), 5e-6, 1e-9);
    EXPECT_NEAR(std::abs(beside.y()), 2e-6, 1e-9);
    EXPECT_NEAR(beside.z(), 1e-6 * s.truth->temperature(2, s.states[i].time), 1e-6);  // the sensor is late
  }
}

TEST(Simulate, BacklashIsHalfTheGapAgainstTheTravel) {
  const Simulation s = run(smallPlate(60), {"backlash:x=4um"});
  int up = 0, down = 0;
  for (std::size_t i = 0; i < s.states.size(); ++i) {
    const double v = s.states[i].velocity[0];
    if (std::abs(v) < 1e-4) continue;  // the play is not taken up by a touch that hardly moves x
    (v > 0.0 ? up : down)++;
    EXPECT_NEAR(s.truePositions[i].x() - s.states[i].position[0], v > 0.0 ? -2e-6 : 2e-6, 1e-12);
  }
  EXPECT_GT(up, 20);
  EXPECT_GT(down, 20);
}

TEST(Simulate, SameSeedSameBitsOtherSeedOthers) {
  const std::vector<std::string> hide = {"random", "random", "backlash"};
  const Simulation a = run(smallPlate(20, "{repeatability_um: 0.3, student_dof: 4}"), hide, 5);
  const Simulation b = run(smallPlate(20, "{repeatability_um: 0.3, student_dof: 4}"), hide, 5);
  const Simulation c = run(smallPlate(20, "{repeatability_um: 0.3, student_dof: 4}"), hide, 6);
  ASSERT_EQ(a.session.observations.size(), b.session.observations.size());
  for (std::size_t i = 0; i < a.session.observations.size(); ++i) {
    EXPECT_EQ(a.session.observations[i].position, b.session.observations[i].position);
    EXPECT_EQ(a.session.observations[i].time, b.session.observations[i].time);
  }
  EXPECT_EQ(a.session.temperatures[0].value, b.session.temperatures[0].value);
  EXPECT_EQ(a.hidden[0].text(), b.hidden[0].text());
  EXPECT_NE(a.session.observations[0].position, c.session.observations[0].position);
}

TEST(Simulate, HidingOneMoreSourceKeepsTheNoise) {
  const Simulation clean = run(smallPlate(20, "{repeatability_um: 0.3}"), {}, 2);
  const Simulation hidden = run(smallPlate(20, "{repeatability_um: 0.3}"), {"scale:x=100ppm"}, 2);
  for (std::size_t i = 0; i < clean.states.size(); ++i) {
    // y is untouched by a scale of x, but for where on the ball the tip arrives
    EXPECT_NEAR(clean.states[i].position[1], hidden.states[i].position[1], 3e-6);
    EXPECT_NEAR(clean.states[i].position[0], hidden.states[i].position[0], 5e-6);
  }
}

TEST(Simulate, NoiseHasTheStatedSpread) {
  for (const char* noise : {"{repeatability_um: 0.5}", "{repeatability_um: 0.5, student_dof: 5}"}) {
    const Simulation s = run(smallPlate(400, noise), {}, 3);
    double square = 0.0;
    for (std::size_t i = 0; i < s.states.size(); ++i)
      square += (s.truth->nominal(s.states[i]) - s.truePositions[i]).squaredNorm() / 3.0;
    EXPECT_NEAR(std::sqrt(square / s.states.size()), 0.5e-6, 0.04e-6) << noise;
  }
}

TEST(Simulate, OutliersAndMissingVelocitiesComeInTheirShare) {
  const Simulation s =
      run(smallPlate(
              500, "{repeatability_um: 0.1, outliers: {share: 0.05, size_um: 30}, missing_velocities: 0.2}"),
          {}, 4);
  int outliers = 0, missing = 0;
  for (std::size_t i = 0; i < s.states.size(); ++i) {
    outliers += (s.truth->nominal(s.states[i]) - s.truePositions[i]).norm() > 3e-6;
    missing += std::isnan(s.session.observations[i].velocity[0]);
  }
  EXPECT_NEAR(outliers / 1000.0, 0.046, 0.02);
  EXPECT_NEAR(missing / 1000.0, 0.2, 0.04);
}

TEST(Simulate, EverySourceShowsAndGrowsWithItsSize) {
  // type -> place, size, dimension's unit; one entry a kind of the catalogue
  struct Case {
    std::string place, unit;
    double size;
    bool laser = false;
  };
  const std::map<std::string, Case> cases = {{"backlash", {":x", "um", 3}},
                                             {"lead_screw_periodic", {":x", "um", 2}},
                                             {"positioning_polynomial", {":y", "um", 3}},
                                             {"scale", {":z", "ppm", 200}},
                                             {"mmt_deviation", {":x", "ppm", 300}},
                                             {"squareness", {":x/y", "arcsec", 30}},
                                             {"straightness", {":y/z", "um", 3}},
                                             {"angular_motion", {":y/x", "arcsec", 40}},
                                             {"angular_reversal", {":y/z", "arcsec", 40}},
                                             {"straightness_reversal", {":y/z", "um", 3}},
                                             {"friction_lever", {":x/z", "arcsec", 140}},
                                             {"thermal_expansion", {":x/motor", "ppm/K", 50}},
                                             {"thermal_growth", {":z/bed", "um/K", 2}},
                                             {"thermal_bending", {":x/y/bed/frame", "arcsec/K", 10}},
                                             {"time_drift", {":x", "um/h", 30}},
                                             {"warm_up", {":y", "um", 8}},
                                             {"scale_warm_up", {":x", "ppm", 200}},
                                             {"jump", {":z", "um", 4}},
                                             {"gravity_sag", {":z/y", "um", 6}},
                                             {"covariate_offset", {":x/humidity", "um", 0.6}},
                                             {"covariate_scale", {":y/humidity", "ppm", 40}},
                                             {"speed_lag", {"", "ms", 1}},
                                             {"probe_lobing", {"", "um", 2}},
                                             {"probe_radius", {"", "um", 3}},
                                             {"tip_offset", {"", "um", 20}},
                                             {"tip_wear", {"", "um/h", 10}},
                                             {"ball_radius", {":b1", "um", 3}},
                                             {"artifact_position", {":b0", "um", 5}},
                                             {"artifact_expansion", {"", "ppm/K", 60}},
                                             {"laser_mount", {"", "um", 100, true}},
                                             {"laser_scale", {"", "percent", 0.3, true}},
                                             {"laser_incidence", {"", "um", 8, true}},
                                             {"rotary_zero", {":b", "arcsec", 30, true}},
                                             {"rotary_axis_offset", {":a/y", "um", 20, true}},
                                             {"rotary_axis_tilt", {":b/x", "arcsec", 40, true}},
                                             {"rotary_eccentricity", {":b", "arcsec", 30, true}},
                                             {"rotary_wobble", {":a", "arcsec", 30, true}}};
  for (const SourceKind& kind : sourceKinds()) {
    ASSERT_TRUE(cases.count(kind.type)) << kind.type << " has no case here";
    const Case& c = cases.at(kind.type);
    const auto size = [&](double factor) {
      std::string text = kind.type + c.place + "=" + std::to_string(c.size * factor) + c.unit;
      if (kind.type == "jump") text += ",at=20s";
      if (kind.type == "tip_offset") text += ",y=0um,z=0um";
      if (kind.type == "laser_mount") text += ",beam=0rad";
      if (kind.type == "rotary_eccentricity") text += ",radial=0um";
      if (kind.type == "mmt_deviation")
        text += ",C2=0,C_first=0 1/m,C_second=0 1/m,alpha_first=0rad,alpha_second=0rad";
      const Simulation s =
          c.laser ? run(laserPlan(), {text}, 1, Machine::load("five_axis")) : run(smallPlate(30), {text});
      EXPECT_EQ(s.missed, 0);
      EXPECT_EQ(s.hidden.size(), 1u);
      return missed(s);
    };
    const double one = size(1.0), two = size(2.0);
    EXPECT_GT(one, 0.1e-6) << kind.type;
    EXPECT_NEAR(two / one, 2.0, 0.1) << kind.type;
  }
}

TEST(Simulate, WhatWasHiddenCanBeHiddenAgain) {
  for (const char* text : {"backlash", "lead_screw_periodic", "probe_lobing", "thermal_bending", "warm_up",
                           "artifact_position"}) {
    const HiddenSource first = run(smallPlate(3), {text}, 9).hidden[0];
    const HiddenSource again = run(smallPlate(3), {first.text()}, 10).hidden[0];
    EXPECT_EQ(first.text(), again.text());
  }
}

TEST(Simulate, AReferenceFindsTheDeviationOfALinearJoint) {
  const std::string yaml =
      "reference: {joint: x, positions_mm: [10, 150], runs: 1}\ninstrument: {noise: {reference_um: 0}}\n";
  const Simulation s = run(yaml, {"scale:x=100ppm", "backlash:x=2um"}, 1, Machine::load("five_axis"));
  const int x = s.session.machine.findJoint("x");
  ASSERT_EQ(s.session.observations.size(), 4u);
  for (const Observation& o : s.session.observations)
    EXPECT_NEAR(o.deviation[x], 1e-4 * o.position[x] - 1e-6 * o.travel[x], 1e-9);
}

TEST(Simulate, ALengthIsFromItsPointToTheTrueTip) {
  const std::string plan =
      "artifact: {name: beam, pose: known, points: [{name: p, position_mm: [-100, 0, 0]}]}\n"
      "moves: [{x_mm: 5, reference: length, feature: p}, {x_mm: -5, y_mm: 30, reference: length, feature: p},"
      " {x_mm: 5, y_mm: 0, reference: length, feature: p, setup: s}]\n"
      "instrument: {noise: {reference_um: 0}}\n";
  const Simulation s = run(plan, {"scale:x=1000um/m"});
  ASSERT_EQ(s.session.observations.size(), 3u);
  const Eigen::Vector3d from(-0.1, 0.0, 0.0);
  for (std::size_t i = 0; i < 2; ++i) {
    const Observation& o = s.session.observations[i];
    EXPECT_EQ(o.kind, ObservationKind::kLength);
    EXPECT_NEAR(o.length, (s.truePositions[i] - from).norm(), 1e-12);
  }
  EXPECT_NEAR(s.session.observations[0].length, 0.105 + 5e-6, 1e-9);
  const double zero = std::abs(s.session.observations[2].length - s.session.observations[0].length);
  EXPECT_GT(zero, 1e-8);  // nobody knows it
  EXPECT_LT(zero, 50e-6);
}

TEST(Simulate, ACovariateIsZeroBeforeAndAfterItsTime) {
  const Simulation s =
      run("moves: [{wait_s: 400, reference: position}]\n"
          "instrument: {covariates: [{name: spindle, unit: rpm, mean: 9000, from_min: 1, to_min: 3}]}\n",
          {});
  ASSERT_EQ(s.session.covariates.size(), 1u);
  EXPECT_DOUBLE_EQ(s.session.covariates[0].at(30.0), 0.0);
  EXPECT_DOUBLE_EQ(s.session.covariates[0].at(120.0), 9000.0);
  EXPECT_DOUBLE_EQ(s.session.covariates[0].at(300.0), 0.0);
}

TEST(Simulate, ATimeThatEndsBeforeItBeginsIsRefused) {
  for (const char* instrument : {"covariates: [{name: spindle, unit: rpm, from_min: 3, to_min: 1}]",
                                 "thermal: {heat: [{body: bed, power_W: 5, from_min: 3, to_min: 1}]}"})
    try {
      InstrumentSettings::parse(std::string("instrument: {") + instrument + "}", "plan.yaml");
      ADD_FAILURE() << instrument;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("before from_min 3"), std::string::npos) << e.what();
    }
}

TEST(Simulate, AReferenceFindsTheDeviationOfARotaryJoint) {
  const std::string yaml =
      "reference: {joint: b, positions_deg: [-40, 50], runs: 1}\ninstrument: {noise: {reference_arcsec: "
      "0}}\n";
  const Simulation s =
      run(yaml, {"rotary_zero:b=30arcsec", "backlash:b=10arcsec"}, 1, Machine::load("five_axis"));
  const int b = s.session.machine.findJoint("b");
  ASSERT_EQ(s.session.observations.size(), 4u);
  for (const Observation& o : s.session.observations)
    EXPECT_NEAR(o.deviation[b], (30.0 - 5.0 * o.travel[b]) * kArcsecond, 0.01 * kArcsecond);
}

TEST(Simulate, AShapeThatFollowsLateIsNotTheSensors) {
  const Simulation prompt = run(smallPlate(40), {"thermal_growth:z/bed=3um/K"});
  const Simulation late = run(smallPlate(40), {"thermal_growth:z/bed=3um/K,lag=5min"});
  double difference = 0.0;
  for (std::size_t i = 0; i < prompt.states.size(); ++i)
    difference = std::max(difference, (prompt.truePositions[i] - prompt.truth->nominal(prompt.states[i]) -
                                       late.truePositions[i] + late.truth->nominal(late.states[i]))
                                          .norm());
  EXPECT_GT(difference, 3e-6);
}

TEST(Simulate, ARandomSourceIsOneThatFits) {
  for (int seed = 1; seed <= 40; ++seed) {
    const Simulation s = run(smallPlate(4), {"random"}, seed);
    EXPECT_EQ(s.hidden[0].type.find("laser"), std::string::npos);
    EXPECT_EQ(s.hidden[0].type.find("rotary"), std::string::npos);
    EXPECT_NE(s.hidden[0].type, "mmt_deviation");
  }
}

TEST(Simulate, NoNameIsSilentlyIgnored) {
  for (const char* text :
       {"backlsh", "backlash:q=3um", "backlash:x=3", "backlash:x=3arcsec", "backlash:x,colour=3um",
        "straightness:x/x=2um", "thermal_growth:z/oven=1um/K", "laser_scale", "rotary_zero", "",
        "{type: backlash, axes: x}", "{type: [backlash", "backlash:x/y=3um", "ball_radius:b9=2um"})
    EXPECT_THROW(run(smallPlate(3), {text}), InputError) << text;
  EXPECT_THROW(run(laserPlan(), {"rotary_axis_tilt:b/z"}, 1, Machine::load("five_axis")), InputError);
  EXPECT_EQ(run(smallPlate(3), {"{type: backlash, axis: y, gap: 3um}"}).hidden[0].text(),
            "{type: backlash, axis: y, gap: 3 um}");
  EXPECT_EQ(run(smallPlate(3), {"cross_talk:x/y=10arcsec"}).hidden[0].type, "squareness");
}

TEST(Simulate, LaserPointsLieOnTheBall) {
  const Simulation s =
      run(laserPlan(), {"laser_mount", "rotary_axis_tilt:b/x", "rotary_wobble:a", "laser_incidence"}, 1,
          Machine::load("five_axis"));
  ASSERT_EQ(s.session.observations.size(), 24u);
  for (std::size_t i = 0; i < s.states.size(); ++i) {
    const Observation& o = s.session.observations[i];
    EXPECT_NEAR((s.truePositions[i] - s.truth->featureCentre(0, o.time)).norm(), 6e-3, 1e-12);
    EXPECT_LT((s.truth->position(s.states[i]) - s.truePositions[i]).norm(), 1e-9);
    EXPECT_GT(std::abs(o.laserReading), 1e-6);
  }
}

TEST(Simulate, StepByStepTripsWhereTheTouchDoes) {
  const Machine machine = threeAxis();
  const Plan plan = Plan::parse(smallPlate(5), "plan.yaml", ".", machine);
  SimulationRequest request;
  request.hide = {"backlash:z=3um"};
  SimulatedMachine a = makeInstrument(machine, plan, request).machine,
                   b = makeInstrument(machine, plan, request).machine;
  const std::vector<double> start = {-9e-3, -6e-3, 2e-3}, down = {-9e-3, -6e-3, -1e-3};
  a.home(start);
  b.home(start);
  const std::optional<Trip> touched = a.touch(down, 2e-3, 0);
  ASSERT_TRUE(touched);
  for (int i = 0; i < 2000 && !b.tripped(); ++i) b.step(down, {2e-3, 2e-3, 2e-3}, 1e-3);
  ASSERT_TRUE(b.tripped());
  const Trip stepped = *b.takeTrip();
  EXPECT_NEAR(stepped.position[2], touched->position[2], 1e-9);
  EXPECT_NEAR(stepped.time, touched->time, 1e-4);
  EXPECT_EQ(stepped.feature, 0);
  EXPECT_LT(stepped.approach.z(), -0.99);
}

}  // namespace
}  // namespace mm
