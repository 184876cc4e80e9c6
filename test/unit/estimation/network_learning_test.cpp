#include "estimation/network_learning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/error.h"
#include "model/observed_domain.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

constexpr double kThermalNoise = 0.2e-6;  // m

/// x measured at three positions in `sets` sets while `spindle` and `bed` warm and cool; `air` stands still.
/// The truth: 1.5 um/K of (spindle - 20), `bend` um/K^2 of the bed's rise, more the further out.
Session warmUp(int sets, double bend) {
  Session session(Machine::load("three_axis"));
  session.source = "warm_up.csv";
  session.temperatures.resize(3);
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  const char* const names[] = {"spindle", "bed", "air"};
  for (int s = 0; s < 3; ++s) session.temperatures[s].name = names[s];
  for (int k = 0; k < sets; ++k) {
    const double phase = 6.28 * k / 25.0;
    const double spindle = 25.0 + 4.0 * std::sin(phase) + 0.4 * normal(generator),
                 bed = 24.0 + 4.0 * std::sin(0.37 * phase + 1.0);
    for (int i = 0; i < 3; ++i) {
      Observation o;
      o.kind = ObservationKind::kDeviation;
      o.time = 300.0 * k + 5.0 * i;
      o.row = static_cast<std::int64_t>(session.observations.size()) + 2;
      o.position = {-10e-3 + 10e-3 * i, 0.0, 0.0};
      o.velocity = {1e-3, 0.0, 0.0};
      const double rise = bed - 20.0;
      o.deviation = {1.5e-6 * (spindle - 20.0) + 1e-6 * bend * (1.0 + 0.5 * i) * rise * rise +
                         kThermalNoise * normal(generator),
                     kNotMeasured, kNotMeasured};
      session.observations.push_back(o);
      const double values[] = {spindle, bed, 21.0};
      for (int s = 0; s < 3; ++s) {
        session.temperatures[s].time.push_back(o.time);
        session.temperatures[s].value.push_back(values[s]);
      }
    }
  }
  session.prepare();
  return session;
}

EffectSpec network(const std::string& kind, std::vector<std::string> sensors = {}) {
  EffectSpec spec("thermal_network");
  spec.set("axis", "x");
  if (!sensors.empty()) spec.setList("sensors", std::move(sensors));
  if (kind != "auto") spec.set("network", kind);
  return spec;
}

const EffectSpec kGrowth = EffectSpec("thermal_growth").set("direction", "x").set("sensor", "spindle");

CalibrationResult fit(const Session& session, const std::vector<EffectSpec>& effects, unsigned threads = 1) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.threads = threads;
  return calibrate(session, Model(session.machine, observedDomain(session), effects), options);
}

