// What changes within a part of a run is drift where each run has its own, and follows the place where all
// runs have the same. Five runs both ways, 4 s from one target to the next. And what a wave must show there.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/units.h"
#include "deviations.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/shape_maker.h"
#include "effects/profile.h"
#include "effects/registry.h"
#include "estimation/calibrate.h"
#include "long_tests.h"
#include "model/observed_domain.h"
#include "random_numbers.h"
#include "read_contacts.h"
#include "session/artifact_file.h"
#include "session_files.h"

namespace mm {
namespace {

using test_support::RandomNumbers;

constexpr double kScatter = 0.4;  // um
constexpr double kLength = 40.0;  // mm, from -20 to 20
constexpr int kRepeats = 5, kTargets = 41;

/// As many in a thorough run; every day the first.
std::vector<std::uint64_t> seeds(std::uint64_t many) {
  std::vector<std::uint64_t> all(mm_test::thoroughTests() ? many : 1);
  std::iota(all.begin(), all.end(), 1);
  return all;
}

/// um, of mm from the start of the travel and the direction of travel.
using ErrorEitherWay = std::function<double(double, double)>;

/// @param memory s, of noise of 1 um; 0: none. @param error what each run has alike. @param step mm.
Diagnosis diagnosisOf(double memory, const ErrorEitherWay& error, std::uint64_t seed, double noise = kScatter,
                      double step = 1.0, const std::vector<EffectSpec>& effects = {}) {
  constexpr double kPause = 4.0;  // s
  const int targets = static_cast<int>(std::lround(kLength / step)) + 1;
  RandomNumbers random(seed);
  Session session(Machine::load("three_axis"));
  session.source = "test";
  double time = 0.0, now = random.normal(1.0);
  const double kept = memory > 0.0 ? std::exp(-kPause / memory) : 0.0;
  for (int run = 0; run < kRepeats; ++run)
    for (const double way : {1.0, -1.0})
      for (int i = 0; i < targets; ++i) {
        const double x = step * (way > 0.0 ? i : targets - 1 - i);
        now = kept * now + random.normal(std::sqrt(1.0 - kept * kept));
        const double deviation = error(x, way) + (memory > 0.0 ? now : 0.0) + random.normal(noise);
        session.observations.push_back(test_support::deviationOfX(
            (x - kLength / 2.0) * kMillimetre, way * 5e-3, time += kPause, deviation * kMicrometre));
        session.observations.back().row = static_cast<int>(session.observations.size()) + 1;
      }
  session.prepare();
  Diagnosis d = diagnose(session, Model(session.machine, observedDomain(session), effects), {});
  d.base.problem.reset();  // it refers to the session
  return d;
}

double nothing(double /*x*/, double /*way*/) { return 0.0; }

TEST(PlaceOrTime, NoiseWithMemoryIsDrift) {
  for (const double memory : {16.0, 40.0})
    for (const std::uint64_t seed : seeds(3)) {
      const Diagnosis d = diagnosisOf(memory, nothing, seed);
      EXPECT_EQ(d.base.repeated.from, "runs");
      EXPECT_EQ(d.verdict, Verdict::kExplained) << d.sentence;
      ASSERT_EQ(d.drift.size(), 1u) << d.sentence;
      EXPECT_FALSE(d.drift[0].quick) << d.sentence;
      EXPECT_NEAR(d.noise / kMicrometre, kScatter, 3.0 * d.noiseStd / kMicrometre) << d.sentence;
      EXPECT_LT(d.noiseStd / kMicrometre, 0.3) << d.sentence;
      EXPECT_EQ(d.sentence.find("place"), std::string::npos) << d.sentence;
    }
}

TEST(PlaceOrTime, WhatEachRunHasFollowsThePlace) {
  for (const std::uint64_t seed : seeds(2)) {
    RandomNumbers random(seed + 100);
    std::vector<double> own(kTargets);
    for (double& o : own) o = random.normal(1.5);
    const auto places = [&](double x, double) { return own[static_cast<std::size_t>(std::lround(x))]; };
    const Diagnosis d = diagnosisOf(0.0, places, seed);
    EXPECT_EQ(d.base.repeated.from, "runs");
    EXPECT_NE(d.verdict, Verdict::kExplained) << d.sentence;
    for (const DriftResult& drift : d.drift) EXPECT_TRUE(drift.quick && drift.ofThePlace) << d.sentence;
  }
}

TEST(PlaceOrTime, APlayThatIsLargerInTheMiddleIsNoDrift) {
  for (const double ends : {0.5, 2.0})
    for (const std::uint64_t seed : seeds(2)) {
      const auto worn = [&](double x, double way) {
        return 0.5 * way * (ends + 5.0 * std::sin(kPi * x / kLength));
      };
      const Diagnosis d = diagnosisOf(0.0, worn, seed, 0.5, 2.5);
      // where it is nothing at the ends it is, at these times, a cycle of two runs, too: then both are told
      ASSERT_FALSE(d.missing.empty()) << d.sentence;
      const auto& rivals = d.missing[0].confusableWith;
      EXPECT_TRUE(d.missing[0].effect.type == "backlash" ||
                  std::any_of(rivals.begin(), rivals.end(),
                              [](const Confusable& c) { return c.effect.type == "backlash"; }))
          << d.sentence;
      EXPECT_TRUE(d.drift.empty()) << d.sentence;
      EXPECT_LT(d.heldOut, 0.5 * d.heldOutBefore) << d.sentence;
    }
}

TEST(PlaceOrTime, WhatIsLostOverTheWaySinceAReversalIsLostMotion) {
  constexpr double kGap = 4.0, kWindUp = 6.0;  // um, mm
  const auto lost = [&](double x, double way) {
    const double gone = way > 0.0 ? x : kLength - x;
    return -0.5 * way * kGap * (1.0 - 2.0 * std::exp(-gone / kWindUp));
  };
  for (const std::uint64_t seed : seeds(3)) {
    const Diagnosis d = diagnosisOf(0.0, lost, seed);
    ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
    EXPECT_EQ(d.missing[0].effect, EffectSpec("lost_motion").set("axis", "x")) << d.sentence;
    EXPECT_TRUE(d.missing[0].confusableWith.empty()) << d.sentence;
    ASSERT_FALSE(d.missing[0].parameters.empty());
    EXPECT_NEAR(d.missing[0].parameters[0].value, kGap, 0.5) << d.sentence;
  }
}

// A nut that is worn where it works most: its play is larger at one place of the screw, and a table of ISO
// 230-2 comes there once a run.
TEST(PlaceOrTime, APlayThatIsLargerAtOnePlaceIsNoCycleInTime) {
  const auto worn = [](double x, double way) {
    const double apart = (x - 14.0) / 4.0;
    return 1.0 * x / 10.0 - 0.5 * way * (4.0 + 3.0 * std::exp(-0.5 * apart * apart));
  };
  const std::vector<EffectSpec> model = {EffectSpec("backlash").set("axis", "x"),
                                         EffectSpec("scale").set("axis", "x")};
  for (const std::uint64_t seed : seeds(4)) {
    const Diagnosis d = diagnosisOf(0.0, worn, seed, 0.25, 1.0, model);
    EXPECT_TRUE(d.missing.empty()) << d.sentence;
    EXPECT_TRUE(d.drift.empty()) << d.sentence;
    ASSERT_EQ(d.variations.size(), 1u) << d.sentence;
    EXPECT_EQ(d.variations[0].effect, model[0]) << d.sentence;
    EXPECT_EQ(d.variations[0].along, "x") << d.sentence;
  }
}

// A lost motion with more at once than in all would be such a play and a scale in one.
TEST(PlaceOrTime, APlayThatIsLargerAtOnePlaceIsNoLostMotionBesideAScale) {
  const auto worn = [](double bump, double wave) {
    return [=](double x, double way) {
      const double apart = (x - 20.0) / 6.0;
      return 3.0 * x / 10.0 - 0.5 * way * (6.0 + bump * std::exp(-apart * apart)) +
             wave * std::sin(2.0 * kPi * x / 0.55);  // at the targets like chance
    };
  };
  for (const auto& [bump, wave] : {std::pair{4.0, 0.0}, std::pair{1.5, 1.5}})
    for (const std::uint64_t seed : seeds(4)) {
      const Diagnosis d = diagnosisOf(0.0, worn(bump, wave), seed, 0.2, 4.0);
      EXPECT_TRUE(std::any_of(d.missing.begin(), d.missing.end(), [](const CandidateResult& m) {
        return m.effect.type == "backlash";
      })) << d.sentence;
      for (const CandidateResult& m : d.missing) EXPECT_NE(m.effect.type, "lost_motion") << d.sentence;
    }
}

// What is known beforehand of a profile's weights are rows that no observation has: a play beside it changes
// along the axis in the others alone.
TEST(PlaceOrTime, AProfileInTheModelHasRowsOfItsOwn) {
  const auto play = [](double x, double way) { return -2.0 * way + std::sin(kPi * x / kLength); };
  const Diagnosis d = diagnosisOf(0.0, play, 1, 0.25, 1.0,
                                  {EffectSpec("backlash").set("axis", "x"), profileSpec("x", {"x"})});
  EXPECT_EQ(d.verdict, Verdict::kExplained) << d.sentence;
}

// A play is a lost motion that is lost at once: what is said of the two is not that nothing would tell.
TEST(PlaceOrTime, APlayIsNotTheSameAsALostMotion) {
  const auto play = [](double, double way) { return -2.0 * way; };
  for (const std::uint64_t seed : seeds(4)) {
    const Diagnosis d = diagnosisOf(0.0, play, seed);
    ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
    EXPECT_EQ(d.missing[0].effect, EffectSpec("backlash").set("axis", "x")) << d.sentence;
    for (const Confusable& c : d.missing[0].confusableWith) EXPECT_FALSE(c.same) << c.effect.yaml();
  }
}

// Targets half a period apart tell neither a longer wave nor a larger one.
TEST(PlaceOrTime, AWaveOfTwoStepsIsNoLongerAndNoLarger) {
  const auto wave = [](double x, double) { return 2.0 * std::sin(kPi * x / 2.0 + 0.8); };
  for (const std::uint64_t seed : seeds(2)) {
    const Diagnosis d = diagnosisOf(0.0, wave, seed, 0.5, 2.0);
    ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
    const CandidateResult& m = d.missing[0];
    EXPECT_EQ(m.effect.type, "lead_screw_periodic") << d.sentence;
    EXPECT_EQ(m.effect.text("axis"), "x") << d.sentence;
    const bool determined = m.parameters.size() == 3;  // else the period is stated
    EXPECT_NEAR(determined ? m.parameters[2].value : std::stod(m.effect.text("period_mm")), 4.0, 0.1)
        << d.sentence;
    // two targets a period see 2 sin(0.8) um of it, and no more
    EXPECT_NEAR(std::hypot(m.parameters[0].value, m.parameters[1].value), 2.0 * std::sin(0.8), 0.2)
        << d.sentence;
  }
}

/// Nine balls on a plate that lies nearly flat, each touched at the same ten heights at one speed.
/// @param walking um, of a random walk beside the noise. @param tipLarger um.
Session touchedAtTheSameHeights(std::uint64_t seed, double walking = 0.5, double tipLarger = 0.0) {
  constexpr double kBall = 3.9685, kTip = 1.0, kLean = 0.004;  // mm, mm, rad
  RandomNumbers random(seed);
  std::string yaml = "name: plate\npose: free\nprobe: {tip_radius_mm: 1.0, repeatability_um: 0.5}\nballs:\n";
  std::string csv = "time_s,x_mm,y_mm,z_mm,x_velocity_mm_s,y_velocity_mm_s,z_velocity_mm_s,feature\n";
  std::vector<std::pair<int, int>> touches;
  for (int b = 0; b < 9; ++b) {
    yaml += "  - {name: b" + std::to_string(b) + ", centre_mm: [" + std::to_string(12 * (b % 3)) + ", " +
            std::to_string(12 * (b / 3)) + ", 0], radius_mm: 3.9685}\n";
    for (int k = 0; k < 10; ++k) touches.emplace_back(b, k);
  }
  for (std::size_t i = touches.size() - 1; i > 0; --i)
    std::swap(touches[i], touches[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(i + 1)))]);
  const Eigen::Matrix3d lean =
      Eigen::AngleAxisd(kLean, Eigen::Vector3d(1.0, 0.4, 0.0).normalized()).toRotationMatrix();
  double time = 0.0, walk = 0.0;
  for (const auto& [b, k] : touches) {
    const double z = 1.0 - (k + 0.5) / 10.0, s = std::sqrt(1.0 - z * z), azimuth = 2.39996 * (k + 3 * b);
    const Eigen::Vector3d n(s * std::cos(azimuth), s * std::sin(azimuth), z);
    walk += random.normal(1e-3 * walking / 3.0);
    const Eigen::Vector3d at = lean * Eigen::Vector3d(12.0 * (b % 3) - 12.0, 12.0 * (b / 3) - 12.0, 0.0) +
                               (kBall + kTip + 1e-3 * tipLarger + walk + random.normal(0.6e-3)) * n;
    char line[200];
    std::snprintf(line, sizeof line, "%.1f,%.6f,%.6f,%.6f,%.5f,%.5f,%.5f,b%d\n", time += 8.0, at.x(), at.y(),
                  at.z(), -2.0 * n.x(), -2.0 * n.y(), -2.0 * n.z(), b);
    csv += line;
  }
  const Machine machine = Machine::load("three_axis");
  const Artifact artifact = parseArtifact(yaml, "plate.yaml");
  const test::Folder folder;
  return readContactsCsv(folder.write("touches.csv", csv), machine, &artifact);
}

