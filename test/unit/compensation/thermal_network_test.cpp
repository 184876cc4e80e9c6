// A learned correction at work: it follows the temperatures, and is not given where one of them is lost.
#include "thermal/thermal_network.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "compensation_support.h"

namespace mm {
namespace {

/// 2 um/K of the bed at the left end of x, 4 um/K at the right one; a gain of 1.
Calibration learned() {
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {});
  const EffectSpec effect = EffectSpec("thermal_network").set("axis", "x").set("network", "ridge");
  Eigen::MatrixXd x(9, 1), y(9, 2);
  for (int k = 0; k < 9; ++k) {
    x(k, 0) = 18.0 + k;
    y.row(k) << 2e-6 * (x(k, 0) - 20.0), 4e-6 * (x(k, 0) - 20.0);
  }
  const auto network = makeNetwork(NetworkKind::kRidge);
  network->fit(x, y);
  LearnedNetwork entry;
  entry.effect = effect.yaml();
  entry.active = true;
  entry.sensors = {"bed"};
  entry.positions = {-0.02, 0.02};
  entry.numbers = network->toNumbers();
  c.networks = {entry};
  c.effects = {effect};
  c.values = {{0, "gain", "1", 1.0, 1.0, 0.01, false}};
  c.covariance = Eigen::MatrixXd::Constant(1, 1, 1e-4);
  return c;
}

TEST(LearnedCorrection, FollowsTheTemperatureAndIsNotGivenWithoutIt) {
  const Compensator compensator(learned());
  State state = compensator.blankState();
  state.time = 10.0;
  state.position = {0.01, 0.0, 0.0};
  state.temperature = {22.0, 21.0};
  compensator.model().place(state);
  Correction correction = compensator.apply(state);
  EXPECT_TRUE(correction.valid) << correction.reason;
  EXPECT_NEAR(correction.displacement.x(), 7e-6, 1e-9);  // 3.5 um/K a quarter from the right end, 2 K
  EXPECT_NEAR(correction.covariance(0, 0), 7e-8 * 7e-8, 1e-18);
  state.temperature[0] = 25.0;  // the bed warms: the correction follows
  EXPECT_NEAR(compensator.apply(state).displacement.x(), 17.5e-6, 2e-9);

  state.temperature[1] = test::kUnknown;  // not an input
  EXPECT_TRUE(compensator.apply(state).valid);
  state.temperature[0] = test::kUnknown;
  correction = compensator.apply(state);
  EXPECT_FALSE(correction.valid);
  EXPECT_TRUE(correction.inputLost);
  EXPECT_NE(correction.reason.find("temperature bed is not known"), std::string::npos) << correction.reason;
  state.temperature[0] = 40.0;
  correction = compensator.apply(state);
  EXPECT_FALSE(correction.valid);
  EXPECT_TRUE(correction.extrapolating);
}

TEST(LearnedCorrection, RefusesANetworkWhoseSensorIsGone) {
  Calibration renamed = learned();
  renamed.domain.sensors[0] = "table";
  try {
    Compensator compensator(renamed);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'bed'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace mm
