// What a diagnosis asks of an effect, over the whole registry and on three machines.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/units.h"
#include "effects/inputs.h"
#include "effects_support.h"

namespace mm {
namespace {

class Traits : public ::testing::TestWithParam<int> {
 protected:
  Traits() : rig_(rigOf(GetParam())) {
    for (const EffectSpec& spec : everySpec(rig_.domain, GetParam()))
      effects_.push_back(createEffect(spec, rig_.domain, networksOf(rig_.domain)));
  }
  const Domain& domain() const { return rig_.domain; }
  static const EffectType& typeOf(const Effect& effect) {
    return *std::find_if(effectRegistry().begin(), effectRegistry().end(),
                         [&](const EffectType& t) { return t.type == effect.spec().type; });
  }
  MachineRig rig_;
  std::vector<EffectPtr> effects_;
};

TEST_P(Traits, shapeKeysAreKeysOfTheType) {
  for (const EffectPtr& effect : effects_) {
    const std::vector<std::string>& keys = typeOf(*effect).keys;
    for (const auto& key : effect->spec().keys)
      EXPECT_EQ(std::count(keys.begin(), keys.end(), key.first), 1) << effect->spec().yaml();
    for (const std::string& key : effect->nature().shapeKeys)
      EXPECT_EQ(std::count(keys.begin(), keys.end(), key), 1) << effect->spec().yaml() << " " << key;
  }
}

TEST_P(Traits, freedomsAreOtherLinearShapesInCanonicalForm) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    std::set<std::string> seen{effect->spec().yaml()};
    for (const ShapeFreedom& shape : effect->freedom(domain())) {
      const EffectPtr other = createEffect(shape.spec, domain());
      EXPECT_TRUE(other->spec() == shape.spec) << shape.spec.yaml();
      EXPECT_TRUE(other->linear()) << shape.spec.yaml();
      EXPECT_TRUE(seen.insert(shape.spec.yaml()).second) << shape.spec.yaml();
      EXPECT_GT(shape.share, 0.0);
      const bool sameType = shape.spec.type == effect->spec().type;
      EXPECT_LE(shape.share, sameType ? 0.3 : 1.0) << "what another cause does beside it is at most as much";
      // it acts where the main shape does
      const Inputs a = inputsOf(*effect, domain()), b = inputsOf(*other, domain());
      EXPECT_TRUE(
          std::includes(a.positions.begin(), a.positions.end(), b.positions.begin(), b.positions.end()));
      if (!b.temperatures.empty()) {  // else the zero of a sensor
        EXPECT_EQ(a.temperatures, b.temperatures);
      }
      EXPECT_EQ(a.time, b.time);
      EXPECT_EQ(a.approach, b.approach);
    }
  }
}

