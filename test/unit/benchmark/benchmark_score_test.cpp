#include "benchmark_score.h"

#include <gtest/gtest.h>

#include "base/random.h"
#include "benchmark_counts.h"
#include "benchmark_oracle.h"

namespace mm {
namespace {

EffectSpec backlash(const char* axis) { return EffectSpec("backlash").set("axis", axis); }
EffectSpec growth(const char* direction, const char* sensor = "bed") {
  return EffectSpec("thermal_growth").set("direction", direction).set("sensor", sensor);
}
EffectSpec straightness(const char* axis, int degree) {
  return EffectSpec("straightness").set("axis", axis).set("direction", "z").set("degree", degree);
}

CandidateResult named(EffectSpec effect, const std::vector<EffectSpec>& rivals = {}) {
  CandidateResult result;
  result.effect = std::move(effect);
  for (const EffectSpec& rival : rivals) {
    result.confusableWith.emplace_back();
    result.confusableWith.back().effect = rival;
  }
  return result;
}

Diagnosis saying(std::vector<CandidateResult> missing) {
  Diagnosis diagnosis;
  diagnosis.missing = std::move(missing);
  return diagnosis;
}

void wander(Diagnosis& diagnosis, const std::vector<EffectSpec>& perhaps) {
  DriftResult drift;
  drift.direction = "x";
  for (const EffectSpec& effect : perhaps) {
    drift.perhaps.emplace_back();
    drift.perhaps.back().effect = effect;
  }
  diagnosis.drift.push_back(drift);
}

TEST(Score, NothingHiddenAndNothingSaid) {
  Diagnosis diagnosis;
  wander(diagnosis, {growth("x")});  // drift and what it may be is no claim
  const Score s = scoreOf(diagnosis, {});
  EXPECT_FALSE(s.claimed);
  EXPECT_TRUE(s.exact());
  EXPECT_EQ(s.wrong, 0);
  EXPECT_EQ(s.perhaps, 1);
}

TEST(Score, NothingHiddenAndSomethingSaid) {
  Diagnosis profile, formula;
  profile.profiles.emplace_back();
  formula.formulas.emplace_back();
  EXPECT_TRUE(scoreOf(profile, {}).claimed);
  EXPECT_TRUE(scoreOf(profile, {}).profile);
  EXPECT_TRUE(scoreOf(formula, {}).formula);
  const Score s = scoreOf(saying({named(backlash("x"))}), {});
  EXPECT_TRUE(s.claimed);
  EXPECT_EQ(s.wrong, 1);
  EXPECT_FALSE(s.firstRight);
  EXPECT_FALSE(s.exact());
}

TEST(Score, ANamedCauseIsRightInAnyShapeButOnlyWhereItActs) {
  const Score s =
      scoreOf(saying({named(straightness("x", 3)), named(straightness("x", 2))}), {straightness("x", 2)});
  EXPECT_TRUE(s.exact());
  EXPECT_TRUE(s.firstRight);
  EXPECT_EQ(s.count(Hit::kNamed), 1);
  EXPECT_EQ(scoreOf(saying({named(straightness("y", 2))}), {straightness("x", 2)}).wrong, 1);
  EXPECT_EQ(scoreOf(saying({named(growth("x", "air"))}), {growth("x")}).wrong, 1);
}

TEST(Score, OneOfAtMostTwoRivalsIsAHit) {
  const EffectSpec lag("speed_lag");
  const Score two = scoreOf(saying({named(lag, {backlash("x"), backlash("y")})}), {backlash("x")});
  EXPECT_EQ(two.hits[0], Hit::kConfusable);
  EXPECT_EQ(two.wrong, 0);
  EXPECT_TRUE(two.firstRight);
  EXPECT_TRUE(two.exact());
  const Score three =
      scoreOf(saying({named(lag, {backlash("x"), backlash("y"), backlash("z")})}), {backlash("x")});
  EXPECT_EQ(three.hits[0], Hit::kMissed);
  EXPECT_EQ(three.wrong, 1);
  EXPECT_FALSE(three.firstRight);
  // what is named itself is right, however many rivals it has
  const Score itself =
      scoreOf(saying({named(backlash("x"), {lag, backlash("y"), backlash("z")})}), {backlash("x")});
  EXPECT_EQ(itself.hits[0], Hit::kNamed);
  EXPECT_EQ(itself.wrong, 0);
}

TEST(Score, OneHiddenCauseExcusesOneNamedCauseOnly) {
  const EffectSpec lag("speed_lag");
  const Score twice =
      scoreOf(saying({named(lag, {backlash("x")}), named(backlash("y"), {backlash("x")})}), {backlash("x")});
  EXPECT_EQ(twice.hits[0], Hit::kConfusable);
  EXPECT_EQ(twice.wrong, 1);
  const Score beside = scoreOf(saying({named(lag, {backlash("x")}), named(backlash("x"))}), {backlash("x")});
  EXPECT_EQ(beside.hits[0], Hit::kNamed);
  EXPECT_EQ(beside.wrong, 1);
  EXPECT_FALSE(beside.firstRight);
  const Score both = scoreOf(saying({named(lag, {backlash("x")}), named(growth("z"), {backlash("y")})}),
                             {backlash("x"), backlash("y")});
  EXPECT_EQ(both.count(Hit::kConfusable), 2);
  EXPECT_TRUE(both.exact());
}

TEST(Score, ACauseThatChangesWithTimeMayBeListedBesideDrift) {
  for (const EffectSpec& cause :
       {growth("x"), EffectSpec("thermal_expansion").set("axis", "x").set("sensor", "bed"),
        EffectSpec("time_drift").set("direction", "x"), EffectSpec("warm_up").set("direction", "x")}) {
    Diagnosis diagnosis;
    wander(diagnosis, {growth("z", "air"), cause});
    const Score s = scoreOf(diagnosis, {cause});
    EXPECT_EQ(s.hits[0], Hit::kBesideDrift) << cause.yaml();
    EXPECT_TRUE(s.firstRight && s.firstBesideDrift);
    EXPECT_FALSE(s.exact());
    EXPECT_FALSE(s.claimed);
    // but not where another cause is named first
    diagnosis.missing = {named(backlash("x"))};
    EXPECT_FALSE(scoreOf(diagnosis, {cause}).firstRight);
    EXPECT_EQ(scoreOf(diagnosis, {cause}).hits[0], Hit::kBesideDrift);
  }
}

Trial trialOf(const Diagnosis& diagnosis, const std::vector<EffectSpec>& hidden) {
  Trial trial;
  trial.hidden = hidden;
  trial.verdict = diagnosis.verdict;
  trial.score = scoreOf(diagnosis, hidden);
  trial.heldOutEnd = 1.0;
  return trial;
}

TEST(BenchmarkCounts, AddUp) {
  BenchmarkCounts counts(1, false);
  counts.add(trialOf(saying({named(backlash("x"))}), {backlash("x")}));
  counts.add(trialOf(saying({named(EffectSpec("speed_lag"), {backlash("y")})}), {backlash("y")}));
  counts.add(trialOf(saying({named(backlash("z")), named(backlash("y"))}), {growth("x")}));
  Diagnosis drifting;
  wander(drifting, {growth("x"), growth("x", "air")});
  counts.add(trialOf(drifting, {growth("x")}));
  Diagnosis formula;
  formula.formulas.emplace_back();
  counts.add(trialOf(formula, {backlash("x")}));
  Trial notShown;
  notShown.notShown = true;
  counts.add(notShown);
  const nlohmann::ordered_json j = counts.json();
  EXPECT_EQ(j["sessions"], 5);
  EXPECT_EQ(j["not_shown"], 1);
  EXPECT_EQ(j["first_right"], 3);
  EXPECT_EQ(j["first_beside_drift"], 1);
  EXPECT_EQ(j["exact"], 2);
  EXPECT_EQ(j["sessions_wrong"], 1);
  EXPECT_EQ(j["wrong"], 2);
  EXPECT_EQ(j["sessions_formula"], 1);
  EXPECT_EQ(j["listed_beside_drift"], 2);
  EXPECT_EQ(j["causes"]["named"], 1);
  EXPECT_EQ(j["causes"]["confusable"], 1);
  EXPECT_EQ(j["causes"]["beside_drift"], 1);
  EXPECT_EQ(j["causes"]["missed"], 2);
  EXPECT_EQ(j["by_effect"]["backlash"]["hidden"], 3);
  EXPECT_EQ(j["trials"].size(), 5u);
  EXPECT_EQ(j["trials"][3]["hits"][0], "beside_drift");
  const std::string text = counts.text();
  EXPECT_NE(text.find("first named is one that was hidden"), std::string::npos);
  EXPECT_NE(text.find("3/5"), std::string::npos);
  EXPECT_NE(text.find("wrong causes a session: 0.400"), std::string::npos);
}

TEST(BenchmarkCounts, NothingHidden) {
  BenchmarkCounts counts(0, false);
  counts.add(trialOf({}, {}));
  counts.add(trialOf(saying({named(backlash("x"))}), {}));
  EXPECT_EQ(counts.json()["sessions_claimed"], 1);
  EXPECT_TRUE(counts.good(trialOf({}, {})));
  EXPECT_FALSE(counts.good(trialOf(saying({named(backlash("x"))}), {})));
  EXPECT_NE(counts.text().find("sessions with anything claimed"), std::string::npos);
}

TEST(BenchmarkCounts, IntervalsAreWilsons) {
  EXPECT_EQ(wilson(48, 50), " 96.0 % (86.5-98.9 %) 48/50");
  EXPECT_EQ(wilson(0, 20), "  0.0 % (0.0-16.1 %) 0/20");
  EXPECT_EQ(wilson(0, 0), "-");
}

/// Noise of one session: white of standard deviation 1, and one strong slow wave.
Eigen::VectorXd noiseOf(Random& random, double wave) {
  Eigen::VectorXd n(200);
  const double size = wave * random.normal();
  for (int i = 0; i < 200; ++i) n(i) = random.normal() + size * std::sin(0.02 * i);
  return n;
}

Oracle oracleOf(double wave) {
  Random random(3, "oracle");
  Eigen::MatrixXd noise(200, 200);
  for (int k = 0; k < 200; ++k) noise.col(k) = noiseOf(random, wave);
  return Oracle(noise);
}

TEST(Oracle, InWhiteNoiseItIsSureOfWhatStandsOut) {
  const Oracle oracle = oracleOf(0.0);
  Random random(4, "sessions");
  Eigen::VectorXd column(200);
  for (int i = 0; i < 200; ++i) column(i) = i % 2 == 0 ? 0.5 : -0.5;  // sensitivity sqrt(200) / 2 = 7.07
  double gain = 0.0;
  int claims = 0;
  for (int k = 0; k < 200; ++k) {
    const Eigen::VectorXd noise = noiseOf(random, 0.0);
    gain += oracle.gain(column, noise + column) / 200.0;
    claims += oracle.gain(column, noise) > Oracle::sure();
  }
  // mean of (z² - 1 - ln z²) / 2 with z normal about 7.07, standard deviation 1; the scatter of z is known to
  // 5 %
  EXPECT_NEAR(gain, 0.5 * 50.0 - std::log(7.07), 4.0);
  EXPECT_EQ(claims, 0);
}

TEST(Oracle, ItDiscountsWhatRoughnessDoesToo) {
  const Oracle rough = oracleOf(5.0);
  Random random(5, "sessions");
  Eigen::VectorXd slow(200), quick(200);
  for (int i = 0; i < 200; ++i) {
    slow(i) = std::sin(0.02 * i);
    quick(i) = std::sin(1.3 * i);
  }
  int slowFound = 0, quickFound = 0, claims = 0;
  for (int k = 0; k < 100; ++k) {
    const Eigen::VectorXd noise = noiseOf(random, 5.0);
    slowFound += rough.gain(slow, noise + slow) > Oracle::sure();
    quickFound += rough.gain(quick, noise + quick) > Oracle::sure();
    claims += rough.gain(slow, noise) > Oracle::sure();
  }
  EXPECT_LE(slowFound, 2);
  EXPECT_GE(quickFound, 98);
  EXPECT_LE(claims, 2);
}

TEST(Oracle, NeedsEnoughSessionsOfTheSamePlan) {
  EXPECT_THROW(Oracle(Eigen::MatrixXd::Random(20, 7)), std::exception);
  const Oracle oracle(Eigen::MatrixXd::Random(20, 8));
  EXPECT_EQ(oracle.gain(Eigen::VectorXd::Ones(19), Eigen::VectorXd::Ones(20)), 0.0);
}

}  // namespace
}  // namespace mm
