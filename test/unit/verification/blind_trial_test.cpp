#include "verification/blind_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "loaded_controller.h"
#include "long_tests.h"
#include "plate_rows.h"
#include "random_numbers.h"
#include "read_contacts.h"
#include "session/artifact_file.h"
#include "session/trial_block.h"
#include "session_files.h"
#include "verification/blind_verdict.h"
#include "verification/trial_orders.h"

namespace mm {
namespace {

using namespace test;  // NOLINT: helpers of this test alone
using test_support::RandomNumbers;

// -- What is true, written by hand: errors of a machine in mm, by position in mm and direction of travel.

struct Cause {
  const char* effect;  // what the calibration is fitted with
  Eigen::Vector3d (*error)(const Eigen::Vector3d& p, const Eigen::Vector3d& travel);  // RMS about 1
};

const std::vector<Cause>& causes() {
  static const std::vector<Cause> all = {
      {"{type: scale, axis: x}",
       [](const Eigen::Vector3d& p, const Eigen::Vector3d&) { return Eigen::Vector3d(p.x() / 6.0, 0, 0); }},
      {"{type: squareness, axis: y, of: x}",
       [](const Eigen::Vector3d& p, const Eigen::Vector3d&) { return Eigen::Vector3d(p.y() / 8.0, 0, 0); }},
      {"{type: backlash, axis: y}",
       [](const Eigen::Vector3d&, const Eigen::Vector3d& travel) {
         return Eigen::Vector3d(0, travel.y() > 0.0 ? 1.7 : -1.7, 0);
       }},
      {"{type: straightness, axis: y, direction: z, degree: 2}",
       [](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
         return Eigen::Vector3d(0, 0, std::pow((p.y() - 10.0) / 14.0, 2));
       }},
      {"{type: scale, axis: z}",
       [](const Eigen::Vector3d& p, const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, p.z() / 4.0); }}};
  return all;
}

/// What a machine does to the tip, mm: `size` of its cause, of which the controller takes `taken`.
struct Truth {
  const Cause* cause = nullptr;
  double size = 0.0;                        // mm
  double taken = 0.0;                       // share
  Eigen::Vector3d lies{0.05, -0.03, 0.02};  // where the plate lies
};

/// Touches of the nine balls, one after the other, as rows of a table. @param time s, of the first.
std::string touches(const Truth& truth, int perBall, double time, const std::string& placement,
                    RandomNumbers& random) {
  std::string csv;
  const auto centres = plateCentres();
  for (int k = 0; k < perBall; ++k)
    for (std::size_t b = 0; b < centres.size(); ++b) {
      const double z = 1.0 - 1.2 * (k + 0.5) / perBall, s = std::sqrt(1.0 - z * z);
      const double azimuth = 2.39996 * k + 0.7 * static_cast<double>(b);
      const Eigen::Vector3d n(s * std::cos(azimuth), s * std::sin(azimuth), z);
      const Eigen::Vector3d tip = centres[b] + truth.lies + (4.9685 + random.normal(3e-4)) * n;
      const Eigen::Vector3d p = tip - truth.size * (1.0 - truth.taken) * truth.cause->error(tip, -n);
      csv += format("%.3f,%.7f,%.7f,%.7f,b%zu,%.5f,%.5f,%.5f,%s\n", time, p.x(), p.y(), p.z(), b,
                    -2.0 * n.x(), -2.0 * n.y(), -2.0 * n.z(), placement.c_str());
      time += 8.0;
    }
  return csv;
}

Session sessionOf(const std::string& rows) {
  const Folder folder;
  const Artifact plate = parseArtifact(plateArtifact(), "plate.yaml");
  return readContactsCsv(
      folder.write(
          "trial.csv",
          "time_s,x_mm,y_mm,z_mm,feature,x_velocity_mm_s,y_velocity_mm_s,z_velocity_mm_s,placement\n" + rows),
      Machine::load("three_axis"), &plate);
}

CalibrateOptions quick() {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.threads = 1;
  return options;
}

/// A machine as it was calibrated, and a trial with it.
struct HandTrial {
  Truth truth;
  Calibration calibration;
  TrialKey key;
  RandomNumbers random;

  HandTrial(int seed, double size) : random(static_cast<std::uint64_t>(seed)) {
    truth.cause = &causes()[static_cast<std::size_t>(seed) % causes().size()];
    truth.size = size;
    const Session before = sessionOf(touches(truth, 20, 0.0, "", random));
    calibration =
        recalibrate(before, parseModelSpec(std::string("effects: [") + truth.cause->effect + "]", "m"),
                    quick())
            .calibration;
    const Plan plan = Plan::parse(loadedPlan(2), "plan.yaml", ".", before.machine);
    std::vector<std::size_t> moves;
    plannedSession(plan, before.machine, &moves);
    TrialSettings settings;
    settings.seed = static_cast<std::uint64_t>(seed);
    key = blindTrial(plan, before.machine, moves, "trial", settings).key;
  }