TEST(PlaceOrTime, AWaveWithItsNodesAtTheTouchesIsNotAsked) {
  for (const std::uint64_t seed : seeds(2)) {
    const Session session = touchedAtTheSameHeights(seed);
    const Model model(session.machine, observedDomain(session), std::vector<EffectPtr>());
    const Diagnosis d = diagnose(session, model, {});
    EXPECT_TRUE(d.missing.empty() && d.profiles.empty()) << d.sentence;
    const CalibrationResult fitted = calibrate(session, model, {});
    const ResidualSpace space(fitted);
    const GroupColumns columns(space);
    const EffectPtr wave = createEffect(
        EffectSpec("lead_screw_periodic").set("axis", "z").set("period_mm", "unknown"), model.domain());
    const double step = 0.1 * 4.9685e-3;  // m
    EXPECT_EQ(columns(wave, {step}).cols(), 0);
    EXPECT_EQ(columns(wave, {step / 2.0}).cols(), 0);
    EXPECT_GT(columns(wave, {3.7 * step}).cols(), 0);
  }
}

TEST(PlaceOrTime, ATriggerBeforeTheContactIsNotTheFirstOfWhatActsAlike) {
  for (const double larger : {2.0, -2.0}) {
    const Session session = touchedAtTheSameHeights(1, 0.0, larger);
    const Diagnosis d =
        diagnose(session, Model(session.machine, observedDomain(session), std::vector<EffectPtr>()), {});
    ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
    const CandidateResult& m = d.missing[0];
    const auto rival = [&](const std::string& type) {
      return m.effect.type == type || std::any_of(m.confusableWith.begin(), m.confusableWith.end(),
                                                  [&](const Confusable& c) { return c.effect.type == type; });
    };
    EXPECT_TRUE(rival("probe_radius")) << d.sentence;
    if (larger > 0.0)
      EXPECT_NE(m.effect.type, "speed_lag") << d.sentence;
    else  // late, as triggers are
      EXPECT_TRUE(rival("speed_lag")) << d.sentence;
  }
}

TEST(PlaceOrTime, OneBadReadingIsNoCause) {
  // four times the noise, at the start: a warm-up or a jump of which nothing but this reading is seen would
  // fit it
  for (const std::uint64_t seed : seeds(3)) {
    int reading = 0;
    const Diagnosis d = diagnosisOf(
        0.0, [&](double, double) { return reading++ == 0 ? 4.0 * kScatter : 0.0; }, seed);
    EXPECT_TRUE(d.missing.empty()) << d.sentence;
    for (const CandidateResult& c : d.candidates) EXPECT_LT(c.odds, 0.5) << c.effect.yaml();
  }
}

}  // namespace
}  // namespace mm
