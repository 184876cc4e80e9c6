// What people and programs read of a diagnosis, part by part.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "estimation/calibrate.h"
#include "made_up_diagnosis.h"
#include "model/observed_domain.h"
#include "report/json.h"
#include "report/text.h"
#include "report_sessions.h"

namespace mm {
namespace {

using namespace test_support;
using Json = nlohmann::json;

std::string textOf(const Diagnosis& d) { return diagnoseText(told(d), "plate.bag", "plate.yaml"); }
Json jsonOf(const Diagnosis& d) { return Json::parse(diagnoseJson(told(d))); }
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Diagnosis confusable() {
  Diagnosis d = verdict(Verdict::kConfusable);
  d.missing = {play()};
  d.missing[0].odds = 0.6;
  Confusable same = rival(EffectSpec("rotary_zero").set("joint", "b"), 0.2),
             hidden = rival(backlash("y"), 0.1);
  same.same = true;
  hidden.notRecorded = "direction of travel of y";
  d.missing[0].confusableWith = {rival(EffectSpec("speed_lag"), 0.3, "touch x at two speeds"), same, hidden};
  d.nextMeasurement.resize(1);
  d.nextMeasurement[0].values = {{"x_mm", 1.5}};
  return d;
}

TEST(DiagnoseText, SaysWhichConstantIsNotDetermined) {
  Diagnosis d = verdict(Verdict::kMissingEffect);
  d.missing = {play()};
  d.missing[0].parameters.push_back({"growth", "um/h", 1e-7, 0.0});
  EXPECT_TRUE(has(textOf(d), "    growth            not determined by this session\n")) << textOf(d);
}

TEST(DiagnoseText, TellsEachMissingEffect) {
  Diagnosis d = verdict(Verdict::kMissingEffect);
  d.missing = {play()};
  const std::string text = textOf(d);
  EXPECT_EQ(text.find("Missing: backlash of x, 2.06 ± 0.06 um (k = 2)"), 0u);
  EXPECT_TRUE(has(text, "\n  backlash of x\n    gap               2.06 ± 0.06 um\n")) << text;
  EXPECT_TRUE(has(text, "    odds              about 1000 to 1\n")) << text;
  EXPECT_TRUE(has(text, "    held-out RMS      0.93 um -> 0.32 um\n")) << text;
  EXPECT_TRUE(has(text, "    cause             play in the drive\n")) << text;
  EXPECT_TRUE(has(text, "    remedy            preload")) << text;
  EXPECT_TRUE(has(text,
                  "\nType next:\n  mm add plate.bag --calibration plate.yaml '{type: backlash, axis: x}' -o "
                  "plate2.yaml\n"))
      << text;
}

TEST(DiagnoseText, RivalsWithTheirOddsAndWhatWouldTell) {
  const std::string text = textOf(confusable());
  EXPECT_TRUE(
      has(text, "    or instead        trigger delay, 1 to 2; to separate them: touch x at two speeds\n"))
      << text;
  EXPECT_TRUE(has(text, "zero of b; does the same wherever measurements of this kind reach")) << text;
  EXPECT_TRUE(has(text, "backlash of y; cannot be excluded: the direction of travel of y was not")) << text;
  // the moves first, then what may be added without them
  const std::size_t moves = text.find("mm diagnose plate.bag --calibration plate.yaml --moves moves.yaml"),
                    add = text.find("mm add plate.bag");
  ASSERT_NE(moves, std::string::npos) << text;
  ASSERT_NE(add, std::string::npos) << text;
  EXPECT_LT(moves, add);
  EXPECT_TRUE(has(text, "\nOr, without measuring, add the most probable:\n  mm add")) << text;
  Diagnosis two = confusable();
  two.missing.push_back(play());
  two.missing[1].effect = backlash("z");
  const std::string both = textOf(two);
  EXPECT_TRUE(has(both,
                  "\n"
                  "Add the certain effect now:\n"
                  "  mm add plate.bag --calibration plate.yaml '{type: backlash, axis: z}'"))
      << both;
}

TEST(DiagnoseText, EveryVerdictEndsWithALineToType) {
  const auto ends = [](const std::string& text, const std::string& line) {
    return text.size() > line.size() && text.compare(text.size() - line.size(), line.size(), line) == 0;
  };
  const std::string again = "\n  mm diagnose plate.bag --calibration plate.yaml";
  Diagnosis d = verdict(Verdict::kExplained);
  EXPECT_TRUE(ends(textOf(d), "\nType next:\n  mm promote plate.yaml\n")) << textOf(d);
  d.variations.resize(1);  // and nothing that follows it
  d.variations[0].effect = backlash("x");
  d.variations[0].along = "x";
  const std::string report = "\n  mm report plate.bag --calibration plate.yaml -o report.html\n";
  EXPECT_TRUE(ends(textOf(d), report)) << textOf(d);
  d.variations[0].instead = {{backlash("y"), 0.6}};
  EXPECT_TRUE(ends(textOf(d), "'{type: backlash, axis: y}' -o plate2.yaml\n")) << textOf(d);
  d = verdict(Verdict::kScatter);
  EXPECT_TRUE(ends(textOf(d), report)) << textOf(d);
  d.outliers = {7, 18e-6, "of b5"};
  EXPECT_TRUE(ends(textOf(d), again + " --keep-outliers\n")) << textOf(d);
  d.outliers = {};
  d.base.repeatabilityFrom = "estimated";
  EXPECT_TRUE(ends(textOf(d), again + " --repeatability-um STD\n")) << textOf(d);
  d = verdict(Verdict::kQuestion);
  EXPECT_TRUE(ends(textOf(d), again + "\n")) << textOf(d);
  d.missing = {play()};  // none is added before the answer
  EXPECT_FALSE(has(textOf(d), "mm add")) << textOf(d);
  EXPECT_TRUE(ends(textOf(verdict(Verdict::kInsufficientData)), "\n  mm check plate.bag\n"));
}

TEST(DiagnoseText, CausesThatMayActStandWithTheirOddsAndNotAsMissing) {
  Diagnosis d = verdict(Verdict::kExplained);
  d.possible = {{backlash("x"), 0.75, "The same positions in both directions of x."}};
  const std::string text = textOf(d);
  EXPECT_FALSE(has(text, "issing")) << text;
  EXPECT_TRUE(
      has(text, "\nNot established, and not excluded\n  backlash of x\n    odds              3 to 1\n"))
      << text;
  EXPECT_EQ(jsonOf(d)["possible"].size(), 1u);
  EXPECT_TRUE(jsonOf(d)["missing"].empty());
  // of several of which one acts none is listed as missing
  const std::string several = textOf(confusable());
  EXPECT_TRUE(has(several, "\nOne of several acts, and these data do not tell which\n  backlash of x\n"))
      << several;
  EXPECT_FALSE(has(several, "Missing, in the order found")) << several;
}

TEST(DiagnoseText, SaysWhichInputIsUnknownAtRowsThatAreNotJudged) {
  Diagnosis d = verdict(Verdict::kExplained);
  const Session session = test::interferometerSession(1e-6, 0.2e-6);
  d.base = calibrate(session, Model(session.machine, observedDomain(session), std::vector<EffectSpec>()), {});
  d.notJudged = {{"x", 1, true}};
  EXPECT_TRUE(has(textOf(d), "1 observation is not evaluated: how far x had come since its last reversal"))
      << textOf(d);
  d.notJudged = {{"x", 8, false}};
  EXPECT_TRUE(has(textOf(d), "8 observations are not evaluated: the direction from which x arrived"));
}

TEST(DiagnoseText, NoLineIsLongerThanAHundredCharacters) {
  Diagnosis d = confusable();
  d.missing[0].remedy = std::string(30, 'a');
  for (int i = 0; i < 20; ++i) d.missing[0].remedy += " and again something to mend";
  d.cannotShow = {
      {backlash("z"), "z always travelled down at contact, whatever the rest of the session did",
       "approach from both sides of z, at the same place, several times, with nothing else changed"}};
  const std::string text = textOf(d);
  const std::size_t verdictEnds = text.find('\n');  // the sentence is one line: scripts read it
  for (std::size_t at = verdictEnds + 1; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const std::string line = text.substr(at, end - at);
    const auto characters =
        std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xc0) != 0x80; });
    EXPECT_LE(characters, 100) << line;
    at = end + 1;
  }
}

