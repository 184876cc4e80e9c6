#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "base/error.h"
#include "base/units.h"
#include "calibration_file/calibration_yaml.h"
#include "design/point_set.h"
#include "model/observed_domain.h"
#include "report/json.h"
#include "report/text.h"
#include "report/text_parts.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

/// Deviations of one joint: slope * position + gap / 2 * direction + noise. SI.
Session deviations(const std::string& machine, const std::string& joint, double slope, double gap,
                   double noise) {
  Session session(Machine::load(machine));
  session.source = "made up";
  const int j = session.machine.findJoint(joint), joints = session.machine.jointCount();
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0.0, noise);
  for (int i = 0; i < 80; ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = i;
    o.row = i + 2;
    o.position.assign(joints, 0.0);
    o.velocity.assign(joints, 0.0);
    const int way = (i / 10) % 2 == 0 ? 1 : -1;
    o.position[j] = way * (i % 10 - 4.5) * 2e-3;
    o.velocity[j] = way * 1e-3;
    o.deviation.assign(joints, kNotMeasured);
    o.deviationStd.assign(joints, kNotMeasured);
    o.deviation[j] = slope * o.position[j] - 0.5 * gap * way + normal(random);
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

EffectSpec scale(const std::string& axis) { return EffectSpec("scale").set("axis", axis); }
EffectSpec backlash(const std::string& axis) { return EffectSpec("backlash").set("axis", axis); }

CalibrateOptions leastSquares() {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  return options;
}

TEST(ReportText, OneLineHasTheErrorBeforeAndAfterAndTheRepeatability) {
  const Session session = deviations("three_axis", "x", 1e-4, 0.0, 0.1e-6);
  ModelSpec model;
  model.effects = {scale("x")};
  const Recalibration done = recalibrate(session, model, leastSquares());
  const std::string line = errorText(done.result, done.calibration.ledger.back().rmsBefore);
  EXPECT_EQ(line.rfind("RMS ", 0), 0U) << line;
  EXPECT_NE(
      line.find(length(done.result.before.rms, false) + " -> " + length(done.result.figures.rms, false)),
      std::string::npos)
      << line;
  EXPECT_NE(line.find("repeatability " + length(done.result.repeatability, false)), std::string::npos)
      << line;
}

TEST(Recalibrate, KeepsWhenAndWhereItsSessionComesFrom) {
  Session session = deviations("three_axis", "x", 1e-4, 0.0, 0.1e-6);
  ModelSpec model;
  model.effects = {scale("x")};
  session.epoch = 0.0;
  const Calibration undated = recalibrate(session, model, leastSquares()).calibration;
  EXPECT_TRUE(std::isnan(undated.sessionEpoch));
  EXPECT_EQ(undated.sessionOrigin, "");
  session.epoch = 1767225600.0;
  session.simulated = true;
  const Calibration dated = recalibrate(session, model, leastSquares()).calibration;
  EXPECT_EQ(dated.sessionEpoch, 1767225600.0);
  EXPECT_EQ(dated.sessionOrigin, "simulated");
}

void expectNoNumberIsMissing(const nlohmann::json& value, const std::string& text) {
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
  EXPECT_FALSE(value.is_discarded());
}

TEST(Report, AngularFiguresAreInArcseconds) {
  const Session session = deviations("five_axis", "b", 1e-3, 0.0, 2.0 * kArcsecond);
  ModelSpec model;
  model.effects = {EffectSpec("formula").set("direction", "b").set("formula", "k1*b")};
  const Recalibration done = recalibrate(session, model, leastSquares());
  const std::string text = calibrateJson(done.result);
  const nlohmann::json json = nlohmann::json::parse(text);
  expectNoNumberIsMissing(json, text);
  EXPECT_TRUE(json["rms_um"].is_null());
  EXPECT_TRUE(json["held_out_rms_um"].is_null());
  EXPECT_NEAR(json["rms_arcsec"].get<double>(), 2.0, 0.4);
  EXPECT_NEAR(json["held_out_rms_arcsec"].get<double>(), 2.0, 0.4);
  EXPECT_TRUE(std::isnan(done.calibration.rms));
  EXPECT_NEAR(done.calibration.rmsAngular, 2.0 * kArcsecond, 0.4 * kArcsecond);
  EXPECT_NEAR(json["parameters"][0]["value"].get<double>(), 1e-3 / kArcsecond, 30.0);  // arcsec a rad
  EXPECT_NE(calibrateText(done.result).find("arcsec"), std::string::npos);
}

TEST(Report, EffectsKeepTheirKindsOfValues) {
  const Session session = deviations("three_axis", "x", 1e-3, 0.0, 1e-7);
  ModelSpec model;
  model.effects = {
      scale("x"), EffectSpec("positioning_polynomial").set("axis", "x").set("degree", "3"),
      EffectSpec("formula").set("direction", "x").set("formula", "k1*x^2").setList("start", {"0.5"})};
  const nlohmann::json json =
      nlohmann::json::parse(calibrateJson(recalibrate(session, model, leastSquares()).result));
  EXPECT_EQ(json["parameters"][0]["effect"], (nlohmann::json{{"type", "scale"}, {"axis", "x"}}));
  EXPECT_EQ(json["parameters"][1]["effect"]["degree"], 3);
  EXPECT_EQ(json["parameters"][2]["effect"]["start"], nlohmann::json::array({0.5}));
}

TEST(Report, CalibrationKeepsWhatTheFitFound) {
  const Session session = deviations("three_axis", "x", 4e-4, 6e-6, 2e-7);
  ModelSpec model;
  model.machine = "three_axis";
  model.effects = {scale("x"), backlash("x")};
  Recalibration done = recalibrate(session, model, leastSquares());
  ASSERT_EQ(done.calibration.values.size(), 2u);
  EXPECT_NEAR(done.calibration.values[0].value, 4e-4, 2e-5);
  EXPECT_NEAR(done.calibration.values[1].value, 6e-6, 2e-7);
  EXPECT_DOUBLE_EQ(std::sqrt(done.calibration.covariance(1, 1)), done.calibration.values[1].std);
  ASSERT_EQ(done.calibration.ledger.size(), 1u);
  EXPECT_EQ(done.calibration.ledger[0].action, "calibrate");
  EXPECT_LT(done.calibration.ledger[0].rmsAfter, 0.2 * done.calibration.ledger[0].rmsBefore);

  // it survives its file, and the file alone gives the same residuals
  completeCalibration(done.calibration);
  const Calibration read = parseCalibration(calibrationYaml(done.calibration), "text");
  const CalibrationResult compared = compareCalibration(session, read, {});
  EXPECT_NEAR(compared.figures.rms, done.result.figures.rms, 1e-15);
  EXPECT_EQ(compared.x.head(2), done.result.x.head(2));
}

TEST(Report, NoiseThatWasDeclaredStaysDeclared) {
  const Session session = deviations("three_axis", "x", 4e-4, 6e-6, 2e-7);
  ModelSpec model;
  model.effects = {scale("x")};
  CalibrateOptions options = leastSquares();
  options.repeatability = 2e-7;
  Recalibration done = recalibrate(session, model, options);
  const Recalibration added = addEffect(session, done.calibration, backlash("x"), {});
  EXPECT_EQ(added.result.repeatabilityFrom, "declared");
  EXPECT_NEAR(added.result.figures.chi2PerDof, 1.0, 0.4);
}

TEST(Report, EachStepCanBeTakenBack) {
  const Session session = deviations("three_axis", "x", 4e-4, 6e-6, 2e-7);
  ModelSpec model;
  model.effects = {scale("x"), EffectSpec("positioning_polynomial").set("axis", "x").set("degree", "2")};
  Recalibration first = recalibrate(session, model, {});
  completeCalibration(first.calibration);
  Recalibration added = addEffect(session, first.calibration, backlash("x"), {});
  completeCalibration(added.calibration);
  const Recalibration back = removeEffect(session, added.calibration, backlash("x"), {});
  EXPECT_NEAR(back.result.figures.rms / first.result.figures.rms, 1.0, 1e-9);
  EXPECT_NEAR(back.result.figures.heldOutRms / first.result.figures.heldOutRms, 1.0, 1e-9);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(back.result.x[i], first.result.x[i], 1e-6 * first.result.std(i));
  ASSERT_EQ(back.calibration.ledger.size(), 3u);
  EXPECT_EQ(back.calibration.ledger[1].calibration, first.calibration.id);
  EXPECT_EQ(back.calibration.ledger[2].calibration, added.calibration.id);
  EXPECT_GT(back.calibration.ledger[1].rmsBefore, 5.0 * back.calibration.ledger[1].rmsAfter);
}

TEST(Report, SymbolsOfIso230StandBesideTheWords) {
  const Session session = deviations("three_axis", "x", 4e-4, 6e-6, 2e-7);
  ModelSpec model;
  model.effects = {scale("x"), EffectSpec("probe_radius")};
  const Recalibration first = recalibrate(session, model, leastSquares());
  const Recalibration added = addEffect(session, first.calibration, backlash("x"), {});
  const std::string text = calibrateText(added.result);
  EXPECT_NE(text.find("\n  scale of x (EXX)\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n  effective radius of the probe tip\n"), std::string::npos) << text;
  const std::string ledger = ledgerText(added.calibration, false);
  EXPECT_NE(ledger.find("add {type: backlash, axis: x} (EXX) "), std::string::npos) << ledger;
  const nlohmann::json json = nlohmann::json::parse(changeJson(added.result, added.calibration.ledger));
  EXPECT_EQ(json["parameters"][0]["iso230"], "EXX");
  EXPECT_EQ(json["parameters"][1].count("iso230"), 0u);
  EXPECT_EQ(json["ledger"][0].count("iso230"), 0u);
  EXPECT_EQ(json["ledger"][1]["iso230"], "EXX");
  EXPECT_EQ(json["ledger"][1]["in_words"], "backlash of x");
  Diagnosis diagnosis;
  diagnosis.base = first.result;
  diagnosis.missing.resize(1);
  diagnosis.missing[0].effect = EffectSpec("squareness").set("axis", "x").set("of", "y");
  EXPECT_EQ(nlohmann::json::parse(diagnoseJson(diagnosis))["missing"][0]["iso230"], "C0Y");
  EXPECT_NE(diagnoseText(diagnosis, "s.bag", "c.yaml").find("\n  squareness of y to x (C0Y)\n"),
            std::string::npos);
}

TEST(Report, SameEffectHoweverItIsWritten) {
  const Session session = deviations("three_axis", "x", 4e-4, 6e-6, 2e-7);
  ModelSpec model;
  model.effects = {EffectSpec("angular_motion").set("axis", "x").set("about", "y")};
  const Domain domain = observedDomain(session);
  EXPECT_TRUE(
      sameEffect(model.effects[0], EffectSpec("angular_motion").set("about", "y").set("axis", "x"), domain));
  EXPECT_TRUE(sameEffect(model.effects[0],
                         EffectSpec("angular_motion").set("axis", "x").set("about", "y").set("degree", "1"),
                         domain));
  EXPECT_FALSE(sameEffect(model.effects[0],
                          EffectSpec("angular_motion").set("axis", "x").set("about", "y").set("degree", "2"),
                          domain));
}

TEST(Report, AnEffectTwiceIsRefused) {
  const Session session = deviations("three_axis", "x", 4e-4, 6e-6, 2e-7);
  ModelSpec model;
  model.effects = {scale("x"), scale("x")};
  EXPECT_THROW(recalibrate(session, model, leastSquares()), InputError);
}

TEST(Report, ACalibrationOfAnotherDayIsHeld) {
  ModelSpec model;
  model.effects = {scale("x")};
  const Session first = deviations("three_axis", "x", 4e-4, 0.0, 2e-7),
                later = deviations("three_axis", "x", 6e-4, 0.0, 2e-7);
  const Recalibration done = recalibrate(first, model, leastSquares());
  const CalibrationResult compared = compareCalibration(later, done.calibration, {});
  EXPECT_EQ(compared.x[0], done.result.x[0]);
  EXPECT_NEAR(compared.figures.rms, 2e-4 * 2e-3 * std::sqrt(8.25),
              1e-7);  // RMS of the positions is sqrt(8.25) * 2 mm
  EXPECT_TRUE(compared.converged);
  EXPECT_FALSE(compared.identifiability.incomplete());
}

TEST(Report, CandidatesInTheUnitsOfPeople) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kMissingEffect;
  CandidateResult missing;
  missing.effect = backlash("x");
  missing.parameters = {{"gap", "um", 2.06, 0.03}};
  missing.heldOutBefore = 0.93e-6;
  missing.heldOutAfter = 0.32e-6;
  missing.pValue = 1e-40;
  missing.confusableWith.push_back({EffectSpec("speed_lag"), 2.1, 0.1, false, "", ""});
  diagnosis.missing = {missing};
  diagnosis.formulas = {
      {EffectSpec("formula").set("direction", "z").set("formula", "k1*x*y"), {}, 0.93e-6, 0.33e-6}};
  diagnosis.nextMeasurement.resize(1);
  diagnosis.nextMeasurement[0].values = {{"x_mm", 0.0}};
  diagnosis.nextMeasurement[0].words = {{"feature", "b0"}};
  diagnosis.where = {{"x travel direction", 0.41, 1e-30, 0.41, 1e-30},
                     {"t", std::numeric_limits<double>::quiet_NaN(), 1.0}};
  const nlohmann::json json = nlohmann::json::parse(diagnoseJson(diagnosis));
  EXPECT_EQ(json["verdict"], "missing_effect");
  const nlohmann::json& one = json["missing"][0];
  EXPECT_EQ(one["effect"], (nlohmann::json{{"type", "backlash"}, {"axis", "x"}}));
  EXPECT_EQ(one["parameters"][0],
            (nlohmann::json{{"name", "gap"}, {"value", 2.06}, {"std", 0.03}, {"unit", "um"}}));
  EXPECT_NEAR(one["held_out_rms_um"][0].get<double>(), 0.93, 1e-12);
  EXPECT_NEAR(one["held_out_rms_um"][1].get<double>(), 0.32, 1e-12);
  EXPECT_EQ(one["confusable_with"][0]["effect"]["type"], "speed_lag");
  EXPECT_EQ(json["formulas"][0]["formula"], "k1*x*y");
  EXPECT_EQ(json["formulas"][0]["direction"], "z");
  EXPECT_EQ(json["next_measurement"][0]["x_mm"], 0.0);
  EXPECT_EQ(json["next_measurement"][0]["feature"], "b0");
  EXPECT_TRUE(json["where"][1]["share"].is_null());
  EXPECT_EQ(json["where"][0]["share_beside"], 0.41);
  EXPECT_EQ(json["where"][0]["p_value_beside"], 1e-30);
}

