// What each target carries of effects whose size is known, judged by its interpreter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/format.h"
#include "compensation/compensator.h"
#include "compensation_support.h"
#include "export/export_target.h"
#include "export/representability.h"
#include "long_tests.h"

namespace mm {
namespace {

/// Effects of ten micrometres on x -20 to 20 mm and the like, each with the values of its parameters.
struct Known {
  std::string name;
  EffectSpec spec;
  std::map<std::string, double> values;  // SI
};

const std::vector<Known>& knownEffects() {
  static const std::vector<Known> effects = {
      {"pitch",
       EffectSpec("positioning_polynomial").set("axis", "x").set("degree", "3"),
       {{"amplitude", 5e-6}}},
      {"backlash", EffectSpec("backlash").set("axis", "y"), {{"gap", 4e-6}}},
      {"squareness", EffectSpec("squareness").set("axis", "x").set("of", "y"), {{"slope", 3e-4}}},
      {"squareness told the other way",
       EffectSpec("squareness").set("axis", "z").set("of", "y"),
       {{"slope", -2e-4}}},
      {"straightness",
       EffectSpec("straightness").set("axis", "x").set("direction", "z").set("degree", "2"),
       {{"amplitude", 6e-6}}},
      {"roll",
       EffectSpec("angular_motion").set("axis", "x").set("about", "x").set("degree", "2"),
       {{"angle", 3e-4}}},
      {"growth by heat",
       EffectSpec("thermal_growth").set("direction", "z").set("sensor", "bed"),
       {{"growth", 2e-6}}},
  };
  return effects;
}

Calibration calibrationWith(const std::vector<Known>& effects) {
  std::vector<EffectSpec> specs;
  for (const Known& known : effects) specs.push_back(known.spec);
  Calibration c = test::calibrationOf(Machine::load("three_axis"), specs);
  for (Calibration::Value& v : c.values)
    for (const auto& [name, value] : effects[static_cast<std::size_t>(v.effect)].values)
      if (v.name == name) v.value = value;
  c.rms = 0.3e-6;
  c.heldOutRms = 0.31e-6;
  return c;
}

Representability judge(const std::string& target, const Calibration& calibration) {
  ExportOptions options;
  options.detectionUnit = 1e-7;
  const NeededCorrection needed(calibration, {});
  const ExportTarget& to = exportTarget(target);
  return representability(calibration, to, options, needed, to.write(needed, options));
}

/// The documented answer: e exact, a approximate, n none, in the order of knownEffects().
const std::map<std::string, std::string>& documented() {
  static const std::map<std::string, std::string> answers = {
      {"linuxcnc", "eennnnn"},   {"klipper", "nneeeae"},
      {"marlin", "neeennn"},     {"reprapfirmware", "neeennn"},
      {"grblhal", "nennnnn"},    {"siemens", "eeeeenn"},
      {"heidenhain", "eeeeenn"}, {"fanuc", "aennnnn"},
      {"beckhoff", "eeeeeen"},   {"isg", "eneeeen"},
      {"csv", "eeeeeen"}};
  return answers;
}

constexpr double kNotWorse = 1.002;  // 512 places tell a root mean square no better

// A time constant is known to 4 times its value: with as much less of it there is no model.
TEST(NeededCorrection, IsAsUncertainAsACorrectionThatIsApplied) {
  Calibration c = calibrationWith({{"warm-up",
                                    EffectSpec("warm_up").set("direction", "z"),
                                    {{"amplitude", 5e-6}, {"time_constant", 300.0}}},
                                   {"scale", EffectSpec("scale").set("axis", "x"), {{"scale", 1e-4}}}});
  const Eigen::Vector3d std(1e-6, 1200.0, 2e-5);
  c.covariance = std.cwiseAbs2().asDiagonal();
  c.covariance(0, 1) = c.covariance(1, 0) = 0.5 * std[0] * std[1];
  const NeededCorrection needed(c, {});
  const Compensator compensator(c);
  const std::vector<State> states = needed.states(8, 1);
  const Eigen::MatrixXd by = needed.uncertain(states);
  for (std::size_t n = 0; n < states.size(); ++n) {
    State state = states[n];
    compensator.model().place(state);
    const Eigen::Matrix3d applied = compensator.apply(state).covariance;
    const auto g = by.middleRows<3>(3 * static_cast<Eigen::Index>(n));
    EXPECT_GT(applied.trace(), 0.0);
    EXPECT_LT((g * g.transpose() - applied).norm(), 1e-9 * applied.norm()) << n;
  }
}

class EachTarget : public testing::TestWithParam<std::string> {};

TEST_P(EachTarget, CarriesWhatItsPageSays) {
  const std::string& target = GetParam();
  const std::string& expected = documented().at(target);
  const Calibration calibration = calibrationWith(knownEffects());
  const Representability judged = judge(target, calibration);
  ASSERT_EQ(judged.effects.size(), knownEffects().size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const CarriedEffect& effect = judged.effects[i];
    EXPECT_EQ(effect.carried[0], expected[i])
        << target << ", " << knownEffects()[i].name << ": " << effect.figures.uncorrected * 1e6 << " -> "
        << effect.figures.exported * 1e6 << " um; " << effect.why;
    EXPECT_FALSE(effect.why.empty());
    // No target makes an effect worse.
    EXPECT_LE(effect.figures.exported, kNotWorse * effect.figures.uncorrected)
        << target << ", " << effect.why;
  }
  EXPECT_LT(judged.figures.exported, judged.figures.uncorrected) << target;
  EXPECT_DOUBLE_EQ(judged.heldOut, 0.31e-6);
}

/// A screw of this pitch on x, measured over this travel, mm: 2.2 um of amplitude.
Calibration screwOver(double travel, double pitch) {
  Calibration c = calibrationWith(
      {{"screw",
        EffectSpec("lead_screw_periodic").set("axis", "x").set("period_mm", std::to_string(pitch)),
        {{"S", 2e-6}, {"K", 1e-6}}}});
  c.domain.lower[0] = -0.5e-3 * travel;
  c.domain.upper[0] = 0.5e-3 * travel;
  return c;
}

TEST_P(EachTarget, LeavesNoPeriodicErrorWorse) {
  // Pitches that divide the steps of a table: seen at its points alone they are straight.
  std::vector<std::pair<double, double>> screws = {{30.3, 1.0}};
  if (mm_test::thoroughTests()) screws.insert(screws.end(), {{300.0, 5.0}, {30.0, 1.0}, {610.0, 2.0}});
  for (const auto& [travel, pitch] : screws) {
    const ExportFigures f = judge(GetParam(), screwOver(travel, pitch)).figures;
    const std::string name = format("left_nm_%.0f_%.0f", 10 * travel, 10 * pitch);
    RecordProperty(name, static_cast<int>(std::lround(f.exported * 1e9)));
    EXPECT_LE(f.exported, kNotWorse * f.uncorrected) << travel << " mm, pitch " << pitch << " mm";
    EXPECT_LE(f.unalignedExported, kNotWorse * f.unalignedUncorrected) << travel << ", pitch " << pitch;
    if (std::isfinite(f.withOffsets)) {
      EXPECT_LE(f.withOffsets, kNotWorse * f.uncorrected) << travel << " mm, pitch " << pitch << " mm";
    }
  }
}

TEST_P(EachTarget, SaysThatItCarriesNothingWhereThatIsSo) {
  const Calibration growth =
      calibrationWith({{"growth of x",
                        EffectSpec("thermal_growth").set("direction", "x").set("sensor", "air"),
                        {{"growth", 2e-6}}}});
  const Representability judged = judge(GetParam(), growth);
  EXPECT_TRUE(judged.carriesNothing()) << judged.figures.exported << " of " << judged.figures.uncorrected;
  EXPECT_EQ(judged.effects.at(0).carried, "none");
}

INSTANTIATE_TEST_SUITE_P(Export, EachTarget, testing::ValuesIn(exportTargetNames()),
                         [](const auto& info) { return info.param; });

TEST(Representability, FiguresAreThoseOfOneDisplacement) {
  // A backlash of 4 um is +-2 um along y alone: 2 / sqrt(3) um a coordinate of the three.
  const Representability judged = judge("linuxcnc", calibrationWith({knownEffects()[1]}));
  EXPECT_NEAR(judged.figures.unalignedUncorrected, 2e-6 / std::sqrt(3.0), 1e-9);
  EXPECT_LT(judged.figures.exported, 1e-8);
}

TEST(Representability, WhatActsAtAContactIsToldApart) {
  Calibration c = calibrationWith({{"radius", EffectSpec("probe_radius"), {{"radius", 3e-6}}}});
  const Representability judged = judge("linuxcnc", c);
  ASSERT_EQ(judged.effects.size(), 1u);
  EXPECT_EQ(judged.effects[0].carried, "none");
  EXPECT_NE(judged.effects[0].why.find("contact"), std::string::npos);
  EXPECT_TRUE(judged.carriesNothing());
}

TEST(Representability, PeriodicPitchNeedsAndGetsManyPoints) {
  const Calibration c =
      calibrationWith({{"screw",
                        EffectSpec("lead_screw_periodic").set("axis", "x").set("period_mm", "2"),
                        {{"S", 2e-6}, {"K", 1e-6}}}});
  const Representability judged = judge("linuxcnc", c);
  // Twelve points a wave: chords leave up to 1 - cos(15 deg) of it, half of that as a mean square.
  EXPECT_LT(judged.figures.exported, 0.03 * judged.figures.uncorrected);
  for (const ExportedFile& file : judged.files)
    if (file.path == "joint0.comp") {
      EXPECT_EQ(std::count(file.text.begin(), file.text.end(), '\n'), 241);
    }
}

}  // namespace
}  // namespace mm