  /// @param gain share of the correction that arrives when it is on. @param blocks from 1; those that are
  /// measured, in that order. The plate wanders by 2 um a block, the machine's error drifts by a fifth over
  /// the trial and scatters by 3 %.
  std::string rows(double gain, const std::vector<int>& blocks) {
    std::string csv;
    Truth now = truth;
    const double drift = random.uniform(-0.2, 0.2);
    double time = 0.0;
    for (const int number : blocks) {
      const char state = key.order[static_cast<std::size_t>(number) - 1];
      const double worn = 1.0 + drift * time / 5000.0 + random.normal(0.03);
      now.size = truth.size * worn;
      now.taken = state == key.on ? gain / worn : 0.0;
      for (int k = 0; k < 3; ++k) now.lies[k] += random.normal(0.002);
      csv += touches(now, 6, time, nameOf({key.trial, number, static_cast<int>(key.order.size()), state}),
                     random);
      time += 500.0;
    }
    return csv;
  }
  std::string rows(double gain) {
    std::vector<int> all;
    for (std::size_t b = 1; b <= key.order.size(); ++b) all.push_back(static_cast<int>(b));
    return rows(gain, all);
  }

  OpenedTrial judge(const Session& session) const {
    return opened(compareStates(trialBlocks(session, calibration, quick()).blocks), key.on, false);
  }
};

TEST(BlindTrial, fortyTrialsAreJudgedRightly) {
  const int runs = mm_test::longTests() ? 200 : 13;
  const std::map<std::string, std::pair<double, TrialVerdict>> situations = {
      {"helped", {1.0, TrialVerdict::kHelped}},
      {"nothing", {0.0, TrialVerdict::kDidNothing}},
      {"wrong sign", {-1.0, TrialVerdict::kWrongSign}}};
  int falseOnes = 0, all = 0;
  for (const auto& [name, situation] : situations) {
    const auto [gain, right] = situation;
    int said = 0, open = 0, gainCovered = 0;
    for (int run = 0; run < runs; ++run) {
      RandomNumbers sizes(static_cast<std::uint64_t>(run) + 77);
      HandTrial trial(1000 + run, sizes.logarithmic(0.3e-3, 6e-3));
      const OpenedTrial found = trial.judge(sessionOf(trial.rows(gain)));
      said += found.verdict == right ? 1 : 0;
      open += found.verdict == TrialVerdict::kCannotTell ? 1 : 0;
      gainCovered += found.gain.lower <= gain && gain <= found.gain.upper ? 1 : 0;
      if (found.verdict == right || found.verdict == TrialVerdict::kCannotTell) continue;
      ++falseOnes;
      std::cout << name << ", run " << run << ": " << nameOf(found.verdict) << ", " << found.inWords << '\n';
    }
    all += runs;
    std::cout << name << ": " << said << " of " << runs << " said rightly, " << open
              << " cannot tell, gain within its 99 % interval in " << gainCovered << '\n';
    EXPECT_GE(said, 0.8 * runs) << name;
    EXPECT_GE(gainCovered, 0.95 * runs - 1.0) << name;
  }
  EXPECT_LE(falseOnes, 0.01 * all) << "of " << all;
}

/// The rows with those of `second` between the first and the other rows of a block. @param share of its rows
/// that come before. Times stay in order.
std::string interrupted(const std::string& rows, const std::string& block, const std::string& second,
                        double share) {
  std::vector<std::string> first, between, all, times;
  std::istringstream lines(rows);
  for (std::string line; std::getline(lines, line);) {
    times.push_back(line.substr(0, line.find(',')));
    line = line.substr(line.find(','));
    const bool of = line.find(" " + block + " of ") != std::string::npos;
    const bool other = line.find(" " + second + " of ") != std::string::npos;
    (of ? first : other ? between : all).push_back(line);
  }
  first.insert(first.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(first.size())),
               between.begin(), between.end());
  all.insert(all.begin(), first.begin(), first.end());
  std::string text;
  for (std::size_t i = 0; i < all.size(); ++i) text += times[i] + all[i] + "\n";
  return text;
}

TEST(BlindTrial, aBlockInPiecesIsNamedSo) {
  HandTrial trial(3, 4e-3);
  const std::string rows = trial.rows(1.0);
  const auto remarks = [&](double share) {
    const Session session = sessionOf(interrupted(rows, "block 1", "block 2", share));
    return trialBlocks(session, trial.calibration, quick()).remarks;
  };
  EXPECT_EQ(remarks(0.5),
            (std::vector<std::string>{"block 1 was measured in pieces and counts, as the mean"}));
  EXPECT_EQ(remarks(0.2),
            (std::vector<std::string>{"block 1 was measured in pieces; 10 of its 54 measurements "
                                      "are a piece of too few and are left out"}));
  const TrialBlocks found = trialBlocks(sessionOf(rows), trial.calibration, quick());
  EXPECT_EQ(found.notJudged, "Shifts and turns of the whole artifact are not judged: each block fits them");
  EXPECT_TRUE(found.fittedPose);
}

