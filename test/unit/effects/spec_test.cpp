// What a user may write, and what is said to whoever writes something else.
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/error.h"
#include "effects_support.h"

namespace mm {
namespace {

class Spec : public ::testing::Test {
 protected:
  Spec() : machine(Machine::load("five_axis")), domain(domainOf(machine, true)) {}
  std::string refusal(const std::string& yaml) {
    try {
      createEffect(specOf(yaml), domain);
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "accepted";
  }
  void expect(const std::string& yaml, const std::vector<std::string>& parts) {
    const std::string message = refusal(yaml);
    for (const std::string& part : parts)
      EXPECT_NE(message.find(part), std::string::npos) << message << "\n lacks: " << part;
  }
  Machine machine;
  Domain domain;
};

TEST_F(Spec, refusalsNameTheCulpritAndTheNearestName) {
  expect("{type: baklash, axis: x}", {"'baklash'", "did you mean 'backlash'", "speed_lag"});
  expect("{type: wormhole, axis: x}", {"'wormhole'", "known: mmt_deviation"});
  expect("{type: backlash, axes: x}", {"'axes'", "did you mean 'axis'"});
  expect("{type: backlash}", {"'axis' is missing"});
  expect("{type: backlash, axis: X}", {"'X'", "did you mean 'x'"});
  expect("{type: backlash, axis: [x, y]}", {"'axis'", "not a list"});
  expect("{type: rotary_zero, joint: z}", {"'z' is not a rotary joint", "b, a"});
  expect("{type: thermal_growth, direction: z, sensor: bedd}", {"'bedd'", "did you mean 'bed'", "frame"});
  expect("{type: thermal_growth, direction: q, sensor: bed}", {"'q'", "available: y, x, z, b, a"});
  expect("{type: thermal_growth, direction: z, sensor: bed, lag: maybe}", {"'lag'", "true or false"});
  expect("{type: thermal_bending, axis: z, about: x, sensors: [bed, bed]}", {"two different sensors"});
  expect("{type: positioning_polynomial, axis: x, degree: 6}", {"'degree'", "2 and 5", "6"});
  expect("{type: positioning_polynomial, axis: x, degree: 2.5}", {"'degree'", "whole number"});
  expect("{type: mmt_deviation, axis: x, lead_mm: -1}", {"'lead_mm'", "-1"});
  expect("{type: mmt_deviation, axis: x, lead_mm: nan}", {"'lead_mm'", "finite"});
  expect("{type: mmt_deviation, axis: x, lead_mm: 1, argument: pi}", {"'argument'", "2pi, 1"});
  expect("{type: squareness, axis: x, of: x}", {"different joints"});
  expect("{type: straightness, axis: x, direction: x, degree: 2}", {"must differ"});
  expect("{type: lead_screw_periodic, axis: b, period_mm: 1}", {"period_deg"});
  expect("{type: ball_radius, ball: target}", {"'target'", "a point"});
  expect("{type: gravity_sag, direction: b, with: y, power: 2}", {"vertical"});
  expect("{type: covariate_offset, direction: x, covariate: moisture}", {"humidity, load"});
}

TEST_F(Spec, theSameMeaningHasOneForm) {
  const auto canonical = [&](const std::string& yaml) {
    return createEffect(specOf(yaml), domain)->spec().yaml();
  };
  EXPECT_EQ(canonical("{type: squareness, of: y, axis: x}"), "{type: squareness, axis: x, of: y}");
  EXPECT_EQ(canonical("{type: cross_talk, of: y, axis: x}"), "{type: squareness, axis: x, of: y}");
  EXPECT_EQ(canonical("{type: mmt_deviation, argument: 2pi, exponent: 2, lead_mm: 1.50, axis: x}"),
            "{type: mmt_deviation, axis: x, lead_mm: 1.5}");
  EXPECT_EQ(canonical("{type: thermal_growth, direction: z, sensor: bed, lag: false}"),
            "{type: thermal_growth, direction: z, sensor: bed}");
  EXPECT_EQ(canonical("{type: thermal_bending, axis: z, about: x, sensors: [bed, frame]}"),
            "{type: thermal_bending, axis: z, about: x, sensors: [bed, frame]}");
}

TEST_F(Spec, yamlQuotesWhatWouldReadDifferently) {
  EffectSpec spec("formula");
  spec.set("direction", "x")
      .set("formula", "k1*x, {odd: 'text'} # \"no comment\"")
      .setList("start", {"1", "-2.5"});
  EXPECT_TRUE(specOf(spec.yaml()) == spec) << spec.yaml();
  EXPECT_EQ(EffectSpec("a").set("v", "1.0"), EffectSpec("a").set("v", 1.0));
  EXPECT_FALSE(EffectSpec("a").set("v", "1.0") == EffectSpec("a").setList("v", {"1"}));
  EXPECT_FALSE(EffectSpec("a").setList("v", {"1"}) == EffectSpec("a").setList("v", {"1", "2"}));
  EXPECT_EQ(EffectSpec("a").set("v", 0.1).text("v"), "0.1");
  EXPECT_EQ(EffectSpec("a").set("v", 1.0 / 3.0).text("v"), "0.3333333333333333");
}

TEST_F(Spec, setReplaces) {
  EffectSpec spec("scale");
  spec.set("axis", "x").set("axis", "y");
  EXPECT_EQ(spec.yaml(), "{type: scale, axis: y}");
  EXPECT_EQ(spec.text("none"), "");
  EXPECT_EQ(spec.find("none"), nullptr);
}

TEST_F(Spec, laserEffectsNeedALaser) {
  domain.laser = false;
  expect("{type: laser_scale}", {"no readings of a laser"});
  expect("{type: laser_incidence}", {"no readings of a laser"});
}

TEST_F(Spec, tableNeedsPositions) {
  domain.positions[0].clear();  // more than 64 of them
  expect("{type: position_table, axis: " + domain.joints[0].name + "}", {"2 to 64"});
}

TEST_F(Spec, straightnessTableNeedsKnotsSomewhereAndAnotherDirection) {
  const auto x = static_cast<std::size_t>(domain.findJoint("x"));
  expect("{type: straightness_table, axis: x, direction: x}", {"must differ", "position_table"});
  expect("{type: straightness_table, axis: x, direction: z, knots: 2}", {"knots", "3"});
  domain.positions[x].clear();  // more than 64 of them
  expect("{type: straightness_table, axis: x, direction: z}", {"3 to 64", "knots: 9"});
  EXPECT_EQ(createEffect(specOf("{type: straightness_table, axis: x, direction: z, knots: 9}"), domain)
                ->parameterCount(),
            7);
  domain.upper[x] = domain.lower[x];
  expect("{type: straightness_table, axis: x, direction: z, knots: 9}", {"never moved"});
}

TEST_F(Spec, ownTypesAreAddedOnce) {
  EffectType own;
  own.type = "test_own_type";
  own.create = [](const EffectSpec&, const Domain& d) {
    return createEffect(specOf("{type: scale, axis: x}"), d);
  };
  const auto isRefused = [&] {
    try {
      registerEffectType(own);
      return false;
    } catch (const InputError&) {
      return true;
    }
  };
  const auto addTwice = [&] {
    registerEffectType(own);
    std::exit(createEffect(EffectSpec("test_own_type"), domain) != nullptr && isRefused() ? 0 : 1);
  };
  // in a process of its own: other tests ask for every type there is
  EXPECT_EXIT(addTwice(), testing::ExitedWithCode(0), "");
  own.type = "backlash";
  EXPECT_TRUE(isRefused());
}

}  // namespace
}  // namespace mm
