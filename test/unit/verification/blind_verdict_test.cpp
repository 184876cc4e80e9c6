// Verdicts on figures that are made by hand: no session, no machine.
#include "verification/blind_verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <map>

#include "random_numbers.h"
#include "report/blind_page.h"
#include "verification/trial_orders.h"

namespace mm {
namespace {

using test_support::RandomNumbers;

constexpr const char* kOrder = "ABBABAABAB";

/// What the blocks show of a trial in which B corrects.
struct Situation {
  const char* name;
  double gain;                         // share of the whole correction that arrives
  double rmsOff, rmsOn;                // um
  double scatter;                      // of the gain; of the logarithm of the RMS
  std::map<std::string, double> axes;  // gain of each
  TrialVerdict verdict;
  const char* said;  // in the sentence
};

std::vector<TrialBlockFigures> blocksOf(const std::string& order, const Situation& s) {
  std::vector<TrialBlockFigures> blocks;
  RandomNumbers random(5);
  for (const char state : order) {
    const bool on = state == 'B';
    TrialBlockFigures block;
    block.number = static_cast<int>(blocks.size()) + 1;
    block.state = state;
    block.time = 300.0 * block.number;
    block.measurements = 54;
    block.remaining = 1.0 - (on ? s.gain : 0.0) + random.normal(s.scatter);
    block.rms = 1e-6 * (on ? s.rmsOn : s.rmsOff) * std::exp(random.normal(s.scatter));
    for (const auto& [axis, gain] : s.axes)
      block.ofAxis[axis] = 1.0 - (on ? gain : 0.0) + random.normal(2.0 * s.scatter);
    blocks.push_back(block);
  }
  return blocks;
}

OpenedTrial openedB(const std::string& order, const Situation& s) {
  return opened(compareStates(blocksOf(order, s)), 'B', false);
}

TEST(BlindVerdict, SaysOfEachSituationWhatItIs) {
  const std::vector<Situation> situations = {
      {"all of it", 1.0, 4.0, 1.0, 0.02, {{"x", 1.0}, {"y", 1.0}}, TrialVerdict::kHelped, "it helped: RMS"},
      {"a tenth is missing", 0.9, 4.0, 1.2, 0.02, {}, TrialVerdict::kHelped, "it helped: RMS"},
      {"two of three axes reversed",
       0.64,
       4.0,
       2.8,
       0.02,
       {{"x", 1.0}, {"y", -1.0}, {"z", -1.0}},
       TrialVerdict::kWrongSign,
       "the sign is wrong for y, z: RMS"},
      {"one of two reversed, nothing in sum",
       0.0,
       4.0,
       4.0,
       0.02,
       {{"x", 1.0}, {"y", -1.0}},
       TrialVerdict::kWrongSign,
       "the sign is wrong for y: RMS"},
      {"all reversed",
       -1.0,
       4.0,
       8.0,
       0.02,
       {{"x", -1.0}, {"y", -1.0}},
       TrialVerdict::kWrongSign,
       "the wrong sign: RMS"},
      {"more reversed than right", -0.45, 4.0, 5.5, 0.02, {}, TrialVerdict::kWrongSign, "in part: RMS"},
      {"part of it", 0.64, 4.0, 2.0, 0.02, {}, TrialVerdict::kHelpedInPart, "in part: 0.6"},
      {"one small axis is missing",
       0.92,
       4.0,
       1.3,
       0.02,
       {{"x", 1.0}, {"y", 0.0}},
       TrialVerdict::kHelpedInPart,
       "mm verify --loaded says which axis"},
      {"one small axis arrives",
       0.2,
       4.0,
       3.8,
       0.02,
       {{"x", 0.0}, {"y", 1.0}},
       TrialVerdict::kHelpedInPart,
       "(x -0.0"},
      {"twice", 2.0, 4.0, 4.0, 0.02, {}, TrialVerdict::kOvercorrected, "applied 2.0 times"},
      {"three halves", 1.5, 4.0, 2.0, 0.02, {}, TrialVerdict::kOvercorrected, "applied 1.5 times"},
      {"nothing", 0.0, 4.0, 4.0, 0.02, {{"x", 0.0}, {"y", 0.0}}, TrialVerdict::kDidNothing, "it did nothing"},
      {"other errors are larger",
       1.0,
       4.0,
       4.0,
       0.05,
       {},
       TrialVerdict::kCannotTell,
       "other errors are larger at these points"},
      {"worse", 0.0, 4.0, 6.0, 0.02, {}, TrialVerdict::kWorse, "it made it worse"},
      {"too small for the scatter",
       0.3,
       4.0,
       4.0,
       2.0,
       {},
       TrialVerdict::kCannotTell,
       "too small for the scatter"}};
  for (const Situation& s : situations) {
    const OpenedTrial found = openedB(kOrder, s);
    EXPECT_EQ(nameOf(found.verdict), nameOf(s.verdict)) << s.name << ": " << found.inWords;
    EXPECT_NE(found.inWords.find(s.said), std::string::npos) << s.name << ": " << found.inWords;
    EXPECT_EQ(found.axes.size(), s.axes.size()) << s.name;
  }
}

TEST(BlindVerdict, AStateThatWasNotMeasuredHasNoFigures) {
  const Situation helps{"", 1.0, 4.0, 1.0, 0.02, {}, TrialVerdict::kCannotTell, ""};
  BlindReport report;
  report.blocks.blocks = blocksOf("AAAA", helps);
  report.labelled = compareStates(report.blocks.blocks);
  report.on = 'B';
  report.opened = opened(report.labelled, report.on, false);
  EXPECT_EQ(report.opened.verdict, TrialVerdict::kCannotTell);
  EXPECT_EQ(report.opened.inWords, "cannot tell: state B was not measured");
  EXPECT_TRUE(std::isnan(report.opened.with.value));
  EXPECT_NE(blindJson(report).find("\"value\": null"), std::string::npos);
  EXPECT_NE(blindPage(report).find("RMS of the residuals with it</td><td class=\"n\">–</td>"),
            std::string::npos);
}

TEST(BlindVerdict, ThePageSaysWhatIsNotJudgedAndNoChanceThatFewBlocksCannotShow) {
  const Situation helps{"", 1.0, 4.0, 1.0, 0.02, {{"x", 1.0}, {"y", 1.0}}, TrialVerdict::kHelped, ""};
  const auto pageOf = [&](const std::string& order) {
    BlindReport report;
    report.blocks.blocks = blocksOf(order, helps);
    report.blocks.fittedPose = true;
    report.blocks.notJudged = "Shifts and turns of the whole artifact are not judged: each block fits them";
    report.labelled = compareStates(report.blocks.blocks);
    report.on = 'B';
    report.opened = opened(report.labelled, report.on, false);
    EXPECT_NE(blindText(report).find(report.blocks.notJudged), std::string::npos);
    return blindPage(report);
  };
  const std::string ten = pageOf(kOrder), six = pageOf("ABBABA");
  for (const std::string& page : {ten, six}) {
    EXPECT_NE(page.find("Shifts and turns of the whole artifact are not judged"), std::string::npos);
    EXPECT_NE(page.find("RMS about the fitted pose with it"), std::string::npos);
    EXPECT_NE(page.find("gain of y"), std::string::npos);
  }
  EXPECT_NE(ten.find("At most 1 %"), std::string::npos);
  EXPECT_EQ(six.find("At most 1 %"), std::string::npos);
}

TEST(BlindVerdict, WithABlockMissingTheSmallestPIsThatOfOneOrder) {
  const Situation clear{"", 1.0, 4.0, 0.4, 0.01, {}, TrialVerdict::kHelped, ""};
  for (const char* order : {"ABBABAABA", "ABBABAABAB"}) {
    const LabelledTrial trial = compareStates(blocksOf(order, clear));
    EXPECT_NEAR(trial.remaining.p, trial.smallestP, 1e-12) << order;
  }
  double orders = 0.0;
  forEachOrder("ABBABAABA", [&](const std::string&) { ++orders; });
  EXPECT_NEAR(smallestP("ABBABAABA"), 1.0 / orders, 1e-12);
}

/// Corrected blocks scatter by the noise alone, the others by what the machine does.
TEST(BlindVerdict, IntervalsCoverWhereTheStatesScatterDifferently) {
  constexpr int kTrials = 2000;
  const std::string order = kOrder;
  for (const double ratio : {1.0, 10.0}) {
    RandomNumbers random(static_cast<std::uint64_t>(ratio) + 3);
    int a = 0, b = 0, step = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<TrialBlockFigures> blocks;
      for (std::size_t i = 0; i < order.size(); ++i) {
        TrialBlockFigures block;
        block.state = order[i];
        block.time = static_cast<double>(i);
        const bool on = order[i] == 'B';
        const double logarithm =
            (on ? -1.0 : 1.0) + 0.1 * (block.time - 4.5) + random.normal(on ? 0.03 : 0.03 * ratio);
        block.rms = std::exp(logarithm);
        blocks.push_back(block);
      }
      const StatesCompared found = compareStates(blocks).logRms;
      a += std::abs(found.a - 1.0) < found.aHalf ? 1 : 0;
      b += std::abs(found.b + 1.0) < found.bHalf ? 1 : 0;
      step += std::abs(found.difference + 2.0) < found.half ? 1 : 0;
    }
    std::cout << "scatter 1 to " << ratio << ": of " << kTrials << " levels of A " << a << ", of B " << b
              << ", steps " << step << " are covered\n";
    for (const int covered : {a, b, step}) EXPECT_GE(covered, 0.982 * kTrials) << ratio;
  }
}

}  // namespace
}  // namespace mm