TEST(DiagnoseText, AProfileIsACurveWithItsBand) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  d.profiles = {bump()};
  const std::string text = textOf(d);
  EXPECT_TRUE(has(text, "  along z, over x: odds more than 1000 to 1, held-out RMS 0.93 um -> 0.33 um\n"))
      << text;
  EXPECT_TRUE(has(text, "    x, mm           error, um (k = 2)\n    -16             0.91 ± 0.20")) << text;
  EXPECT_TRUE(has(text, "\n    16              0.9 ± 0.5")) << text;
  std::size_t points = 0;
  for (std::size_t at = text.find("●"); at != std::string::npos; at = text.find("●", at + 1)) ++points;
  EXPECT_EQ(points, 9u) << text;
  EXPECT_TRUE(has(text,
                  "mm add plate.bag --calibration plate.yaml '{type: profile, direction: z, variable: x}' -o "
                  "plate2.yaml"))
      << text;
  EXPECT_FALSE(has(text, "formula")) << text;
  d.formulas = {{EffectSpec("formula").set("direction", "z").set("formula", "k1*x^2"), {}, 0.93e-6, 0.33e-6}};
  EXPECT_TRUE(has(textOf(d), "The same as a formula\n  {type: formula, direction: z, formula: k1*x^2}"))
      << textOf(d);
}

