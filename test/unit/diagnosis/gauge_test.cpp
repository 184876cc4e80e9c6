// Parameters that only choose the frame must not absorb what a missing effect did.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "diagnosis/diagnose.h"
#include "long_tests.h"
#include "model/observed_domain.h"
#include "pan_tilt_session.h"

namespace mm {
namespace {

/// The tilt axis is not square to the pan axis by 7.4 arcsec; both zeros are off.
Session notSquare(std::uint64_t seed) {
  return test_support::panTiltSession(
      240, 2.0, seed, [](double, double tilt) { return std::pair(40.0 + 7.4 * std::tan(tilt), -15.0); });
}

Model zerosOf(const Session& session) {
  return Model(session.machine, observedDomain(session),
               std::vector<EffectSpec>{EffectSpec("rotary_zero").set("joint", "pan"),
                                       EffectSpec("rotary_zero").set("joint", "tilt")});
}

TEST(Gauge, AFitThatGoesOnFromAnotherFindsTheSame) {
  const Session session = notSquare(79);
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  const CalibrationResult first = calibrate(session, zerosOf(session), options);
  const CalibrationResult again = calibrate(session, zerosOf(session), options, first.x.head(2));
  ASSERT_GT(first.figures.rmsAngular, 6.0 * kArcsecond);
  EXPECT_EQ(first.identifiability.fixed, again.identifiability.fixed);
  EXPECT_NEAR(again.figures.rmsAngular / first.figures.rmsAngular, 1.0, 1e-6);
  EXPECT_NEAR(again.x[1] / kArcsecond, -15.0, 2.0);
}

TEST(Gauge, LostZerosDoNotHideAMissingEffect) {
  for (const std::uint64_t seed :
       mm_test::thoroughTests() ? std::vector<std::uint64_t>{79, 80} : std::vector<std::uint64_t>{79}) {
    const Session session = notSquare(seed);
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    const CalibrationResult fitted = calibrate(session, zerosOf(session), options);
    const Diagnosis d = diagnose(session, zerosOf(session), {}, fitted.x.head(2));
    EXPECT_NEAR(d.base.figures.rmsAngular / fitted.figures.rmsAngular, 1.0, 1e-6);
    ASSERT_EQ(d.missing.size(), 1u) << d.sentence;
    EXPECT_EQ(d.missing[0].effect, EffectSpec("rotary_axis_tilt").set("joint", "tilt").set("about", "x"))
        << d.sentence;
    const NamedValue& tilt = d.missing[0].parameters[0];
    EXPECT_NEAR(tilt.value, -7.4, 3.0 * tilt.std) << d.sentence;
    EXPECT_LT(d.missing[0].heldOutAfter, 2.2 * kArcsecond);
  }
}

}  // namespace
}  // namespace mm