TEST(BlindTrial, whatIsMissingOrDoubledIsSaid) {
  HandTrial trial(3, 4e-3);
  const Session aborted = sessionOf(trial.rows(1.0, {1, 2, 3, 4, 5, 6, 7, 8}));
  TrialBlocks found = trialBlocks(aborted, trial.calibration, quick());
  EXPECT_EQ(found.blocks.size(), 8U);
  EXPECT_EQ(found.planned, 10);
  EXPECT_EQ(found.remarks,
            (std::vector<std::string>{"block 9 was not measured", "block 10 was not measured"}));
  EXPECT_EQ(trial.judge(aborted).verdict, TrialVerdict::kHelped);

  const Session twice = sessionOf(trial.rows(1.0, {1, 2, 3, 4, 2, 5, 6, 7, 8, 9, 10}));
  found = trialBlocks(twice, trial.calibration, quick());
  ASSERT_EQ(found.remarks.size(), 1U);
  EXPECT_NE(found.remarks[0].find("block 2 was measured more than once"), std::string::npos);
  const auto doubled = std::find_if(found.blocks.begin(), found.blocks.end(),
                                    [](const TrialBlockFigures& b) { return b.number == 2; });
  ASSERT_NE(doubled, found.blocks.end());
  EXPECT_EQ(doubled->measurements, 2 * found.blocks[0].measurements);
  EXPECT_EQ(trial.judge(twice).verdict, TrialVerdict::kHelped);

  const Session few = sessionOf(trial.rows(1.0, {1, 2, 3}));
  const OpenedTrial tooFew = trial.judge(few);
  EXPECT_EQ(tooFew.verdict, TrialVerdict::kCannotTell);
  EXPECT_NE(tooFew.inWords.find("3 blocks are too few"), std::string::npos) << tooFew.inWords;
}

TEST(BlindTrial, ordersAreBalancedAndDoNotFollowTime) {
  std::map<std::string, int> drawn;
  const Machine machine = Machine::load("three_axis");
  const Plan plan = Plan::parse(loadedPlan(2), "plan.yaml", ".", machine);
  std::vector<std::size_t> moves;
  plannedSession(plan, machine, &moves);
  int onInA = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    TrialSettings settings;
    settings.seed = seed;
    const BlindTrial trial = blindTrial(plan, machine, moves, "trial", settings);
    ++drawn[trial.key.order];
    onInA += trial.key.on == 'A' ? 1 : 0;
    EXPECT_EQ(std::count(trial.key.order.begin(), trial.key.order.end(), 'A'), 5);
    EXPECT_LE(std::abs(correlationWithTime(trial.key.order)), 0.5);
    EXPECT_EQ(trial.plan.find("correction_on"), std::string::npos);
    const TrialKey read = parseKey(keyYaml(trial.key), "key");
    EXPECT_EQ(read.order + read.on + read.trial, trial.key.order + trial.key.on + trial.key.trial);
    EXPECT_EQ(read.seed, seed);
  }
  EXPECT_GT(drawn.size(), 40U);
  EXPECT_GT(onInA, 15);
  EXPECT_LT(onInA, 45);
  // 252 balanced orders of ten, less the 38 that follow time more than by 0.5: counted by rank sums.
  EXPECT_NEAR(smallestP("ABBABAABAB"), 2.0 / 214.0, 1e-12);
  EXPECT_NEAR(correlationWithTime("AAABBB"), -std::sqrt(27.0 / 35.0), 1e-12);
  TrialSettings odd;
  odd.blocks = 9;
  EXPECT_THROW(blindTrial(plan, machine, moves, "trial", odd), InputError);
}

TEST(BlindTrial, aKeyFitsItsPlanAlone) {
  const TrialKey key{"0123abcd", "ABBABA", 'B', 5};
  const auto names = [](const std::string& trial, char third) {
    return std::vector<std::string>{nameOf({trial, 1, 6, 'A'}), "one.bag: " + nameOf({trial, 3, 6, third})};
  };
  checkKey(key, names("0123abcd", 'B'), "s.bag", "k.yaml");
  EXPECT_THROW(checkKey(key, names("0123abce", 'B'), "s.bag", "k.yaml"), InputError);
  EXPECT_THROW(checkKey(key, names("0123abcd", 'A'), "s.bag", "k.yaml"), InputError);
  EXPECT_THROW(checkKey(key, {"turned"}, "s.bag", "k.yaml"), InputError);
  EXPECT_THROW(parseKey("trial: \"0123abcd\"\norder: ABC\ncorrection_on: A\nseed: 1\n", "k.yaml"),
               InputError);
  const std::optional<TrialBlock> block = trialBlock("one.bag: trial 0123abcd block 3 of 6 state B: turned");
  ASSERT_TRUE(block);
  EXPECT_EQ(block->number, 3);
  EXPECT_EQ(block->state, 'B');
  EXPECT_EQ(block->placement, "turned");
  EXPECT_FALSE(trialBlock("block 3 of 6"));
}

