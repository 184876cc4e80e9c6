// What the simulation hides by its own physics, the estimator finds by its effects: both mean the same by a
// name, a sign and a unit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "estimation/calibrate.h"
#include "model/model_spec.h"
#include "model/observed_domain.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

struct Recovery {
  std::string hide, effect;
  double expected;  // SI, of the first parameter
};

void expectRecovered(const Recovery& r, const Machine& machine, const Plan& plan) {
  SimulationRequest request;
  request.hide = {r.hide};
  request.seed = 3;
  const Simulation simulation = simulate(machine, plan, request);
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.rejectOutliers = false;
  const Model model(machine, observedDomain(simulation.session), {parseEffectSpec(r.effect, "effect")});
  const CalibrationResult found = calibrate(simulation.session, model, options);
  EXPECT_NEAR(found.x(0), r.expected, 4.0 * found.std(0) + 0.03 * std::abs(r.expected)) << r.hide;
  EXPECT_LT(found.figures.rms, 0.45e-6) << r.hide;
  EXPECT_GT(found.before.rms, 1.5 * found.figures.rms) << r.hide;
}

TEST(Recovery, TouchProbeOnThePlate) {
  const double perMetreK = 1e-6;
  const std::vector<Recovery> cases = {
      {"backlash:x=3um", "{type: backlash, axis: x}", 3e-6},
      {"angular_reversal:x/z=40arcsec", "{type: angular_reversal, axis: x, about: z}", 40.0 * kArcsecond},
      {"straightness_reversal:x/z=3um", "{type: straightness_reversal, axis: x, direction: z}", 3e-6},
      {"scale:z=200ppm", "{type: scale, axis: z}", 200e-6},
      {"squareness:x/y=30arcsec", "{type: squareness, axis: x, of: y}", 30.0 * kArcsecond},
      {"speed_lag=1ms", "{type: speed_lag}", 1e-3},
      {"thermal_expansion:x/motor=40ppm/K", "{type: thermal_expansion, axis: x, sensor: motor}",
       40.0 * perMetreK},
      {"thermal_expansion:x/motor=40ppm/K,lag=10min",
       "{type: thermal_expansion, axis: x, sensor: motor, lag: true}", 40.0 * perMetreK},
      {"thermal_growth:z/frame=2um/K", "{type: thermal_growth, direction: z, sensor: frame}", 2e-6},
      {"thermal_growth:z/bed=2um/K,lag=10min", "{type: thermal_growth, direction: z, sensor: bed, lag: true}",
       2e-6},
      {"thermal_bending:x/y/bed/frame=15arcsec/K",
       "{type: thermal_bending, axis: x, about: y, sensors: [bed, frame]}", 15.0 * kArcsecond},
      {"jump:z=4um,at=600s", "{type: jump, direction: z, at_s: 600}", 4e-6},
      {"time_drift:x=8um/h", "{type: time_drift, direction: x}", 8e-6 / 3600.0},
      {"scale_warm_up:x=200ppm,tau=10min", "{type: scale_warm_up, axis: x}", 200e-6},
      {"probe_radius=3um", "{type: probe_radius}", 3e-6},
      {"tip_wear=6um/h", "{type: tip_wear}", 6e-6 / 3600.0},
      {"ball_radius:b3=3um", "{type: ball_radius, ball: b3}", 3e-6},
      {"artifact_expansion=40ppm/K", "{type: artifact_expansion, sensor: bed}", 40.0 * perMetreK},
      {"covariate_offset:x/humidity=0.5um", "{type: covariate_offset, direction: x, covariate: humidity}",
       0.5e-6},
      {"covariate_scale:y/humidity=40ppm", "{type: covariate_scale, axis: y, covariate: humidity}", 40e-6}};
  const Machine machine = Machine::load("three_axis");
  const Plan plan = Plan::load("config/plans/nine_ball_plate.yaml", machine);
  for (const Recovery& r : cases) expectRecovered(r, machine, plan);
}

