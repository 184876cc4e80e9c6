// What a controller takes at most, and what the page says where that is not enough.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "compensation_support.h"
#include "export/export_target.h"
#include "export/representability.h"
#include "long_tests.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Calibration with(const EffectSpec& effect, const std::string& parameter, double value) {
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {effect});
  test::value(c, parameter) = value;
  return c;
}

Exported written(const std::string& target, const Calibration& calibration,
                 const ExportOptions& options = {}) {
  return exportTarget(target).write(NeededCorrection(calibration, {}), options);
}

std::string fileOf(const Exported& exported, const std::string& path) {
  for (const ExportedFile& file : exported.files)
    if (file.path == path) return file.text;
  ADD_FAILURE() << path << " is not written";
  return {};
}

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string refused(const std::string& target, const Calibration& calibration, const ExportOptions& options) {
  try {
    written(target, calibration, options);
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

/// Value of the first axis in a line of parameters, "N03624 A1 P0.3370 A2 …".
double parameter(const std::string& text, const std::string& number) {
  std::smatch found;
  if (!std::regex_search(text, found, std::regex(number + " A1 P([-0-9.]+)"))) return std::nan("");
  return std::stod(found[1]);
}

Calibration screw(double travel, double pitch) {
  Calibration c = with(
      EffectSpec("lead_screw_periodic").set("axis", "x").set("period_mm", std::to_string(pitch)), "S", 2e-6);
  c.domain.lower[0] = -0.5e-3 * travel;
  c.domain.upper[0] = 0.5e-3 * travel;
  return c;
}

Representability judged(const std::string& target, const Calibration& calibration) {
  const NeededCorrection needed(calibration, {});
  const ExportTarget& to = exportTarget(target);
  return representability(calibration, to, {}, needed, to.write(needed, {}));
}

TEST(TargetLimits, WhatNoTableFollowsIsTold) {
  const Representability fine = judged("heidenhain", screw(610, 2)),
                         coarse = judged("heidenhain", screw(300, 5));
  ASSERT_EQ(fine.notFollowed.size(), 1u);
  EXPECT_THAT(fine.notFollowed[0],
              AllOf(HasSubstr("of X by the position of X"), HasSubstr("um of it remain")));
  EXPECT_THAT(fine.effects.at(0).why, HasSubstr(fine.notFollowed[0]));
  EXPECT_EQ(fine.effects.at(0).carried, "none");
  EXPECT_THAT(representabilityText(fine), HasSubstr("Not followed: " + fine.notFollowed[0]));
  EXPECT_EQ(representabilityJson(fine).at("not_followed").size(), 1u);
  // Four points a wave: of a screw of 5 mm over 300 mm a tenth is left.
  EXPECT_LT(coarse.figures.exported, 0.15 * coarse.figures.uncorrected);
  EXPECT_TRUE(
      judged("heidenhain", with(EffectSpec("scale").set("axis", "x"), "scale", 1e-4)).notFollowed.empty());
}

TEST(TargetLimits, WhatTheModelDoesNotExplainIsInEveryExpectation) {
  Calibration c = with(EffectSpec("backlash").set("axis", "x"), "gap", 4e-6);
  c.heldOutRms = 0.5e-6;
  c.repeatability = 0.3e-6;
  const Representability r = judged("heidenhain", c);
  EXPECT_DOUBLE_EQ(r.unexplained(), 0.4e-6);
  LeftOfModel left;
  left.rms = 0.3e-6;
  EXPECT_DOUBLE_EQ(r.expected(left).rms, 0.5e-6);
  const auto json = representabilityJson(r);
  EXPECT_NEAR(json.at("expected_rms_um").at("full"), 0.4, 1e-9);
  EXPECT_GE(json.at("expected_rms_um").at("exported"), json.at("expected_rms_um").at("full"));
  EXPECT_EQ(json.at("rms_um").at("full"), 0.0);
  EXPECT_THAT(representabilityText(r), HasSubstr("what the model does not explain of its session (0.4 um"));
  c.repeatability = 0.6e-6;  // a session luckier than its contacts
  EXPECT_DOUBLE_EQ(judged("heidenhain", c).unexplained(), 0.0);
  c.heldOutRms = c.rms = std::nan("");
  EXPECT_TRUE(representabilityJson(judged("heidenhain", c)).at("expected_rms_um").at("full").is_null());
}

TEST(TargetLimits, TheParametersOwnUncertaintyIsExpectedAlongTheirAxis) {
  Calibration c = with(EffectSpec("backlash").set("axis", "y"), "gap", 4e-6);
  c.values[0].std = 0.6e-6;
  c.covariance(0, 0) = 0.36e-12;
  c.heldOutRms = c.rms = c.repeatability = 0.2e-6;  // the model explains its session to the last
  const Representability r = judged("linuxcnc", c);
  const auto y = std::find_if(r.along.begin(), r.along.end(),
                              [](const LeftAlong& along) { return along.direction == "y"; });
  ASSERT_NE(y, r.along.end());
  // half the gap, not its share of three coordinates; the mean of the places is taken out
  EXPECT_NEAR(y->uncorrected.rms, 2e-6, 0.02e-6);
  EXPECT_NEAR(r.expected(y->full).rms, 0.3e-6, 1e-9);
  EXPECT_NEAR(r.measured(y->full).rms, std::hypot(0.3e-6, 0.2e-6), 1e-9);
  // (gap / 2)^2 with a gap of 4 um and 0.6 um: 2 um to within 0.3 um
  EXPECT_NEAR(r.expected(y->uncorrected).std, 0.3e-6, 0.01e-6);
  EXPECT_THAT(representabilityText(r), HasSubstr("along y"));
  EXPECT_THAT(representabilityJson(r).at("along").size(), 3u);
}

TEST(TargetLimits, AnAxisThatNeverMovedHasNoFigures) {
  Calibration c = with(EffectSpec("backlash").set("axis", "y"), "gap", 4e-6);
  for (const int still : {0, 2}) c.domain.lower[still] = c.domain.upper[still] = 0.0;
  Representability r = judged("linuxcnc", c);
  EXPECT_THAT(r.notMoved, testing::ElementsAre("x", "z"));
  EXPECT_THAT(representabilityText(r), HasSubstr("Not told along x, z: no axis moved there in the session."));
  // one coordinate: half the gap, not its share of three; the mean of the places is taken out
  EXPECT_NEAR(r.figures.uncorrected, 2e-6, 0.02e-6);
  ASSERT_EQ(r.along.size(), 1u);
  EXPECT_EQ(r.along[0].direction, "y");
  // x stood still too; z errs without having moved
  c = with(EffectSpec("thermal_growth").set("direction", "z").set("sensor", "bed"), "growth", 2e-6);
  for (const int still : {0, 2}) c.domain.lower[still] = c.domain.upper[still] = 0.0;
  r = judged("linuxcnc", c);
  EXPECT_THAT(r.notMoved, testing::ElementsAre("x"));
  EXPECT_EQ(r.along.back().direction, "z");
}

TEST(TargetLimits, FanucIsNeverGivenBytesOfOtherPurposes) {
  const Exported exported = written("fanuc", with(EffectSpec("scale").set("axis", "x"), "scale", 1e-4));
  for (const char* number : {"N01013", "N01020", "N01820", "N03605"}) {
    EXPECT_THAT(fileOf(exported, "parameters.txt"), Not(HasSubstr(number)));
    EXPECT_THAT(fileOf(exported, "compare.txt"), HasSubstr(number));
  }
}

TEST(TargetLimits, FanucKeepsTheIntervalOfTheRapidRate) {
  const Calibration c = with(EffectSpec("scale").set("axis", "x"), "scale", 1e-4);
  ExportOptions options;
  // 40 mm in 119 sections; the joint's limit, 20 mm/s, would allow 0.16 mm.
  EXPECT_NEAR(parameter(fileOf(written("fanuc", c), "parameters.txt"), "N03624"), 0.337, 1e-9);
  options.rapidRate = 0.25;  // 15000 mm/min / 7500
  const Exported coarse = written("fanuc", c, options);
  EXPECT_NEAR(parameter(fileOf(coarse, "parameters.txt"), "N03624"), 2.0, 1e-9);
  EXPECT_THAT(all(coarse.notes), HasSubstr("20 sections of 2 mm"));
  EXPECT_THAT(all(coarse.unverified), HasSubstr("7500"));
}

TEST(TargetLimits, FanucUsesTheWholeMagnificationAndRefusesMore) {
  ExportOptions options;
  options.detectionUnit = 0.05e-6;
  // 698.6 units a section of 0.337 mm: 8 x 99 at times, or 7 x 100.
  const Calibration steep = with(EffectSpec("scale").set("axis", "x"), "scale", 0.11564);
  const std::string text = fileOf(written("fanuc", steep, options), "parameters.txt");
  EXPECT_EQ(parameter(text, "N03623"), 100.0);
  const std::regex increment("N1[0-9]{4} P(-?[0-9]+)");
  for (std::sregex_iterator at(text.begin(), text.end(), increment), end; at != end; ++at)
    EXPECT_LE(std::abs(std::stoi((*at)[1])), 7) << at->str();
  const Calibration steeper = with(EffectSpec("scale").set("axis", "x"), "scale", 0.14);
  EXPECT_THAT(refused("fanuc", steeper, options),
              AllOf(HasSubstr("axis X"), HasSubstr("7 x 100"), HasSubstr("--detection-unit-um")));
  options.detectionUnit = 0.07e-6;
  EXPECT_THAT(refused("fanuc", steep, options),
              AllOf(HasSubstr("--detection-unit-um 0.07"), HasSubstr("1820")));
}

TEST(TargetLimits, EveryDetectionUnitIsReadBackAsItWasMeant) {
  const Calibration c = with(EffectSpec("scale").set("axis", "x"), "scale", 1e-3);  // 20 um at the ends
  const NeededCorrection needed(c, {});
  const ExportTarget& fanuc = exportTarget("fanuc");
  std::vector<double> units = {10.0, 0.5, 0.01};  // um; every day the ends and one between
  if (mm_test::thoroughTests()) units.insert(units.end(), {2.0, 1.0, 0.2, 0.1, 0.05});
  for (const double unit : units) {
    ExportOptions options;
    options.detectionUnit = unit * 1e-6;
    const Representability r = representability(c, fanuc, options, needed, fanuc.write(needed, options));
    // Steps of 0.34 um and of the unit, each of which scatters by its size / sqrt(12), on one coordinate of
    // three.
    EXPECT_LT(r.figures.exported, 1.1e-6 * std::hypot(unit, 0.337) / 6.0) << unit << " um";
  }
}

TEST(TargetLimits, SiemensTablesFitThe828D) {
  const Exported exported = written("siemens", screw(40, 2));
  const std::string text = fileOf(exported, "cec_2_tables.mpf");
  EXPECT_THAT(text, AllOf(HasSubstr("$AN_CEC[0,192]="), Not(HasSubstr("$AN_CEC[0,193]="))));
  EXPECT_THAT(text, HasSubstr("; table 0: X by X, 193 points"));
  EXPECT_THAT(all(exported.notes), HasSubstr("0: X by X, 193 points"));
}

TEST(TargetLimits, IsgIsToldErrorsByThePositionThatTheyDependOn) {
  const Exported exported =
      written("isg", with(EffectSpec("squareness").set("axis", "x").set("of", "y"), "slope", 3e-4));
  const std::string text = fileOf(exported, "volcomp.csv");
  EXPECT_THAT(text, HasSubstr("\nY EXY\n"));
  std::istringstream last(text.substr(text.rfind('\n', text.size() - 2)));
  double y = 0.0, error = 0.0;
  last >> y >> error;  // mm; corrected = nominal + slope * y
  EXPECT_GT(y, 19.9);
  EXPECT_NEAR(error, 3e-4 * y, 2e-6);
  EXPECT_EQ(exported.axes, std::set<std::string>{"x"});
  const auto records = std::count(text.begin(), text.end(), '\n') - 3;  // two remarks, a header
  EXPECT_THAT(fileOf(exported, "startup.lis"),
              HasSubstr(format("max_records %d\n", static_cast<int>(records))));
}

TEST(TargetLimits, IsgHasAGridWherePositionsActTogether) {
  const Exported exported =
      written("isg", with(EffectSpec("angular_motion").set("axis", "x").set("about", "x").set("degree", "2"),
                          "angle", 3e-4));
  const std::string text = fileOf(exported, "volcomp.csv");
  ASSERT_THAT(text, HasSubstr("\nX Y Z E"));
  const std::string grid = text.substr(text.find("\nX Y Z E") + 1);
  EXPECT_EQ(std::count(grid.begin(), grid.end(), '\n'), 1 + 16 * 16 * 16);
  EXPECT_EQ(exported.axes, (std::set<std::string>{"y", "z"}));
}

TEST(TargetLimits, IsgNeedsThreeLinearAxes) {
  const Calibration c = with(EffectSpec("scale").set("axis", "x"), "scale", 1e-4);
  try {
    exportTarget("isg").write(NeededCorrection(c, {{"x", "u"}}), {});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(),
                AllOf(HasSubstr("U, Y, Z"), HasSubstr("exactly three, X, Y and Z"), HasSubstr("--axis")));
  }
}

TEST(TargetLimits, KlipperSplitsMovesAsFinelyAsItCan) {
  const Exported exported = written(
      "klipper", with(EffectSpec("straightness").set("axis", "x").set("direction", "z").set("degree", "2"),
                      "amplitude", 6e-6));
  EXPECT_THAT(fileOf(exported, "printer.cfg"),
              AllOf(HasSubstr("\nsplit_delta_z: 0.01\n"), HasSubstr("\nmove_check_distance: 3\n")));
  EXPECT_THAT(all(exported.notes), HasSubstr("end points of moves"));
}

TEST(TargetLimits, MarlinsSkewIsRefusedByItsAxes) {
  const Calibration c = with(EffectSpec("squareness").set("axis", "x").set("of", "y"), "slope", 1.5);
  EXPECT_THAT(refused("marlin", c, {}),
              AllOf(HasSubstr("--to marlin"), HasSubstr("M852 I"), HasSubstr("x and y"), HasSubstr("-1 to 1"),
                    Not(HasSubstr("compensation.gcode"))));
}

}  // namespace
}  // namespace mm