TEST_P(Traits, jointsAreThoseOfTheLaw) {
  const int joints = static_cast<int>(domain().joints.size());
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    const Inputs inputs = inputsOf(*effect, domain());
    for (const int j : effect->nature().variesAlong) {
      EXPECT_GE(j, 0);
      EXPECT_LT(j, joints);
    }
    for (const int j : effect->nature().mustMove) {
      ASSERT_GE(j, 0);
      ASSERT_LT(j, joints);
      // an axis that is displaced shows only as the joint turns, though the displacement is constant
      if (effect->spec().type.rfind("rotary_axis_", 0) == 0) continue;
      EXPECT_EQ(std::count(inputs.positions.begin(), inputs.positions.end(), j), 1) << j;
    }
    if (effect->nature().positionsNeeded > 0) {
      EXPECT_FALSE(effect->nature().mustMove.empty());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, Traits, ::testing::Values(0, 1, 2));

class OneEffect : public ::testing::Test {
 protected:
  EffectPtr make(const std::string& yaml) { return createEffect(specOf(yaml), domain); }
  std::set<std::string> freedomOf(const std::string& yaml) {
    std::set<std::string> specs;
    for (const ShapeFreedom& shape : make(yaml)->freedom(domain)) specs.insert(shape.spec.yaml());
    return specs;
  }
  Domain domain = rigOf(0).domain;
};

TEST_F(OneEffect, aGuidewayHasTheOtherDegrees) {
  EXPECT_EQ(freedomOf("{type: straightness, axis: x, direction: z, degree: 3}"),
            (std::set<std::string>{"{type: straightness, axis: x, direction: z, degree: 2}",
                                   "{type: straightness, axis: x, direction: z, degree: 4}",
                                   "{type: straightness, axis: x, direction: z, degree: 5}"}));
  EXPECT_EQ(freedomOf("{type: angular_motion, axis: x, about: y, degree: 2}")
                .count("{type: angular_motion, axis: x, about: y}"),
            1U);
}

TEST_F(OneEffect, aScrewHasItsSecondHarmonicWhereThePeriodIsKnown) {
  EXPECT_EQ(freedomOf("{type: lead_screw_periodic, axis: x, period_mm: 2.5}"),
            std::set<std::string>{"{type: lead_screw_periodic, axis: x, period_mm: 1.25}"});
  EXPECT_TRUE(freedomOf("{type: lead_screw_periodic, axis: x, period_mm: unknown}").empty());
}

TEST_F(OneEffect, aPeriodIsClaimedOnlyWhereTwoWereSeen) {
  const EffectPtr searched = make("{type: lead_screw_periodic, axis: x, period_mm: unknown}");
  const double travel = domain.upper[0] - domain.lower[0];
  EXPECT_TRUE(searched->mayBeClaimed({0.49 * travel}));
  EXPECT_FALSE(searched->mayBeClaimed({0.51 * travel}));
  EXPECT_TRUE(make("{type: lead_screw_periodic, axis: x, period_mm: 2}")->mayBeClaimed({}));
  EXPECT_EQ(searched->nature().positionsNeeded, 12);  // nine places are met by many periods
  EXPECT_EQ(make("{type: lead_screw_periodic, axis: x, period_mm: 2}")->nature().positionsNeeded, 5);
}

TEST_F(OneEffect, onlyALawOfAPositionNeedsOne) {
  EXPECT_TRUE(make("{type: backlash, axis: x}")->nature().mustMove.empty());
  EXPECT_TRUE(
      make("{type: thermal_bending, axis: z, about: x, sensors: [bed, frame]}")->nature().mustMove.empty());
  EXPECT_EQ(make("{type: squareness, axis: x, of: y}")->nature().mustMove, std::vector<int>{1});
  EXPECT_EQ(make("{type: backlash, axis: y}")->nature().variesAlong, std::vector<int>{1});
  EXPECT_TRUE(make("{type: speed_lag}")->nature().variesAlong.empty());
}

TEST_F(OneEffect, conventionOfMmt) {
  const EffectPtr x = make("{type: mmt_deviation, axis: x, lead_mm: 1}");
  const EffectPtr y = make("{type: mmt_deviation, axis: y, lead_mm: 1}");
  const EffectPtr z = make("{type: mmt_deviation, axis: z, lead_mm: 1}");
  const auto held = [](const EffectPtr& e) {
    std::set<std::string> names;
    for (int p = 0; p < e->parameterCount(); ++p)
      if (e->zeroByConvention(p)) names.insert(e->parameters()[static_cast<std::size_t>(p)].name);
    return names;
  };
  EXPECT_TRUE(held(x).empty());
  EXPECT_EQ(held(y), std::set<std::string>{"alpha_xy"});
  EXPECT_EQ(held(z), (std::set<std::string>{"alpha_xz", "alpha_yz"}));
}

/// At each of its positions it does what the value of that position says, whatever the others are.
TEST_P(Traits, AValueOfEachPositionIsThatOfNoOther) {
  for (std::size_t j = 0; j < domain().joints.size(); ++j) {
    const EffectPtr effect = createEffect(effectOfEachPosition(domain().joints[j].name), domain());
    const std::vector<double>& positions = domain().positions[j];
    ASSERT_EQ(effect->parameterCount(), static_cast<int>(positions.size()));
    std::mt19937_64 random(1);
    State state = randomState(rig_.machine, domain(), random);
    for (std::size_t at = 0; at < positions.size(); ++at) {
      state.position[j] = positions[at];
      const Collector sink = evaluate(*effect, domain(), state, starts(*effect));
      double own = 0.0, others = 0.0;
      for (const auto& slopes : sink.slopes)
        for (std::size_t value = 0; value < positions.size(); ++value)
          (value == at ? own : others) += std::abs(slopes[value]);
      EXPECT_EQ(others, 0.0) << domain().joints[j].name;
      EXPECT_EQ(own, 1.0);
    }
  }
}

/// Of a wave seen at equal distances: the nearest aliases, and leads that screws have.
TEST(Grid, TheLeadsThatLookTheSameAreNamed) {
  MachineRig rig = rigOf(0);
  rig.domain.lower[0] = 0.0;
  rig.domain.upper[0] = 0.5;
  rig.domain.spacing.assign(rig.domain.joints.size(), 0.0);
  rig.domain.spacing[0] = 0.012;
  const EffectPtr wave =
      createEffect(specOf("{type: lead_screw_periodic, axis: x, period_mm: unknown}"), rig.domain);
  // a screw of 5 mm lead turns 2.4 times from one position to the next: seen as a wave of 30 mm
  EXPECT_EQ(
      wave->looksTheSame({0.030}),
      "At positions 12 mm apart a period of 20 or 8.57 mm looks the same, and so does a screw of 5 mm lead"
      ": measure x at unequal distances.");
  const auto said = [&](double spacing, double period) {
    rig.domain.spacing[0] = spacing;
    return createEffect(specOf("{type: lead_screw_periodic, axis: x, period_mm: unknown}"), rig.domain)
        ->looksTheSame({period});
  };
  EXPECT_EQ(said(0.0, 0.030), "");
  EXPECT_EQ(said(0.0001, 0.008), "");  // no screw has a lead of 0.1 mm
}

}  // namespace
}  // namespace mm
