#include "diagnosis/wording.h"

#include <gtest/gtest.h>

#include <limits>

#include "diagnosis/noise_words.h"
#include "made_up_diagnosis.h"

namespace mm {
namespace {

using namespace test_support;

TEST(OddsInWords, AreWhatOneWouldSay) {
  EXPECT_EQ(oddsInWords(0.5), "even");
  EXPECT_EQ(oddsInWords(0.55), "even");
  EXPECT_EQ(oddsInWords(0.6), "3 to 2");
  EXPECT_EQ(oddsInWords(0.67), "2 to 1");
  EXPECT_EQ(oddsInWords(0.75), "3 to 1");
  EXPECT_EQ(oddsInWords(0.9), "9 to 1");
  EXPECT_EQ(oddsInWords(0.97), "about 30 to 1");
  EXPECT_EQ(oddsInWords(0.98), "about 50 to 1");
  EXPECT_EQ(oddsInWords(0.99), "about 100 to 1");
  EXPECT_EQ(oddsInWords(0.999), "about 1000 to 1");
  EXPECT_EQ(oddsInWords(0.9999), "more than 1000 to 1");
  EXPECT_EQ(oddsInWords(1.0), "more than 1000 to 1");
}

TEST(OddsInWords, BelowOneHalfTheyAreTurnedRound) {
  EXPECT_EQ(oddsInWords(0.45), "even");
  EXPECT_EQ(oddsInWords(0.4), "2 to 3");
  EXPECT_EQ(oddsInWords(0.25), "1 to 3");
  EXPECT_EQ(oddsInWords(0.03), "about 1 to 30");
  EXPECT_EQ(oddsInWords(0.0), "less than 1 to 1000");
  EXPECT_EQ(oddsInWords(std::numeric_limits<double>::quiet_NaN()), "not known");
}

TEST(OddsInWords, NeverFallWhereTheProbabilityRises) {
  double last = 0.0;
  for (int i = 500; i <= 1000; ++i) {
    const std::string text = oddsInWords(1e-3 * i);
    double ratio = 1.0, to = 1.0;
    if (text != "even") {
      const std::size_t digit = text.find_first_of("0123456789");
      ratio = std::stod(text.substr(digit));
      to = std::stod(text.substr(text.rfind(' ')));
    }
    EXPECT_GE(ratio / to, last) << text;
    last = ratio / to;
  }
}

TEST(Expanded, HasOneDigitOrTwoWhereOneWouldBeCoarse) {
  EXPECT_EQ(expanded(2.06, 0.03, "um"), "2.06 ± 0.06 um");
  EXPECT_EQ(expanded(2.0612, 0.006, "um"), "2.061 ± 0.012 um");
  EXPECT_EQ(expanded(0.31, 0.048, "um"), "0.31 ± 0.10 um");
  EXPECT_EQ(expanded(-25.4, 2.0, "arcsec"), "-25 ± 4 arcsec");
  EXPECT_EQ(expanded(1234.0, 30.0, "um/m"), "1234 ± 60 um/m");
  EXPECT_EQ(expanded(1.5, 0.0, "1"), "1.5");
  EXPECT_EQ(expanded(-1e-9, 0.06, "um"), "0.00 ± 0.12 um");
}

TEST(ErrorInWords, BelowWhatInstrumentsResolveIsNoFigure) {
  EXPECT_EQ(errorInWords(0.3e-6, false), "0.3 um");
  EXPECT_EQ(errorInWords(1.24e-11, false), "< 0.001 um");
  EXPECT_EQ(errorInWords(0.0, false), "0 um");
  EXPECT_EQ(errorInWords(1e-4 * kArcsecond, true), "< 0.001 arcsec");
}

TEST(DurationInWords, TakesTheUnitThatReadsBest) {
  EXPECT_EQ(durationInWords(40.0), "40 s");
  EXPECT_EQ(durationInWords(1200.0), "20 min");
  EXPECT_EQ(durationInWords(12600.0), "3.5 h");
  EXPECT_EQ(durationInWords(181440.0), "2.1 days");
}

TEST(EffectInWords, IsWhatTheShopCallsIt) {
  EXPECT_EQ(inWords(backlash("x")), "backlash of x");
  EXPECT_EQ(inWords(growth("z").set("lag", "true")), "thermal growth along z with bed, with lag");
  EXPECT_EQ(inWords(growth("z").set("lag", "false")), "thermal growth along z with bed");
  EXPECT_EQ(inWords(EffectSpec("straightness").set("axis", "x").set("direction", "z").set("degree", 2.0)),
            "straightness of x in z, degree 2");
  EXPECT_EQ(inWords(EffectSpec("lead_screw_periodic").set("axis", "x").set("period_mm", 2.0)),
            "periodic error of x, period 2 mm");
  EXPECT_EQ(inWords(EffectSpec("lead_screw_periodic").set("axis", "x").set("period_mm", "unknown")),
            "periodic error of x, period unknown");
  EXPECT_EQ(
      inWords(
          EffectSpec("thermal_bending").set("axis", "z").set("about", "x").setList("sensors", {"a", "b"})),
      "thermal bending of z about x with a and b");
  EXPECT_EQ(inWords(EffectSpec("profile").set("direction", "z").setList("variables", {"x", "y"})),
            "profile along z over x and y");
  // a plugin's, or one whose keys are not those of the phrase
  EXPECT_EQ(inWords(EffectSpec("friction_lever").set("axis", "x").set("across", "z")),
            "friction lever, axis x, across z");
  EXPECT_EQ(inWords(EffectSpec("speed_lag")), "trigger delay");
  EXPECT_EQ(inWords(EffectSpec("probe_lobing").set("order", 0)), "sideways pre-travel of the probe");
  EXPECT_EQ(inWords(EffectSpec("probe_lobing").set("order", 3)), "probe lobing of order 3");
  EXPECT_EQ(inWords(EffectSpec("scale")), "scale");
}

TEST(EffectInWords, ListsEndWithAnAnd) {
  const std::vector<EffectSpec> many = {backlash("x"), backlash("y"), backlash("z"), EffectSpec("speed_lag")};
  EXPECT_EQ(listInWords({many[0]}), "backlash of x");
  EXPECT_EQ(listInWords({many[0], many[1]}), "backlash of x and backlash of y");
  EXPECT_EQ(listInWords(many, 2), "backlash of x, backlash of y and 2 more");
}

TEST(Size, IsTheConstantTheAmplitudeOrTheRms) {
  CandidateResult c = play();
  EXPECT_EQ(sizeInWords(c, false), "2.06 ± 0.06 um");
  c.parameters = {{"S", "um", 3.0, 0.05}, {"K", "um", -4.0, 0.05}, {"period", "mm", 2.0, 0.01}};
  EXPECT_EQ(sizeInWords(c, false), "amplitude 5.00 ± 0.10 um");
  c.parameters = {{"amplitude", "um", 2.0, 0.1}, {"tau", "s", 600.0, 30.0}};
  EXPECT_EQ(sizeInWords(c, false), "2.00 ± 0.20 um");
  c.parameters = {{"x", "um", 2.0, 0.1}, {"y", "um", 0.1, 0.1}, {"z", "um", -1.0, 0.1}};
  EXPECT_EQ(sizeInWords(c, false), "x 2.00 ± 0.20 um, z -1.00 ± 0.20 um");
  c.parameters = {{"x", "um", 2.0, 0.1}, {"y", "um", 1e-7, 0.0}};  // y: not determined
  EXPECT_EQ(sizeInWords(c, false), "x 2.00 ± 0.20 um");
  c.parameters = {{"x", "um", 0.0, 0.1}, {"y", "um", 0.1, 0.1}};
  EXPECT_EQ(sizeInWords(c, false), "0.87 um RMS");
}

TEST(Sentence, NamesWhatIsMissing) {
  Diagnosis d = verdict(Verdict::kMissingEffect);
  d.missing = {play()};
  EXPECT_EQ(
      sentenceOf(d),
      "Missing: backlash of x, 2.06 ± 0.06 um (k = 2), odds about 1000 to 1; held-out RMS 0.93 -> 0.32 um.");
  CandidateResult heat = play();
  heat.effect = growth("z");
  heat.parameters = {{"growth", "um/K", 0.6, 0.01}};
  heat.odds = 0.97;
  d.missing.push_back(heat);
  EXPECT_EQ(sentenceOf(d),
            "Missing: backlash of x, 2.06 ± 0.06 um (k = 2), odds about 1000 to 1; thermal growth along z "
            "with bed, "
            "0.600 ± 0.020 um/K (k = 2), odds about 30 to 1; held-out RMS 0.93 -> 0.32 um.");
}

TEST(Sentence, SaysThePeriodThatWasFoundAndWhichLookTheSame) {
  Diagnosis d = verdict(Verdict::kMissingEffect);
  CandidateResult c = play();
  c.effect = EffectSpec("lead_screw_periodic").set("axis", "x").set("period_mm", "unknown");
  c.parameters = {{"S", "um", 3.0, 0.05}, {"K", "um", -4.0, 0.05}, {"period", "mm", 5.0, 0.01}};
  c.looksTheSame = "At positions 2 mm apart a period of 3.33 or 1.43 mm looks the same: measure x.";
  d.missing = {c};
  EXPECT_EQ(sentenceOf(d),
            "Missing: periodic error of x, period 5.000 ± 0.020 mm, amplitude 5.00 ± 0.10 um (k = 2), odds "
            "about 1000 to 1; held-out RMS 0.93 -> 0.32 um. At positions 2 mm apart a period of 3.33 or "
            "1.43 mm looks the same: measure x.");
}

TEST(Sentence, SaysWhatWasAssumedWhereItMattersToWhatIsNamed) {
  Diagnosis d = verdict(Verdict::kMissingEffect);
  d.missing = {play()};
  d.missingInputs = {{"direction of travel of x", "from the approach of the contact", {backlash("x")}},
                     {"direction of travel of y", "from the approach of the contact", {backlash("y")}},
                     {"speed of x", "", {EffectSpec("speed_lag")}}};
  EXPECT_NE(
      sentenceOf(d).find(". The direction of travel of x was assumed from the approach of the contact."),
      std::string::npos);
  EXPECT_EQ(sentenceOf(d).find("travel of y"), std::string::npos);
  EXPECT_EQ(sentenceOf(d).find("speed of x"), std::string::npos);
}

TEST(Sentence, ConfusableNamesTheRivalsWithTheirOdds) {
  Diagnosis d = verdict(Verdict::kConfusable);
  d.missing = {play()};
  d.missing[0].odds = 0.6;
  d.missing[0].confusableWith = {rival(EffectSpec("speed_lag"), 0.3, "touch x at two speeds")};
  EXPECT_EQ(sentenceOf(d),
            "Either backlash of x (2.06 ± 0.06 um, k = 2; odds 3 to 2) or trigger delay (1 to 2): these data "
            "do not "
            "separate them. Held-out RMS 0.93 -> 0.32 um.");
  d.nextMeasurement.resize(1);
  EXPECT_NE(
      sentenceOf(d).find("trigger delay (1 to 2): these data do not separate them; the listed moves would."),
      std::string::npos);
}

TEST(Sentence, MovesThatDoNotSeparateAreNotSaidToDoSo) {
  Diagnosis d = verdict(Verdict::kConfusable);
  d.missing = {play()};
  d.missing[0].odds = 0.5;
  d.missing[0].confusableWith = {rival(EffectSpec("speed_lag"), 0.3, "a"), rival(growth("y"), 0.2, "b")};
  d.nextMeasurement.resize(1);
  const auto moves = [&](int first, int second) {
    d.missing[0].confusableWith[0].repeats = first;
    d.missing[0].confusableWith[1].repeats = second;
    const std::string text = sentenceOf(d), from = "do not separate them";
    const std::size_t begin = text.find(from) + from.size();
    return text.substr(begin, text.find('.', begin) - begin);
  };
  EXPECT_EQ(moves(1, 1), "; the listed moves would");
  EXPECT_EQ(moves(1, 12), "; the listed moves would, measured 12 times");
  EXPECT_EQ(moves(1, 0), "; the listed moves would separate only trigger delay");
  EXPECT_EQ(moves(4, 0), "; the listed moves would, measured 4 times, separate only trigger delay");
  EXPECT_EQ(moves(0, 0), "");
}

TEST(Sentence, NoiseFarBelowWhatWasDeclaredIsNotAtIt) {
  Diagnosis d = verdict(Verdict::kExplained);
  EXPECT_NE(sentenceOf(d).find(", at the repeatability of 0.3 um (declared)"), std::string::npos);
  d.base.repeatability = 300e-6;
  EXPECT_NE(sentenceOf(d).find(", far below the repeatability of 300 um (declared)"), std::string::npos)
      << sentenceOf(d);
}

TEST(Moves, AreSaidToSeparateWhereAPracticableNumberOfRepeatsDoes) {
  EXPECT_EQ(repeatsOfMoves(3.0, 12), 1);
  EXPECT_EQ(movesInWords(4.0, 12), "the 12 proposed moves differ by 4 standard deviations");
  EXPECT_EQ(repeatsOfMoves(1.0, 12), 9);
  EXPECT_NE(movesInWords(1.0, 12).find(": measure them 9 times"), std::string::npos) << movesInWords(1.0, 12);
  for (const double little : {0.1, 0.0}) {
    EXPECT_EQ(repeatsOfMoves(little, 12), 0);
    const std::string text = movesInWords(little, 12);
    EXPECT_NE(text.find("no practicable number of repeats"), std::string::npos) << text;
    EXPECT_EQ(text.find("proposed"), std::string::npos) << text;
  }
  EXPECT_EQ(repeatsOfMoves(4.0, 0), 0);
}

TEST(Sentence, ConfusableBesideWhatIsSure) {
  Diagnosis d = verdict(Verdict::kConfusable);
  CandidateResult heat = play();
  heat.effect = growth("z");
  heat.confusableWith = {rival(growth("y"), 0.3, "measure at another temperature")};
  d.missing = {play(), heat};
  EXPECT_EQ(
      sentenceOf(d).find("Missing: backlash of x, 2.06 ± 0.06 um (k = 2), odds about 1000 to 1. In addition "
                         "either thermal growth along z with bed"),
      0u);
}

TEST(Sentence, ConfusableWithWhatWasNotRecorded) {
  Diagnosis d = verdict(Verdict::kConfusable);
  d.missing = {play()};
  d.missing[0].effect = EffectSpec("probe_radius");
  Confusable hidden = rival(backlash("x"), 0.4);
  hidden.notRecorded = "direction of travel of x";
  d.missing[0].confusableWith = {hidden};
  EXPECT_EQ(
      sentenceOf(d),
      "Missing: effective radius of the probe tip, 2.06 ± 0.06 um (k = 2), odds about 1000 to 1; held-out "
      "RMS "
      "0.93 -> 0.32 um. Backlash of x cannot be excluded: the direction of travel of x was not recorded.");
}

TEST(Sentence, OneErrorInTwoFramesIsNoMatterForMoves) {
  Diagnosis d = verdict(Verdict::kConfusable);
  d.missing = {play()};
  d.missing[0].effect = EffectSpec("rotary_zero").set("joint", "pan");
  Confusable same = rival(EffectSpec("rotary_axis_tilt").set("joint", "pan").set("about", "z"), 0.5);
  same.same = true;
  d.missing[0].confusableWith = {same};
  d.nextMeasurement.resize(1);
  const std::string text = sentenceOf(d);
  EXPECT_NE(text.find("Zero of pan and tilt of the axis of pan about z do the same wherever measurements of "
                      "this kind reach: none separates them."),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("moves"), std::string::npos) << text;
}

TEST(Sentence, AnUnknownEffectIsACurveAndAFormulaOnlyWhereThereIsOne) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  d.profiles = {bump()};
  EXPECT_EQ(sentenceOf(d),
            "An error along z that depends on x, and that no effect of the catalogue explains: up to "
            "0.91 ± 0.20 um (k = 2) at x = -16 mm, odds more than 1000 to 1; held-out RMS 0.93 -> 0.32 um. "
            "Add it as a profile, or look for its cause.");
  d.formulas = {{EffectSpec("formula").set("direction", "z").set("formula", "k1*x^2"), {}, 0.93e-6, 0.33e-6}};
  EXPECT_NE(sentenceOf(d).find("The formula k1*x^2 along z describes it as well."), std::string::npos);
  d.missing = {play()};
  d.missing[0].gain = d.profiles[0].gain - 1.0;
  EXPECT_NE(sentenceOf(d).find("Found on the way: backlash of x, 2.06"), std::string::npos);
  d.missing[0].gain = d.profiles[0].gain + 1.0;  // what does more comes first
  EXPECT_EQ(sentenceOf(d).find("Missing: backlash of x, 2.06"), 0u);
  EXPECT_NE(sentenceOf(d).find(". In addition an error along z that depends on x"), std::string::npos);
}

TEST(Sentence, UnknownWithoutACurveSaysOnWhatItDepends) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  d.where = {{"x", 0.4, 1e-9, 0.4, 1e-9},
             {"temperature bed", 0.3, 1e-7, 0.0, 0.5},
             {"time", 0.2, 1e-5, 0.1, 1e-4},
             {"y", 0.1, 0.2, 0.0, 1.0}};
  EXPECT_EQ(sentenceOf(d),
            "Structure is left that no effect of the catalogue explains; it depends on x, time. Look for its "
            "cause.");
}