TEST(DiagnoseText, AProfileOfTwoVariablesIsATable) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  ProfileResult p = bump();
  p.effect = EffectSpec("profile").set("direction", "z").setList("variables", {"x", "t"});
  p.variables = {"x", "t"};
  p.units = {"mm", "s"};
  p.curve.clear();
  for (const double x : {-10.0, 0.0, 10.0})
    for (const double t : {0.0, 600.0}) p.curve.push_back({x, t, 1e-4 * x * t, 0.05});
  d.profiles = {p};
  const std::string text = textOf(d);
  EXPECT_TRUE(has(text, "  along z, over x and time: odds")) << text;
  EXPECT_TRUE(has(text, "down x, mm; across time, s\n                0               600\n    -10         "))
      << text;
  EXPECT_TRUE(has(text, "\n    10          0.00 ± 0.10     0.60 ± 0.10\n")) << text;
  p.curve.pop_back();  // no grid any more
  d.profiles = {p};
  EXPECT_TRUE(has(textOf(d), "x, mm           time, s         error, um (k = 2)\n")) << textOf(d);
}

TEST(DiagnoseText, CurvesThatCannotBeDrawnAreLeftOut) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  d.profiles = {bump()};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<std::vector<double>>& curve :
       std::vector<std::vector<std::vector<double>>>{{}, {{1.0, nan, 0.1}}, {{1.0, 0.0, 0.0}}, {{1.0}}}) {
    d.profiles[0].curve = curve;
    EXPECT_TRUE(has(textOf(d), "along z, over x")) << textOf(d);
  }
}

