// What cannot be seen where only angles are measured is held; what is truly open still is.
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/calibrate.h"
#include "fitted_model.h"
#include "model/observed_domain.h"
#include "pan_tilt_session.h"

namespace mm {
namespace {

using test::fitted;

Session tubeFlex() {
  return test_support::panTiltSession(
      240, 2.0, 127, [](double, double tilt) { return std::pair(30.0, -14.0 + 45.0 * std::cos(tilt)); });
}

EffectSpec periodic(const std::string& type, const std::string& joint) {
  return EffectSpec(type).set("joint", joint).set("harmonic", 1);
}

int withoutInfluence(const CalibrationResult& r) {
  int count = 0;
  for (const LostDirection& l : r.identifiability.lost) count += l.noInfluence;
  return count;
}

TEST(NoInfluence, RadialMotionIsHeldWhereOnlyAnglesAreMeasured) {
  const Session session = tubeFlex();
  const CalibrationResult r = fitted(session, {periodic("rotary_eccentricity", "tilt")});
  EXPECT_EQ(r.identifiability.parameters, 6);
  EXPECT_EQ(r.identifiability.rank, 2);
  EXPECT_EQ(withoutInfluence(r), 4);
  EXPECT_FALSE(r.identifiability.incomplete());
  for (int k = 0; k < 4; ++k) {
    EXPECT_TRUE(r.identifiability.fixed[static_cast<std::size_t>(k)]);
    EXPECT_EQ(r.x[k], 0.0);
  }
  EXPECT_NEAR(r.x[4] / kArcsecond, 45.0, 4.0);
}

TEST(NoInfluence, OneOfTwoTiltsThatCancelAboutTheLineOfSightIsHeld) {
  const Session session = tubeFlex();
  const CalibrationResult r = fitted(session, {periodic("rotary_wobble", "tilt")});
  EXPECT_EQ(r.identifiability.parameters, 4);
  EXPECT_EQ(r.identifiability.rank, 3);
  EXPECT_EQ(withoutInfluence(r), 1);
  EXPECT_FALSE(r.identifiability.incomplete());
}

TEST(NoInfluence, WhatTwoEffectsShareStaysOpen) {
  const Session session = tubeFlex();
  // the first harmonic of the reading twice: as an eccentric scale and as a formula
  const CalibrationResult r =
      fitted(session,
             {periodic("rotary_eccentricity", "tilt"),
              EffectSpec("formula").set("direction", "tilt").set("formula", "k1*cos(tilt)+k2*sin(3*tilt)")});
  EXPECT_TRUE(r.identifiability.incomplete());
}

TEST(NoInfluence, AnEffectWithoutAnyTraceStaysOpen) {
  const Session session = tubeFlex();
  const CalibrationResult r = fitted(session, {EffectSpec("time_drift").set("direction", "x")});
  EXPECT_TRUE(r.identifiability.incomplete());
}

}  // namespace
}  // namespace mm