TEST(Sentence, ScatterIsSaidAgainstTheRepeatability) {
  Diagnosis d = verdict(Verdict::kScatter);
  d.noise = 0.93e-6;
  d.noiseStd = 0.02e-6;
  EXPECT_EQ(sentenceOf(d),
            "No effect and no structure is left, but the scatter of 0.93 ± 0.04 um (k = 2) is 3.1 times the "
            "repeatability of 0.3 um (declared): either that is stated too small, or an influence acts that "
            "is unrelated to anything recorded. Touch one point twenty times to decide between the two.");
  d.base.repeatabilityFrom = "estimated";
  EXPECT_EQ(
      sentenceOf(d),
      "No effect and no structure is left in the scatter of 0.93 ± 0.04 um (k = 2), but the repeatability is "
      "not known. Touch one point twenty times, then diagnose again with their standard deviation as "
      "--repeatability-um.");
}

TEST(Sentence, ExplainedSaysWhatIsLeftAndHowItDrifts) {
  Diagnosis d = verdict(Verdict::kExplained);
  EXPECT_EQ(
      sentenceOf(d),
      "Nothing is missing: no effect and no structure is left but noise of 0.310 ± 0.016 um (k = 2), at the "
      "repeatability of 0.3 um (declared).");
  d.drift = {wander()};
  EXPECT_EQ(
      sentenceOf(d),
      "No effect and no structure is left but drift and noise of 0.310 ± 0.016 um (k = 2), at the "
      "repeatability of 0.3 um (declared). Drift: x drifts by 0.4 um RMS with a time constant of 20 min "
      "and follows nothing recorded.");
  d.drift[0].perhaps = {{growth("x"), 0.3, 0.7}};
  EXPECT_NE(
      sentenceOf(d).find("time constant of 20 min; perhaps thermal growth along x with bed, odds 1 to 2."),
      std::string::npos)
      << sentenceOf(d);
}