TEST(Report, CheckSeesWhatTheSessionCannotShow) {
  const Session session = deviations("three_axis", "x", 4e-4, 6e-6, 2e-7);
  const PointSet set = checkPointSet(session, nullptr);
  EXPECT_EQ(set.references, 80);
  EXPECT_EQ(set.joints[0].positions, 10);
  EXPECT_EQ(set.joints[0].up, 40);
  EXPECT_EQ(set.joints[0].down, 40);
  const auto hidden = [&](const EffectSpec& effect) {
    return std::any_of(set.cannotShow.begin(), set.cannotShow.end(),
                       [&](const CannotBeShown& c) { return c.effect == effect; });
  };
  EXPECT_FALSE(hidden(backlash("x")));
  EXPECT_FALSE(hidden(scale("x")));
  EXPECT_TRUE(hidden(backlash("y")));
  EXPECT_TRUE(hidden(scale("z")));
  // y was never moved: what a polynomial of y does is a constant
  EXPECT_TRUE(hidden(EffectSpec("straightness").set("axis", "y").set("direction", "x").set("degree", "2")));
}

TEST(Text, AdviceForAnInstrumentsZeroSpeaksOfTheInstrument) {
  const Session session = deviations("three_axis", "x", 50e-6, 3e-6, 0.1e-6);
  ModelSpec model;
  model.effects = {EffectSpec("position_table").set("axis", "x")};
  const std::string text = calibrateText(recalibrate(session, model, leastSquares()).result);
  EXPECT_NE(text.find("Not determined by this session"), std::string::npos) << text;
  EXPECT_NE(text.find("shows differences only"), std::string::npos) << text;
  EXPECT_EQ(text.find("more of the ball"), std::string::npos) << text;
}

