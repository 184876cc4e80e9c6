#include <gtest/gtest.h>

#include "base/error.h"
#include "effects_support.h"

namespace mm {
namespace {

const EffectSpec kSpec = EffectSpec("thermal_network").set("axis", "x");

struct Rig {
  Machine machine = Machine::load("three_axis");
  Domain domain = domainOf(machine, false);
  std::vector<LearnedNetwork> networks = networksOf(domain);
  State state = blank();
  State blank() const {
    std::mt19937_64 random(2);
    return randomState(machine, domain, random);
  }
  double at(const EffectPtr& effect, double q) {
    state.position[0] = q;
    return evaluate(*effect, domain, state, {1.0}).values[ErrorLayout(3).axis(0)];
  }
};

std::string refusal(const EffectSpec& spec, const Rig& rig) {
  try {
    createEffect(spec, rig.domain, rig.networks);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ThermalNetworkEffect, IsTheNetworkAtItsPositionsAndLinearBetween) {
  Rig rig;
  const EffectPtr effect = createEffect(kSpec, rig.domain, rig.networks);
  const LearnedNetwork& learned = rig.networks[0];
  const double t[2] = {rig.state.temperature[2], rig.state.temperature[0]};  // spindle, bed
  double y[3];
  networkFromNumbers(learned.numbers)->evaluate(t, y);
  const std::vector<double>& q = learned.positions;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(rig.at(effect, q[i]), y[i], 1e-18);
  EXPECT_NEAR(rig.at(effect, 0.5 * (q[1] + q[2])), 0.5 * (y[1] + y[2]), 1e-18);
  EXPECT_NEAR(rig.at(effect, q[2] + 1e-3), y[2], 1e-18);
  EXPECT_NEAR(rig.at(effect, q[0] - 1e-3), y[0], 1e-18);
}

TEST(ThermalNetworkEffect, GivesNothingBeforeItLearnedAndWhereItIsNotActive) {
  Rig rig;
  for (const bool learned : {false, true}) {
    if (learned)
      rig.networks[0].active = false;
    else
      rig.networks[0].effect = "{type: thermal_network, axis: y}";
    const EffectPtr effect = createEffect(kSpec, rig.domain, rig.networks);
    EXPECT_EQ(effect->parameterCount(), 0);
    for (const double value : evaluate(*effect, rig.domain, rig.state, {1.0}).values) EXPECT_EQ(value, 0.0);
    rig.networks = networksOf(rig.domain);
  }
}

TEST(ThermalNetworkEffect, NeedsOnlyItsOwnSensors) {
  Rig rig;
  const EffectPtr effect = createEffect(kSpec, rig.domain, rig.networks);
  rig.state.temperature[1] = kNan;  // frame: not an input
  EXPECT_TRUE(std::isfinite(rig.at(effect, 0.0)));
  rig.state.temperature[2] = kNan;
  EXPECT_TRUE(std::isnan(rig.at(effect, 0.0)));
}

TEST(ThermalNetworkEffect, RefusesWhatItCannotUse) {
  Rig rig;
  rig.domain.sensors[2] = "spindle_front";  // renamed
  const std::string renamed = refusal(kSpec, rig);
  EXPECT_NE(renamed.find("'spindle'"), std::string::npos) << renamed;
  EXPECT_NE(renamed.find("spindle_front"), std::string::npos) << renamed;
  EXPECT_EQ(renamed.find('\n'), std::string::npos);

  Rig damaged;
  damaged.networks[0].numbers.pop_back();
  EXPECT_NE(refusal(kSpec, damaged).find("calibrate again"), std::string::npos);
  Rig cut;
  cut.networks[0].positions.pop_back();
  EXPECT_NE(refusal(kSpec, cut).find("does not fit"), std::string::npos);

  Rig bare;
  bare.domain.sensors.clear();
  EXPECT_NE(refusal(kSpec, bare).find("no temperatures"), std::string::npos);
  EffectSpec unknown = kSpec;
  unknown.set("network", "perceptron");
  EXPECT_NE(refusal(unknown, rig).find("perceptron"), std::string::npos);
  EffectSpec sensor = kSpec;
  sensor.setList("sensors", {"bed", "bedd"});
  EXPECT_NE(refusal(sensor, rig).find("did you mean 'bed'"), std::string::npos) << refusal(sensor, rig);
}

}  // namespace
}  // namespace mm