TEST(Sentence, DoesNotSayThatNothingIsMissingWhereACauseCannotBeExcluded) {
  Diagnosis d = verdict(Verdict::kExplained);
  d.possible = {{backlash("x"), 0.75, "The same positions reached in both directions of x."},
                {growth("z"), 0.2, "Other temperatures."}};
  EXPECT_EQ(
      sentenceOf(d),
      "No effect is established beside noise of 0.310 ± 0.016 um (k = 2), at the repeatability of 0.3 um "
      "(declared). Backlash of x (odds 3 to 1) and thermal growth along z with bed (odds 1 to 4) cannot "
      "be excluded. To decide, measure: The same positions reached in both directions of x.");
  for (const Verdict what : {Verdict::kExplained, Verdict::kScatter})
    for (const bool drifts : {false, true}) {
      d.verdict = what;
      d.drift = drifts ? std::vector<DriftResult>{wander()} : std::vector<DriftResult>{};
      const std::string text = sentenceOf(d);
      EXPECT_EQ(text.find("Nothing is missing"), std::string::npos) << text;
      EXPECT_EQ(text.find("No effect and no structure"), std::string::npos) << text;
      EXPECT_NE(text.find("Backlash of x (odds 3 to 1)"), std::string::npos) << text;
    }
}

TEST(Sentence, SaysWhatRemainsWhereTheNamedCauseIsTheSmallerPart) {
  Diagnosis d = verdict(Verdict::kMissingEffect);
  d.missing = {play()};
  d.noise = 0.1e-6;
  d.heldOut = 0.32e-6;
  const std::string named = "held-out RMS 0.93 -> 0.32 um.";
  const auto after = [&] { return sentenceOf(d).substr(sentenceOf(d).find(named) + named.size()); };
  EXPECT_EQ(after(),
            " What remains is 3.2 times the noise: its cause is not known; add what was found, then diagnose "
            "again.");
  d.drift = {wander()};
  ArtifactScatter form;
  form.what = "form";
  form.std = 0.2e-6;
  d.artifactScatter = {form};
  EXPECT_EQ(after(),
            " What remains is 3.2 times the noise: x drifts by 0.4 um RMS with a time constant of 20 min and "
            "follows nothing recorded; the form of the balls scatters by 0.2 um RMS.");
  d.noise = 0.11e-6;
  EXPECT_EQ(after(), "");
}

