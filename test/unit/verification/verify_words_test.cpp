#include "verification/verify_words.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

const char* const kFindings[] = {"corrected", "not_corrected", "wrong_sign", "corrected_twice",
                                 "exchanged", "partly",        "too_small"};

/// The verdicts that a sentence tells.
std::vector<VerifyVerdict> toldBy(const std::string& text) {
  std::vector<VerifyVerdict> told;
  const auto says = [&](const char* words) { return text.find(words) != std::string::npos; };
  if (says("it helped") || says("it helps")) told.push_back(VerifyVerdict::kHelped);
  if (says("no change")) told.push_back(VerifyVerdict::kNoChange);
  if (says("the errors rose") || says("makes it worse")) told.push_back(VerifyVerdict::kWorse);
  if (told.empty()) told.push_back(VerifyVerdict::kMixed);
  return told;
}

Verification found(const std::string& finding, bool loaded, bool drifted, double improvement) {
  Verification v;
  v.finding = finding;
  v.loaded = loaded;
  v.drifted = drifted;
  v.better = improvement > kFiguresDiffer;
  v.before = {3e-6, 0.1e-6};
  v.after = {improvement > 0.0 ? 1e-6 : improvement < 0.0 ? 6e-6 : 3e-6, 0.1e-6};
  v.observations = 54;
  v.axes.resize(2);
  v.axes[0].axis = "x";
  v.axes[1].axis = "y";
  v.hypothesis.axes = {AxisState::kNotCorrected, AxisState::kCorrected};
  if (finding == "exchanged") v.hypothesis.exchanges = {{0, 1, true}, {1, 0, true}};
  v.verdict = verdictOf(v, improvement);
  return v;
}

TEST(VerifyWords, sayWhatTheVerdictSays) {
  int asked = 0;
  for (const char* finding : kFindings)
    for (const bool loaded : {false, true})
      for (const bool drifted : {false, true})
        for (const double improvement : {-10.0, 0.0, 10.0}) {
          const Verification v = found(finding, loaded, drifted, improvement);
          const std::string text = sentenceOf(v);
          const std::vector<VerifyVerdict> told = toldBy(text);
          ASSERT_EQ(told.size(), 1u) << text;
          EXPECT_EQ(nameOf(told.front()), nameOf(v.verdict)) << text;
          EXPECT_EQ(text.find("drifted") != std::string::npos, drifted) << text;
          if (improvement > 0.0) {
            EXPECT_NE(v.verdict, VerifyVerdict::kWorse) << text;
          }
          if (improvement < 0.0) {
            EXPECT_NE(v.verdict, VerifyVerdict::kHelped) << text;
          }
          ++asked;
        }
  EXPECT_EQ(asked, 84);
}

TEST(VerifyWords, sayCorrectedOnlyWhereHalfOfTheErrorIsExcluded) {
  const auto words = [](double remaining, double std) {
    RemainingShare share;
    share.remaining = remaining;
    share.std = std;
    return inWords(share);
  };
  EXPECT_EQ(words(-0.1, 0.05), "corrected");
  EXPECT_EQ(words(1.1, 0.1), "not corrected");
  EXPECT_EQ(words(0.5, 0.05), "50 % remain");
  for (const double remaining : {-0.1, 0.0, 1.0})
    EXPECT_EQ(words(remaining, 0.24), "these points cannot tell whether it is corrected") << remaining;
  // 3.3 standard deviations reach half the way to the next state, of which 2 and -1 have none beyond them.
  EXPECT_EQ(words(-0.39, 0.12), "these points cannot tell whether it is corrected");
  EXPECT_EQ(words(-1.39, 0.12), "corrected twice");
  EXPECT_EQ(words(2.2, 0.09), "wrong sign");
  EXPECT_EQ(words(-0.88, 0.03), "corrected by 188 %");
}

TEST(VerifyWords, ofAnEffectSpeakOfWhatTheTablesCarry) {
  RemainingOfEffect effect;
  effect.remaining = -1.0;
  effect.std = 0.05;
  effect.notCarried = -0.8;  // the tables carry another effect in its shape
  EXPECT_EQ(inWords(effect), "corrected twice");
  effect.notCarried = 0.4;
  EXPECT_EQ(inWords(effect), "corrected twice, 40 % of it in no table");
  effect.notCarried = 0.97;
  EXPECT_EQ(inWords(effect), "not in any table");
}

TEST(VerifyWords, ofACorrectionThatPointsDoNotShow) {
  EXPECT_EQ(sentenceOf(found("too_small", false, false, 10.0)),
            "it helps: 3.00 -> 1.00 um at 54 fresh points (k = 2: ±0.20, ±0.20); these points do not show "
            "which axis");
  for (const double improvement : {-10.0, 0.0, 10.0}) {
    const Verification v = found("too_small", true, false, improvement);
    EXPECT_EQ(v.verdict, VerifyVerdict::kNoChange);
    EXPECT_NE(sentenceOf(v).find("these points cannot show whether it is loaded"), std::string::npos);
    EXPECT_NE(whyKept(v), "");  // nothing is rolled back that nobody has judged
  }
  EXPECT_EQ(found("too_small", false, false, -10.0).verdict, VerifyVerdict::kWorse);
}

TEST(VerifyWords, neverSayHelpedWithoutMoreThatIsLeft) {
  Verification v = found("corrected", true, false, 10.0);
  EXPECT_EQ(sentenceOf(v).find("are left"), std::string::npos);
  v.moreLeft = true;
  v.unforeseen = 1e-6;
  v.calibratedRms = 0.3e-6;
  EXPECT_NE(sentenceOf(v).find("but 1 um remain, while the calibration left 0.3"), std::string::npos)
      << sentenceOf(v);
}

}  // namespace
}  // namespace mm
