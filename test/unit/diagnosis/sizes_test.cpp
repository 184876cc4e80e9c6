#include <gtest/gtest.h>

#include "diagnosis/answers.h"
#include "effects/registry.h"
#include "machine/machine.h"

namespace mm {
namespace {

/// How sure one scale is in a fit, of a value over its standard deviation; 0: the fit held it.
double surenessAt(double value, double std) {
  const Machine machine = Machine::load("three_axis");
  Domain domain;
  domain.joints = machine.joints();
  domain.lower.assign(domain.joints.size(), 0.0);
  domain.upper.assign(domain.joints.size(), 0.1);
  Answer answer;
  answer.effect = createEffect(EffectSpec("scale").set("axis", "x"), domain);
  CalibrationResult full;
  full.x = Eigen::VectorXd::Constant(1, value);
  full.covariance = Eigen::MatrixXd::Constant(1, 1, std * std);
  return surenessOf({answer}, full, 0, 1).at(0);
}

TEST(SurenessOf, IsOneWhereTheSizeIsItsExpandedUncertainty) {
  EXPECT_NEAR(surenessAt(20e-6, 10e-6), 1.0, 1e-3);  // k = 2 of a normal distribution: 95.45 %
  EXPECT_NEAR(surenessAt(-40e-6, 10e-6), 4.0, 1e-2);
  EXPECT_LT(surenessAt(19e-6, 10e-6), 1.0);
}

TEST(SurenessOf, WhatTheFitHeldIsNotDropped) { EXPECT_EQ(surenessAt(0.0, 0.0), 1.0); }

}  // namespace
}  // namespace mm