TEST(Sentence, OddsAreKnownNoBetterThanTheSearchesAgree) {
  const std::string doubt =
      " Two searches differ by up to 0.17 in a probability: these odds are known no better.";
  for (const Verdict what :
       {Verdict::kMissingEffect, Verdict::kUnknownEffect, Verdict::kExplained, Verdict::kScatter}) {
    Diagnosis d = verdict(what);
    d.chainsDiffer = 0.162;
    EXPECT_EQ(sentenceOf(d).find(doubt), std::string::npos) << "no odds are told";
    (what == Verdict::kMissingEffect ? d.missing : d.candidates) = {play()};
    d.possible = {{growth("z"), 0.2, "Other temperatures."}};
    EXPECT_NE(sentenceOf(d).find(doubt), std::string::npos) << sentenceOf(d);
    d.chainsDiffer = 0.0;
    EXPECT_EQ(sentenceOf(d).find("Two searches"), std::string::npos);
  }
}

TEST(Sentence, WhatIsFoundBesideACurveHasItsRivals) {
  Diagnosis d = verdict(Verdict::kUnknownEffect);
  d.profiles = {bump()};
  d.missing = {play()};
  d.missing[0].gain = 1.0;
  d.missing[0].odds = 0.67;
  d.missing[0].confusableWith = {rival(EffectSpec("speed_lag"), 0.3)};
  const std::string text = sentenceOf(d);
  EXPECT_NE(text.find("either backlash of x"), std::string::npos) << text;
  EXPECT_NE(text.find("or trigger delay (1 to 2)"), std::string::npos) << text;
}