TEST(DiagnoseText, DriftArtifactAndInputs) {
  Diagnosis d = verdict(Verdict::kExplained);
  d.drift = {wander(), wander()};
  d.drift[1].direction = "y";
  d.drift[1].perhaps = {{growth("y"), 0.3, 0.6}};
  d.drift[1].inWords = "measure the same place at other temperatures";
  d.artifactScatter = {{"centres", 0.5e-6, {}, "measure the plate again", 0.05e-6}};
  d.missingInputs = {{"direction of travel of x", "from the approach of the contact", {}},
                     {"speed of y", "", {EffectSpec("speed_lag"), backlash("y")}}};
  const std::string text = textOf(d);
  EXPECT_TRUE(has(text, "Drift\n    x                 0.4 um RMS, time constant 20 min\n")) << text;
  EXPECT_TRUE(has(text, "    to do             measure the same reference again every 5 min")) << text;
  EXPECT_TRUE(has(
      text,
      "    perhaps           thermal growth along y with bed, odds 1 to 2; it would explain 60 % of it\n"))
      << text;
  EXPECT_TRUE(has(text, "    to do             measure the same place at other temperatures\n")) << text;
  EXPECT_TRUE(has(text, "    centres           0.50 ± 0.10 um RMS (k = 2): measure the plate again\n"))
      << text;
  EXPECT_TRUE(has(text, "  direction of travel of x: assumed from the approach of the contact\n")) << text;
  EXPECT_TRUE(has(text, "  speed of y: trigger delay and backlash of y cannot be excluded without it\n"))
      << text;
  EXPECT_FALSE(has(text, "mm add")) << text;
}

TEST(DiagnoseText, FiguresSayWhereTheNoiseIsFrom) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.repeatability = 0.1e-6;
  Diagnosis d = verdict(Verdict::kMissingEffect);
  d.base =
      calibrate(session, Model(session.machine, observedDomain(session), std::vector<EffectSpec>()), options);
  d.missing = {play()};
  d.tailDof = 4.0;
  const std::string text = textOf(d);
  EXPECT_TRUE(has(text, "; with what was found, held out 0.32 um\n  repeatability")) << text;
  EXPECT_TRUE(has(text, "  repeatability 0.1 um (declared), noise found")) << text;
  d.base.repeatabilityFrom = "repeated";
  EXPECT_TRUE(has(textOf(d), "  repeatability 0.1 um (from repeated measurements)")) << textOf(d);
  EXPECT_TRUE(has(
      text,
      ", noise found 0.310 ± 0.016 um\n  the noise has heavy tails: Student's t of 4 degrees of freedom\n"))
      << text;
  EXPECT_TRUE(has(text, "k = 2")) << text;
  d.base.repeatabilityFrom = "estimated";
  EXPECT_TRUE(has(textOf(d), "  repeatability not known, noise found")) << textOf(d);
}

TEST(DiagnoseText, WhatCouldNotShowForOneReasonIsOneLineAndSixLinesAreShown) {
  Diagnosis d = verdict(Verdict::kExplained);
  for (int i = 0; i < 10; ++i)
    d.cannotShow.push_back({backlash("x" + std::to_string(i)), "x stood still", ""});
  EXPECT_TRUE(has(textOf(d), "  backlash of x0, backlash of x1, backlash of x2 and 7 more: x stood still\n"))
      << textOf(d);
  for (int i = 0; i < 7; ++i)
    d.cannotShow.push_back({backlash("y" + std::to_string(i)), "reason " + std::to_string(i), ""});
  EXPECT_TRUE(has(textOf(d), "  backlash of y4: reason 4\n  and 2 more (--json lists them)\n")) << textOf(d);
}

TEST(DiagnoseText, EffectsOfJointsThatNeverMovedAreOneLine) {
  Diagnosis d = verdict(Verdict::kExplained);
  const Session session = test::interferometerSession(1e-6, 0.2e-6);
  d.base = calibrate(session, Model(session.machine, observedDomain(session), std::vector<EffectSpec>()), {});
  d.cannotShow = {{backlash("y"), "no", ""}, {backlash("x"), "its reason", ""}, {backlash("z"), "no", ""}};
  EXPECT_TRUE(has(textOf(d),
                  "cannot exclude\n  y, z never moved: 2 effects of them or along them (--json lists them)\n"
                  "  backlash of x: its reason\n"))
      << textOf(d);
}