/// A ball touched in four postures of the head.
TEST(Recovery, TouchProbeOnTheFiveAxisMachine) {
  const Machine machine = Machine::load("five_axis");
  const Plan plan = Plan::parse(
      "artifact:\n"
      "  name: ball\n"
      "  balls: [{name: s0, centre: free, centre_mm: [-65, -25, 0], radius_mm: 6.0}]\n"
      "  probe: {tip_radius_mm: 1}\n"
      "touch:\n"
      "  - {points: 30, b_deg: 0, a_deg: 0}\n"
      "  - {points: 30, b_deg: -90, a_deg: -30}\n"
      "  - {points: 30, b_deg: -45, a_deg: 45}\n"
      "  - {points: 30, b_deg: -60, a_deg: -60}\n",
      "plan", ".", machine);
  expectRecovered({"tip_offset=20um,y=-15um,z=10um", "{type: tip_offset}", 20e-6}, machine, plan);
}

/// A guideway with a kink and a wave, hidden in the readings: what the table says at its knots is its
/// deviation from the line through the ends, whatever else the artifact's pose takes.
TEST(Recovery, StraightnessTableFindsAShapeThatNoPolynomialHas) {
  const Machine machine = Machine::load("three_axis");
  SimulationRequest request;
  request.seed = 3;
  Session session =
      simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), request).session;
  const Domain domain = observedDomain(session);
  constexpr int kKnots = 9;
  const double range = domain.upper[0] - domain.lower[0];
  const std::vector<double> hidden = {2e-6, 5e-6, 3e-6, -1e-6, -4e-6, 2e-6, 3e-6, -2e-6, 1e-6};
  const auto guideway = [&](double x) {
    const double u = std::clamp((x - domain.lower[0]) / range * (kKnots - 1), 0.0, kKnots - 1.0);
    const int i = std::min(static_cast<int>(u), kKnots - 2);
    return hidden[i] + (u - i) * (hidden[i + 1] - hidden[i]);
  };
  for (Observation& o : session.observations) o.position[2] -= guideway(o.position[0]);
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.rejectOutliers = false;
  const Model model(
      machine, observedDomain(session),
      {parseEffectSpec("{type: straightness_table, axis: x, direction: z, knots: 9}", "effect")});
  const CalibrationResult found = calibrate(session, model, options);
  ASSERT_EQ(found.x.size() >= kKnots - 2, true);
  for (int knot = 1; knot + 1 < kKnots; ++knot) {
    const double line = hidden.front() + (hidden.back() - hidden.front()) * knot / (kKnots - 1.0);
    EXPECT_NEAR(found.x(knot - 1), hidden[knot] - line, 4.0 * found.std(knot - 1)) << knot;
    EXPECT_GT(found.std(knot - 1), 0.0) << knot;
    EXPECT_LT(found.std(knot - 1), 0.3e-6) << knot;
    EXPECT_FALSE(found.identifiability.fixed[knot - 1]) << knot;
  }
  EXPECT_LT(found.figures.rms, 0.45e-6);
  EXPECT_GT(found.before.rms, 1.5 * found.figures.rms);
}

TEST(Recovery, LaserOnTheFiveAxisMachine) {
  const std::vector<Recovery> cases = {
      {"laser_scale=0.3%", "{type: laser_scale}", 3e-3},
      {"rotary_zero:a=30arcsec", "{type: rotary_zero, joint: a}", 30.0 * kArcsecond},
      {"rotary_axis_offset:a/y=20um", "{type: rotary_axis_offset, joint: a, direction: y}", 20e-6},
      {"rotary_axis_tilt:b/x=40arcsec", "{type: rotary_axis_tilt, joint: b, about: x}", 40.0 * kArcsecond}};
  const Machine machine = Machine::load("five_axis");
  const Plan plan = Plan::load("config/plans/five_axis_ball.yaml", machine);
  for (const Recovery& r : cases) expectRecovered(r, machine, plan);
}

}  // namespace
}  // namespace mm