TEST(Sentence, AnglesAreInArcseconds) {
  Diagnosis d = verdict(Verdict::kExplained);
  d.angular = true;
  d.base.repeatability = 2.0 * kArcsecond;
  d.noise = 2.2 * kArcsecond;
  d.noiseStd = 0.05 * kArcsecond;
  d.drift = {{"pan", 5.0 * kArcsecond, 7200.0, {}, ""}};
  const std::string text = sentenceOf(d);
  EXPECT_NE(text.find("noise of 2.20 ± 0.10 arcsec"), std::string::npos) << text;
  EXPECT_NE(text.find("pan drifts by 5 arcsec RMS with a time constant of 2 h"), std::string::npos) << text;
}

TEST(Sentence, InsufficientDataSaysWhatToDo) {
  EXPECT_EQ(sentenceOf(verdict(Verdict::kInsufficientData)),
            "The model cannot be fitted to this session: measure more, or take effects out of the model.");
}

TEST(Drift, TheAdviceIsAQuarterOfItsTime) {
  DriftResult d = wander();
  EXPECT_NE(driftAdvice(d).find("every 5 min"), std::string::npos);
  d.perhaps = {{growth("x"), 0.3, 0.7}};
  EXPECT_NE(driftAdvice(d).find("at other temperatures that do not simply rise or fall with time"),
            std::string::npos);
}

}  // namespace
}  // namespace mm