TEST(DiagnoseText, InputsWithoutWhichTheSameIsUnknownAreOneLine) {
  Diagnosis d = verdict(Verdict::kExplained);
  d.missingInputs = {{"speed of y", "", {EffectSpec("speed_lag")}},
                     {"speed of z", "", {EffectSpec("speed_lag")}}};
  EXPECT_TRUE(has(textOf(d), "  speed of y, speed of z: trigger delay cannot be excluded without it\n"))
      << textOf(d);
}

TEST(DiagnoseText, AVerySmallProbabilityIsABound) {
  Diagnosis d = verdict(Verdict::kExplained);
  d.where = {{"time", 0.5, 1e-285, 0.25, 0.02}};
  const Session session = test::interferometerSession(1e-6, 0.2e-6);
  d.base = calibrate(session, Model(session.machine, observedDomain(session), std::vector<EffectSpec>()), {});
  EXPECT_TRUE(has(textOf(d), " 50.0 %   p < 1e-6")) << textOf(d);
  EXPECT_TRUE(has(textOf(d), " 25.0 %   p = 0.02\n")) << textOf(d);
}

TEST(DiagnoseJson, MissingWithOddsGainAndRivals) {
  const Json json = jsonOf(confusable());
  EXPECT_EQ(json["verdict"], "confusable");
  const Json& one = json["missing"][0];
  EXPECT_EQ(one["in_words"], "backlash of x");
  EXPECT_EQ(one["odds"], 0.6);
  EXPECT_EQ(one["odds_in_words"], "3 to 2");
  EXPECT_EQ(one["gain"], 183.0);
  EXPECT_EQ(one["p_value"], 1e-40);
  EXPECT_FALSE(one.contains("stability"));
  ASSERT_EQ(one["confusable_with"].size(), 3u);
  const Json& lag = one["confusable_with"][0];
  EXPECT_EQ(lag["effect"]["type"], "speed_lag");
  EXPECT_EQ(lag["odds"], 0.3);
  EXPECT_EQ(lag["same"], false);
  EXPECT_EQ(lag["not_recorded"], "");
  EXPECT_EQ(lag["moves"], "touch x at two speeds");
  EXPECT_EQ(one["confusable_with"][1]["same"], true);
  EXPECT_EQ(one["confusable_with"][2]["not_recorded"], "direction of travel of y");
}

TEST(DiagnoseJson, MissingKeepsItsOrder) {
  Diagnosis d = verdict(Verdict::kMissingEffect);
  d.missing = {play(), play()};
  d.missing[0].effect = growth("z");
  d.missing[0].gain = 1.0;
  const Json json = jsonOf(d);
  EXPECT_EQ(json["missing"][0]["effect"]["type"], "thermal_growth");
  EXPECT_EQ(json["missing"][1]["effect"]["type"], "backlash");
}