std::string refusal(const Session& session, const EffectSpec& effect) {
  try {
    fit(session, {effect});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(NetworkLearning, PhysicalEffectsComeFirstAndLeaveNothing) {
  const Session session = warmUp(40, 0.0);
  const CalibrationResult result = fit(session, {network("dfnn", {"spindle", "bed"}), kGrowth});
  const LearnedNetwork learned = result.problem->model().networks().at(0);
  EXPECT_FALSE(learned.active);
  EXPECT_NE(learned.summary.find("not activated"), std::string::npos) << learned.summary;
  ASSERT_EQ(result.problem->model().parameterCount(), 1);
  EXPECT_NEAR(result.x[0], 1.5e-6, 0.03e-6);
  EXPECT_NEAR(result.figures.rms, kThermalNoise, 0.2 * kThermalNoise);
}

TEST(NetworkLearning, TakesWhatThePhysicalEffectsLeave) {
  const Session session = warmUp(60, 0.5);
  const CalibrationResult alone = fit(session, {kGrowth});
  const CalibrationResult result = fit(session, {kGrowth, network("dfnn", {"spindle", "bed"})});
  const LearnedNetwork learned = result.problem->model().networks().at(0);
  ASSERT_TRUE(learned.active) << learned.summary;
  EXPECT_EQ(learned.positions.size(), 3u);
  EXPECT_LT(learned.heldOut, 0.6 * learned.heldOutRidge);
  EXPECT_NEAR(result.x[1], 1.0, 0.02);  // gain
  EXPECT_LT(result.figures.rms, 2.0 * kThermalNoise);
  EXPECT_LT(result.figures.heldOutRms, 0.1 * alone.figures.heldOutRms);
  // the held-out figure is of networks that have not seen the block: no better than what the learner found
  EXPECT_GT(result.figures.heldOutRms, 1.1 * result.figures.rms);
}

LearnedNetwork learnedBy(const CalibrationResult& result) { return result.problem->model().networks().at(0); }

TEST(NetworkLearning, ALineWorksWhereTheNetworkAskedForIsWorse) {
  const Session session = warmUp(60, 0.0), fresh = warmUp(25, 0.0);
  const CalibrationResult line = fit(session, {network("ridge", {"spindle", "bed"})}),
                          result = fit(session, {network("rbf", {"spindle", "bed"})});
  const LearnedNetwork learned = learnedBy(result);
  ASSERT_TRUE(learned.active) << learned.summary;
  EXPECT_EQ(networkFromNumbers(learned.numbers)->kind(), NetworkKind::kRidge);
  EXPECT_EQ(learned.summary.find("ridge active, instead of rbf, which is significantly worse"), 0u)
      << learned.summary;
  EXPECT_NE(learned.summary.find(", none "), std::string::npos) << learned.summary;
  EXPECT_EQ(learned.numbers, learnedBy(line).numbers);
  EXPECT_EQ(learned.heldOut, learned.heldOutRidge);
  EXPECT_EQ(result.x, line.x);
  EXPECT_LT(result.figures.rms, 1.5 * kThermalNoise);
}

TEST(NetworkLearning, AutoIsTheDefaultAndTakesTheBest) {
  const CalibrationResult straight = fit(warmUp(60, 0.0), {network("auto", {"spindle", "bed"})}),
                          bent = fit(warmUp(60, 0.5), {network("auto", {"spindle", "bed"})});
  EXPECT_EQ(learnedBy(bent).effect, "{type: thermal_network, axis: x, sensors: [spindle, bed]}");
  EXPECT_EQ(networkFromNumbers(learnedBy(straight).numbers)->kind(), NetworkKind::kRidge)
      << learnedBy(straight).summary;
  ASSERT_TRUE(learnedBy(bent).active) << learnedBy(bent).summary;
  EXPECT_LT(learnedBy(bent).heldOut, 0.6 * learnedBy(bent).heldOutRidge);
  for (const char* name : {"dfnn", "rbf", "ridge-linear", "none", "best"})
    EXPECT_NE(learnedBy(bent).summary.find(name), std::string::npos) << learnedBy(bent).summary;
}

TEST(NetworkLearning, AnUpdateChoosesAgainFromAllSets) {
  const Session first = warmUp(9, 0.5), second = warmUp(60, 0.5);  // a bend shows in the second only
  CalibrateOptions held;
  held.holdEffects = true;
  held.rejectOutliers = false;
  for (const std::string kind : {"auto", "ridge"}) {
    const CalibrationResult learned = fit(first, {network(kind, {"spindle", "bed"})});
    ASSERT_EQ(networkFromNumbers(learnedBy(learned).numbers)->kind(), NetworkKind::kRidge)
        << learnedBy(learned).summary;
    const Model& model = learned.problem->model();
    const UpdatedNetworks updated =
        updateNetworks(calibrate(second, model, held, learned.x.head(model.parameterCount())));
    const LearnedNetwork& now = updated.networks.at(0);
    const auto network = networkFromNumbers(now.numbers);
    EXPECT_EQ(network->samples(), 69);
    EXPECT_EQ(network->kind() == NetworkKind::kRidge, kind == "ridge") << now.summary;
    EXPECT_NE(now.summary.find("; updated with 60 sets of warm_up.csv: " + nameOf(network->kind())),
              std::string::npos)
        << now.summary;
    if (kind == "auto") {
      EXPECT_LT(updated.heldOut, 0.5 * updated.before);
      EXPECT_LT(now.heldOut, now.heldOutRidge);
    }
  }
}

TEST(NetworkLearning, TheSameBitsWhateverTheThreads) {
  const Session session = warmUp(40, 0.5);
  const CalibrationResult one = fit(session, {network("auto")}, 1), two = fit(session, {network("auto")}, 2);
  EXPECT_EQ(one.x, two.x);
  EXPECT_EQ(one.problem->model().networks()[0].numbers, two.problem->model().networks()[0].numbers);
}

TEST(NetworkLearning, ChoosesSensorsThatVary) {
  const CalibrationResult result = fit(warmUp(60, 0.5), {network("ridge")});
  const LearnedNetwork learned = result.problem->model().networks().at(0);
  EXPECT_EQ(learned.sensors, (std::vector<std::string>{"bed", "spindle"}));
}

TEST(NetworkLearning, WhatIsHeldDoesNotLearnAgain) {
  const Session training = warmUp(60, 0.5), test = warmUp(20, 0.5);
  const CalibrationResult learned = fit(training, {kGrowth, network("dfnn", {"spindle", "bed"})});
  CalibrateOptions held;
  held.holdEffects = true;
  const CalibrationResult compared = calibrate(test, learned.problem->model(), held,
                                               learned.x.head(learned.problem->model().parameterCount()));
  EXPECT_EQ(compared.problem->model().networks()[0].numbers, learned.problem->model().networks()[0].numbers);
  EXPECT_LT(compared.figures.rms, 2.0 * kThermalNoise);
}

TEST(NetworkLearning, RefusesInOneClearLine) {
  const Session session = warmUp(40, 0.5);
  const std::string constant = refusal(session, network("dfnn", {"spindle", "air"}));
  EXPECT_NE(constant.find("temperature air does not vary"), std::string::npos) << constant;
  const std::string few = refusal(warmUp(1, 0.5), network("dfnn"));
  EXPECT_NE(few.find("at least 6"), std::string::npos) << few;
  Session bare = session;
  bare.temperatures.clear();
  EXPECT_NE(refusal(bare, network("dfnn")).find("no temperatures"), std::string::npos);
  EffectSpec other("thermal_network");
  other.set("axis", "y");
  EXPECT_NE(refusal(session, other).find("the session has no measurement of axis y"), std::string::npos)
      << refusal(session, other);
  Session lost = session;  // a sensor that answered only at the start
  lost.temperatures[1].value.assign(lost.temperatures[1].value.size(), kNotMeasured);
  EXPECT_NE(refusal(lost, network("ridge", {"bed"})), "");
  for (const std::string& message : {constant, few}) EXPECT_EQ(message.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace mm