TEST(BlindTrial, theKeyOnlyMapsTheStates) {
  std::vector<TrialBlockFigures> blocks;
  const std::string order = "ABBABAABAB";
  RandomNumbers random(4);
  for (std::size_t i = 0; i < order.size(); ++i) {
    TrialBlockFigures block;
    block.number = static_cast<int>(i) + 1;
    block.state = order[i];
    block.time = 100.0 * static_cast<double>(i);
    const bool corrected = order[i] == 'B';
    block.remaining = (corrected ? 0.1 : 1.0) + 0.04 * static_cast<double>(i) + random.normal(0.02);
    block.rms = (corrected ? 1e-6 : 4e-6) * std::exp(random.normal(0.03));
    blocks.push_back(block);
  }
  const LabelledTrial labelled = compareStates(blocks);
  const OpenedTrial ofB = opened(labelled, 'B', false), ofA = opened(labelled, 'A', false);
  EXPECT_EQ(ofB.verdict, TrialVerdict::kHelped) << ofB.inWords;
  EXPECT_EQ(ofA.verdict, TrialVerdict::kWrongSign) << ofA.inWords;
  EXPECT_NEAR(ofB.gain.value, 0.9, 0.05);  // the drift is no gain
  EXPECT_NEAR(ofB.gain.value, -ofA.gain.value, 1e-12);
  EXPECT_NEAR(ofB.ratio.value, 0.25, 0.02);
  EXPECT_NEAR(ofB.with.value, 1e-6, 0.05e-6);
  EXPECT_NEAR(ofB.gainP, 2.0 / 214.0, 1e-12);  // only this order and its mirror explain as much
}

TEST(BlindTrial, theSimulatedControllerIsSwitchedByTheKey) {
  const LoadedController controller(11);
  std::vector<std::size_t> moves;
  plannedSession(controller.short_, controller.machine, &moves);
  TrialSettings settings;
  const BlindTrial trial = blindTrial(controller.short_, controller.machine, moves, "trial", settings);
  const Plan plan = Plan::parse(trial.plan, "trial.yaml", ".", controller.machine);
  EXPECT_EQ(plan.measurements(), 10 * controller.short_.measurements());
  EXPECT_EQ(plan.standText(plan.moves.front()),
            std::string("state ") + trial.key.order[0] + " of the correction (block 1 of 10)");
  const auto measured = [&](const ControllerAdds& adds) {
    SimulationRequest request;
    request.hide = loadedErrors();
    request.seed = 12;
    request.correctedState = trial.key.on;
    request.correction = adds;
    return trialBlocks(simulate(controller.machine, plan, request).session, controller.calibration, quick());
  };
  const TrialBlocks found = measured(controller.adds);
  ASSERT_EQ(found.blocks.size(), 10U);
  EXPECT_TRUE(found.remarks.empty());
  for (const TrialBlockFigures& block : found.blocks) {
    EXPECT_NEAR(block.remaining, block.state == trial.key.on ? 0.0 : 1.0, 0.1) << block.number;
    EXPECT_EQ(block.ofAxis.size(), 3U);
    for (const auto& [axis, share] : block.ofAxis)
      EXPECT_NEAR(share, block.state == trial.key.on ? 0.0 : 1.0, 0.3) << block.number << ", " << axis;
  }
  EXPECT_EQ(opened(compareStates(found.blocks), trial.key.on, false).verdict, TrialVerdict::kHelped);

  const TrialBlocks twoWrong = measured(toTheOtherSide(controller.adds, {1, 2}));
  const OpenedTrial wrong = opened(compareStates(twoWrong.blocks), trial.key.on, false);
  EXPECT_EQ(wrong.verdict, TrialVerdict::kWrongSign) << wrong.inWords;
  EXPECT_NE(wrong.inWords.find("the sign is wrong for y, z"), std::string::npos) << wrong.inWords;

  const TrialBlocks swapped = measured(withExchanged(controller.adds, 0, 1, true));
  const OpenedTrial exchanged = opened(compareStates(swapped.blocks), trial.key.on, false);
  EXPECT_EQ(exchanged.verdict, TrialVerdict::kWorse) << exchanged.inWords;
}

}  // namespace
}  // namespace mm
