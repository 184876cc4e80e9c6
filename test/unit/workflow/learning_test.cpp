#include "workflow/learning.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

TEST(NextToAdd, IsWhatFollowsAnEffectThatVariesWhereNothingElseIsFound) {
  Diagnosis d;
  EXPECT_EQ(nextToAdd(d), nullptr);
  const EffectSpec backlash = EffectSpec("backlash").set("axis", "x"), wave("lead_screw_periodic");
  const EffectSpec formula = EffectSpec("formula").set("direction", "x").set("formula", "k1*x*x_travel");
  d.variations = {{wave, "x", 2e-6, 1e-7, {}, {}}};
  EXPECT_EQ(nextToAdd(d), nullptr) << "nothing follows it";
  d.variations.push_back({backlash, "x", 1e-6, 1e-7, formula, {}});
  ASSERT_NE(nextToAdd(d), nullptr);
  EXPECT_EQ(*nextToAdd(d), formula);
  d.variations.back().instead = {{backlash, 0.3}};
  EXPECT_EQ(*nextToAdd(d), formula);
  d.variations.back().instead[0].probability = 0.9;
  EXPECT_EQ(*nextToAdd(d), backlash) << "the likelier";
  d.missing.emplace_back();
  d.missing[0].effect = backlash;
  EXPECT_EQ(*nextToAdd(d), backlash);
}

TEST(NextToAdd, IsWhatIsCertainBeforeWhatMayBeAnother) {
  Diagnosis d;
  d.missing.resize(2);
  d.missing[0].effect = EffectSpec("backlash").set("axis", "x");
  d.missing[1].effect = EffectSpec("scale").set("axis", "y");
  d.missing[0].confusableWith = {{EffectSpec("speed_lag"), 0.5, 0.4, false, "", ""}};
  EXPECT_EQ(*nextToAdd(d), d.missing[1].effect);
  d.missing[1].confusableWith = d.missing[0].confusableWith;
  EXPECT_EQ(*nextToAdd(d), d.missing[0].effect) << "none is: the likeliest";
  d.missing[0].confusableWith[0].same = true;
  EXPECT_EQ(*nextToAdd(d), d.missing[0].effect) << "what no measurement separates is no other";
}

}  // namespace
}  // namespace mm
