#include <gtest/gtest.h>

#include <algorithm>

#include "effects/catalogue.h"
#include "effects/registry.h"

namespace mm {
namespace {

const CatalogueEntry& entry(const std::string& type) {
  static const std::vector<CatalogueEntry> all = effectCatalogue();
  for (const CatalogueEntry& e : all)
    if (e.type == type) return e;
  throw std::out_of_range(type);
}

const CatalogueKey& key(const std::string& type, const std::string& name) {
  for (const CatalogueKey& k : entry(type).keys)
    if (k.use.key == name) return k;
  throw std::out_of_range(type + " " + name);
}

TEST(EffectCatalogue, EveryTypeOfTheRegistryTellsEverything) {
  for (const EffectType& type : effectRegistry()) {
    SCOPED_TRACE(type.type);
    const CatalogueEntry& e = entry(type.type);
    EXPECT_FALSE(e.example.empty());
    EXPECT_FALSE(e.cause.empty());
    EXPECT_FALSE(e.remedy.empty());
    EXPECT_FALSE(e.shownBy.empty());
    EXPECT_EQ(e.keys.size(), type.keys.size());
    for (const CatalogueKey& k : e.keys) EXPECT_TRUE(k.known) << k.use.key;
    EXPECT_EQ(e.composite, type.composite);
  }
}

TEST(EffectCatalogue, KeysWithTheirBoundsAndDefaults) {
  EXPECT_TRUE(key("straightness", "degree").required);
  EXPECT_EQ(key("straightness", "degree").use.lower, 2.0);
  EXPECT_EQ(key("straightness", "degree").use.upper, 5.0);
  EXPECT_FALSE(key("angular_motion", "degree").required);
  EXPECT_EQ(key("angular_motion", "degree").use.absent, "1");
  EXPECT_EQ(key("thermal_growth", "lag").use.absent, "false");
  EXPECT_EQ(key("thermal_growth", "sensor").use.kind, KeyUse::Kind::kSensor);
  EXPECT_EQ(key("backlash", "axis").use.kind, KeyUse::Kind::kJoint);
  EXPECT_EQ(key("formula", "start").use.kind, KeyUse::Kind::kNumbers);
  EXPECT_FALSE(key("formula", "start").required);
  EXPECT_EQ(key("profile", "variables").use.kind, KeyUse::Kind::kNames);
  EXPECT_FALSE(key("profile", "variables").required);
  EXPECT_EQ(key("mmt_deviation", "argument").use.words, (std::vector<std::string>{"2pi", "1"}));
  EXPECT_TRUE(key("thermal_network", "sensors").use.list);
}

TEST(EffectCatalogue, APeriodIsANumberOrUnknownInTheUnitOfTheAxis) {
  const CatalogueKey& period = key("lead_screw_periodic", "period_mm");
  EXPECT_EQ(period.use.kind, KeyUse::Kind::kNumber);
  EXPECT_EQ(period.use.words, std::vector<std::string>{"unknown"});
  EXPECT_EQ(period.onlyAt, "linear");
  EXPECT_TRUE(period.required);
  EXPECT_EQ(key("lead_screw_periodic", "period_deg").onlyAt, "rotary");
}

TEST(EffectCatalogue, UnitsFollowTheAxis) {
  const CatalogueParameter& gap = entry("backlash").parameters.at(0);
  EXPECT_EQ(gap.unit, "um");
  EXPECT_EQ(gap.rotaryUnit, "arcsec");
  EXPECT_EQ(entry("rotary_zero").parameters.at(0).unit, "arcsec");
}

TEST(EffectCatalogue, WhatItNeedsIsFoundByTrial) {
  const auto needs = [](const std::string& type, const std::string& what) {
    const auto& list = entry(type).needs;
    return std::find(list.begin(), list.end(), what) != list.end();
  };
  EXPECT_TRUE(needs("backlash", "direction of travel"));
  EXPECT_TRUE(needs("thermal_growth", "temperature"));
  EXPECT_TRUE(needs("speed_lag", "velocity"));
  EXPECT_TRUE(needs("covariate_offset", "covariate"));
  EXPECT_FALSE(needs("scale", "temperature"));
}

TEST(KeyRecorder, NotesNothingWhereNobodyListens) {
  KeyRecorder::note({"axis", KeyUse::Kind::kJoint, 0.0, 0.0, {}, {}, false});
  const KeyRecorder recorder;
  EXPECT_TRUE(recorder.uses().empty());
}

}  // namespace
}  // namespace mm