/// ± says what every other output says: k = 2.
TEST(Text, UncertaintiesAreExpandedAndSaySo) {
  EXPECT_EQ(withUncertainty(25.412, 0.055, "um"), "25.41 ± 0.11 um");
  const Session session = deviations("three_axis", "x", 50e-6, 3e-6, 0.1e-6);
  ModelSpec model;
  model.effects = {EffectSpec("scale").set("axis", "x"), backlash("x")};
  const CalibrationResult result = recalibrate(session, model, leastSquares()).result;
  const std::string text = calibrateText(result), legend = "\n± is the expanded uncertainty, k = 2\n";
  EXPECT_NE(text.find(withUncertainty(result.x[0] * 1e6, result.std(0) * 1e6, "um/m")), std::string::npos)
      << text;
  ASSERT_NE(text.find(legend), std::string::npos) << text;
  EXPECT_EQ(text.find("k = 2", text.find(legend) + legend.size()), std::string::npos) << text;
}

/// Residuals that follow their neighbours may be drift or a cause that the model lacks: a calibration cannot
/// tell.
TEST(Text, ACalibrationAssertsNoDrift) {
  const Session session = deviations("three_axis", "x", 50e-6, 3e-6, 0.1e-6);
  ModelSpec model;
  model.effects = {scale("x")};
  CalibrationResult result = recalibrate(session, model, leastSquares()).result;
  Drift drift;
  drift.direction = "x";
  drift.std = 0.5e-6;
  drift.timeConstant = 3.0;
  result.drift = {drift};
  const std::string text = calibrateText(result);
  EXPECT_NE(text.find("residuals are autocorrelated, by drift or by an effect that the model lacks"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("a drift along x: standard deviation 0.5 um, time constant 3 s\n"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("drifts"), std::string::npos) << text;
}

TEST(Text, AFitWithoutRedundancyHasNoRepeatability) {
  Session session = deviations("three_axis", "x", 50e-6, 0.0, 0.1e-6);
  session.observations.resize(2);
  session.prepare();
  ModelSpec model;
  model.effects = {scale("x")};
  const CalibrationResult result = recalibrate(session, model, leastSquares()).result;
  EXPECT_EQ(result.figures.degreesOfFreedom, 0);
  const std::vector<std::string> doubts = doubtsOf(result);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_EQ(doubts[0].find("2 residuals and as many free parameters (degrees of freedom 0)"), 0u)
      << doubts[0];
  EXPECT_NE(calibrateText(result).find("Repeatability  not known: degrees of freedom 0"), std::string::npos);
}

TEST(Text, WhatAModelLeavesAndWhatToTypeNext) {
  const Session session = deviations("three_axis", "x", 50e-6, 3e-6, 0.1e-6);
  CalibrateOptions options = leastSquares();
  options.repeatability = 0.1e-6;
  ModelSpec model;
  const std::string none = nextText(recalibrate(session, model, options).result, "my s.bag", "c.yaml");
  EXPECT_EQ(none.rfind("The model leaves ", 0), 0u) << none;
  EXPECT_NE(
      none.find(" times the repeatability: mm diagnose 'my s.bag' --calibration c.yaml says what it lacks\n"),
      std::string::npos)
      << none;
  model.effects = {EffectSpec("scale").set("axis", "x"), backlash("x")};
  const CalibrationResult whole = recalibrate(session, model, options).result;
  EXPECT_EQ(nextText(whole, "s.bag", "c.yaml"),
            "Next: mm diagnose s.bag --calibration c.yaml says whether the model lacks anything\n");
  EXPECT_NE(nextText(whole, "s.bag", "").find("once it is written with -o"), std::string::npos);
}

}  // namespace
}  // namespace mm
