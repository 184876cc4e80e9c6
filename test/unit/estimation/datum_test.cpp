// An instrument measures from a datum of its own; a law written as a formula may say where it starts.
#include <gtest/gtest.h>

#include <cmath>

#include "deviations.h"
#include "diagnosis/diagnose.h"
#include "estimation/calibrate.h"
#include "model/observed_domain.h"
#include "pan_tilt_session.h"

namespace mm {
namespace {

constexpr double kNoise = 0.4;  // um

/// Deviations of x without a setup: `offset` and a wave of `amplitude` (um) over 7 mm.
Session waveOnOffset(double offset, double amplitude) {
  Session session(Machine::load("three_axis"));
  session.source = "wave";
  test_support::RandomNumbers random(50);
  for (int i = 0; i < 210; ++i) {
    const double x = random.uniform(-20.0, 20.0) * kMillimetre;
    const double wave = std::sin(2.0 * 3.14159265358979 * x / (7.0 * kMillimetre));
    Observation o = test_support::deviationOfX(
        x, kNotMeasured, 10.0 * i, (offset + amplitude * wave + random.normal(kNoise)) * kMicrometre);
    o.velocity.assign(3, kNotMeasured);
    o.row = i + 2;
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

CalibrationResult fitted(const Session& session, const std::string& direction, const std::string& formula) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  const EffectSpec spec = EffectSpec("formula").set("direction", direction).set("formula", formula);
  return calibrate(session, Model(session.machine, observedDomain(session), std::vector<EffectSpec>{spec}),
                   options);
}

TEST(Datum, AFormulaWithoutAConstantDoesNotTakeTheInstrumentsZeroAway) {
  const Session session = waveOnOffset(50.0, 3.0);
  const CalibrationResult r = fitted(session, "x", "k1*sin(2*pi*x/7)");
  EXPECT_LT(r.figures.rms, 1.15 * kNoise * kMicrometre);
  EXPECT_NEAR(r.x[0], 3.0, 0.2);
  const int zero = r.problem->find(UnknownKind::kSetup, 0);
  ASSERT_GE(zero, 0);
  EXPECT_NEAR(r.x[zero] / kMicrometre, 50.0, 0.2);
  EXPECT_FALSE(r.identifiability.incomplete());
}

TEST(Datum, AConstantOfTheFormulaIsTheZero) {
  const Session session = waveOnOffset(50.0, 3.0);
  const CalibrationResult r = fitted(session, "x", "k1+k2*sin(2*pi*x/7)");
  EXPECT_LT(r.figures.rms, 1.15 * kNoise * kMicrometre);
  EXPECT_NEAR(r.x[0], 50.0, 0.2);
  EXPECT_NEAR(r.x[1], 3.0, 0.2);
  EXPECT_EQ(r.identifiability.rank, 2);
  EXPECT_FALSE(r.identifiability.incomplete());
}

TEST(Datum, ALawThatTheDataBearOutSaysWhereItStarts) {
  const Session session = waveOnOffset(0.0, 3.0);
  const CalibrationResult r = fitted(session, "x", "k1*sin(2*pi*x/7)");
  EXPECT_EQ(r.problem->unknownCount(), 1);
  EXPECT_NEAR(r.x[0], 3.0, 0.2);
}

TEST(Datum, ZerosOfOtherComponentsStayToo) {
  const Session session = test_support::panTiltSession(
      240, 2.0, 9, [](double, double tilt) { return std::pair(30.0, -14.0 + 20.0 * std::cos(2.0 * tilt)); });
  const CalibrationResult r = fitted(session, "tilt", "k1*cos(2*tilt)");
  EXPECT_LT(r.figures.rmsAngular, 2.2 * kArcsecond);
  EXPECT_NEAR(r.x[0], 20.0, 1.0);
  const Diagnosis d = diagnose(session, r.problem->model(), {}, r.x.head(1));
  EXPECT_TRUE(d.missing.empty() && d.profiles.empty()) << d.sentence;
  EXPECT_EQ(d.verdict, Verdict::kScatter) << d.sentence;  // nobody said how large the noise is
}

}  // namespace
}  // namespace mm