TEST(DiagnoseJson, ProfilesDriftArtifactInputsAndNoise) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  d.profiles = {bump()};
  d.drift = {wander()};
  d.drift[0].perhaps = {{growth("x"), 0.3, 0.6}};
  d.artifactScatter = {{"centres", 0.5e-6, {}, "measure the plate again"}};
  d.missingInputs = {{"speed of y", "", {EffectSpec("speed_lag")}}};
  const Json json = jsonOf(d);
  const Json& p = json["profiles"][0];
  EXPECT_EQ(p["effect"], (Json{{"type", "profile"}, {"direction", "z"}, {"variable", "x"}}));
  EXPECT_EQ(p["direction"], "z");
  EXPECT_EQ(p["variables"], Json::array({"x"}));
  EXPECT_EQ(p["units"], Json::array({"mm"}));
  EXPECT_NEAR(p["held_out_rms_um"][1].get<double>(), 0.33, 1e-12);
  EXPECT_EQ(p["odds"], 0.9999);
  EXPECT_EQ(p["curve"].size(), 17u);
  EXPECT_EQ(p["curve"][0][0], -16.0);
  EXPECT_EQ(p["curve"][0][2], 0.1);
  const Json& drift = json["drift"][0];
  EXPECT_EQ(drift["direction"], "x");
  EXPECT_NEAR(drift["std_um"].get<double>(), 0.4, 1e-12);
  EXPECT_EQ(drift["time_constant_s"], 1200.0);
  EXPECT_EQ(drift["perhaps"][0]["effect"]["type"], "thermal_growth");
  EXPECT_EQ(drift["perhaps"][0]["odds"], 0.3);
  EXPECT_EQ(json["artifact_scatter"][0]["what"], "centres");
  EXPECT_NEAR(json["artifact_scatter"][0]["std_um"].get<double>(), 0.5, 1e-12);
  EXPECT_EQ(json["missing_inputs"][0]["input"], "speed of y");
  EXPECT_EQ(json["missing_inputs"][0]["assumed"], "");
  EXPECT_EQ(json["missing_inputs"][0]["effects"][0]["type"], "speed_lag");
  EXPECT_NEAR(json["noise_um"].get<double>(), 0.31, 1e-12);
  EXPECT_NEAR(json["noise_std_um"].get<double>(), 0.008, 1e-12);
  EXPECT_TRUE(json["tail_dof"].is_null());
  EXPECT_TRUE(json["formulas"].empty());
}

TEST(DiagnoseJson, AngularFiguresHaveTheirOwnKeys) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  d.angular = true;
  d.noise = 2.0 * kArcsecond;
  d.profiles = {bump()};
  d.profiles[0].heldOutBefore = 4.0 * kArcsecond;
  d.missing = {play()};
  d.missing[0].size = 3.0 * kArcsecond;
  d.drift = {{"pan", 5.0 * kArcsecond, 7200.0, {}, ""}};
  const Json json = jsonOf(d);
  EXPECT_TRUE(json["noise_um"].is_null());
  EXPECT_NEAR(json["noise_arcsec"].get<double>(), 2.0, 1e-12);
  EXPECT_TRUE(json["profiles"][0]["held_out_rms_um"].is_null());
  EXPECT_NEAR(json["profiles"][0]["held_out_rms_arcsec"][0].get<double>(), 4.0, 1e-12);
  EXPECT_EQ(json["profiles"][0]["unit"], "arcsec");
  EXPECT_TRUE(json["drift"][0]["std_um"].is_null());
  EXPECT_NEAR(json["drift"][0]["std_arcsec"].get<double>(), 5.0, 1e-12);
  EXPECT_TRUE(json["missing"][0]["size_um"].is_null());
  EXPECT_NEAR(json["missing"][0]["size_arcsec"].get<double>(), 3.0, 1e-12);
}

TEST(DiagnoseJson, NothingIsNanOrInfinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Diagnosis d = confusable();
  d.missing[0].gain = inf;
  d.missing[0].odds = nan;
  d.missing[0].confusableWith[0].odds = nan;
  d.profiles = {bump()};
  d.profiles[0].curve[3][2] = nan;
  d.profiles[0].heldOutAfter = inf;
  d.drift = {{"x", nan, inf, {{growth("x"), nan, nan}}, ""}};
  d.artifactScatter = {{"form", nan, false, ""}};
  d.noise = nan;
  const std::string text = diagnoseJson(told(d));
  for (const char* word : {"nan", "NaN", "inf,", "Infinity"}) EXPECT_FALSE(has(text, word)) << text;
  EXPECT_TRUE(Json::parse(text)["profiles"][0]["curve"][3][2].is_null());
  EXPECT_FALSE(has(textOf(d), "nan")) << textOf(d);
}

}  // namespace
}  // namespace mm
