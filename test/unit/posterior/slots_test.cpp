#include "posterior/slots.h"

#include <gtest/gtest.h>

using namespace mm;

namespace {

/// A sample in which each visit has the same weight.
PosteriorSample sampleOf(const std::vector<std::vector<double>>& inclusion) {
  PosteriorSample s;
  s.inclusion.assign(inclusion[0].size(), 0.0);
  for (const auto& of : inclusion) {
    Visit v;
    v.inclusion = of;
    for (std::size_t c = 0; c < of.size(); ++c)
      if (of[c] > 0.5) v.acting.push_back(static_cast<int>(c));
    s.visits.push_back(v);
    s.weights.push_back(1.0 / static_cast<double>(inclusion.size()));
    for (std::size_t c = 0; c < of.size(); ++c)
      s.inclusion[c] += of[c] / static_cast<double>(inclusion.size());
  }
  return s;
}

}  // namespace

TEST(Slots, OneThatIsSureIsNamedAlone) {
  const std::vector<Slot> slots = slotsOf(sampleOf({{0.999, 0.001}, {0.998, 0.002}}));
  ASSERT_EQ(slots.size(), 1u);
  EXPECT_TRUE(slots[0].named);
  EXPECT_EQ(slots[0].causes, std::vector<int>{0});
}

TEST(Slots, TwoThatExcludeEachOtherAreRivalsOfOnePlace) {
  const std::vector<Slot> slots = slotsOf(sampleOf({{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {1.0, 0.0, 0.3}}));
  ASSERT_FALSE(slots.empty());
  EXPECT_TRUE(slots[0].named);
  EXPECT_EQ(slots[0].causes, (std::vector<int>{0, 1}));
  EXPECT_NEAR(slots[0].shares[0], 2.0 / 3.0, 1e-12);
}

// Either is enough: where both act, each is improbable given the other.
TEST(Slots, TwoOfWhichOneIsEnoughAreNamedWhereBothAct) {
  PosteriorSample sample = sampleOf({{1.0, 0.1}, {0.1, 1.0}, {0.1, 1.0}, {0.2, 0.2}});
  sample.visits[3].acting = {0, 1};
  const std::vector<Slot> slots = slotsOf(sample);
  ASSERT_FALSE(slots.empty());
  EXPECT_TRUE(slots[0].named) << slots[0].probability;
  EXPECT_EQ(slots[0].causes.size(), 2u);
}

TEST(Slots, TwoThatActTogetherHaveAPlaceEach) {
  const std::vector<Slot> slots = slotsOf(sampleOf({{1.0, 0.995}, {0.999, 1.0}}));
  ASSERT_EQ(slots.size(), 2u);
  EXPECT_TRUE(slots[0].named && slots[1].named);
}

TEST(Slots, WhatIsSureBesideOneThatIsNamedIsNamedWithItsOwnProbability) {
  const std::vector<Slot> slots = slotsOf(
      sampleOf({{1.0, 1.0, 0.0, 0.0}, {1.0, 1.0, 0.0, 0.0}, {1.0, 1.0, 0.0, 0.9}, {0.0, 0.0, 1.0, 0.0}}));
  ASSERT_EQ(slots.size(), 3u);
  EXPECT_TRUE(slots[0].named);
  EXPECT_EQ(slots[0].causes, (std::vector<int>{0, 2}));
  EXPECT_TRUE(slots[1].named);
  EXPECT_EQ(slots[1].causes, std::vector<int>{1});
  EXPECT_NEAR(slots[1].shares[0], 0.75, 1e-12);
  EXPECT_FALSE(slots[2].named);
}

// A scale beside a play or beside a carriage that tips, or a lost motion alone that does what both do: one of
// the last three acts, which is seen where the scale, that predicts nothing, does not hold the lost motion.
TEST(Slots, TheRivalOfOneThatIsDoubtedIsAnothers) {
  const PosteriorSample sample = sampleOf({{1.0, 1.0, 0.0, 0.0},
                                           {1.0, 1.0, 0.0, 0.0},
                                           {1.0, 0.0, 1.0, 0.0},
                                           {0.0, 0.0, 0.0, 1.0},
                                           {0.0, 0.0, 0.0, 1.0}});
  const std::vector<Slot> before = slotsOf(sample), after = slotsOf(sample, {0});
  ASSERT_GE(before.size(), 2u);
  EXPECT_EQ(before[0].causes, (std::vector<int>{0, 3}));
  EXPECT_FALSE(before[1].named);
  ASSERT_FALSE(after.empty());
  EXPECT_TRUE(after[0].named);
  EXPECT_EQ(after[0].causes, (std::vector<int>{1, 3, 2}));
}

TEST(Slots, WhatActsBesideTheLeaderAsOftenAsWithoutItIsNoRival) {
  const std::vector<Slot> slots =
      slotsOf(sampleOf({{1.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}, {1.0, 0.0}, {0.0, 1.0}, {0.0, 1.0}}));
  ASSERT_EQ(slots.size(), 2u);
  for (const Slot& slot : slots) {
    EXPECT_EQ(slot.causes.size(), 1u);
    EXPECT_FALSE(slot.named);  // either acts, and neither instead of the other
  }
}

TEST(Slots, WhatIsLessSureIsNotNamed) {
  const std::vector<Slot> slots = slotsOf(sampleOf({{0.97, 0.0}, {0.97, 0.0}}));
  ASSERT_EQ(slots.size(), 1u);
  EXPECT_FALSE(slots[0].named);
  EXPECT_NEAR(slots[0].probability, 0.97, 1e-12);
}
