// What one placement, stylus or day cannot tell, and several can.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "design/separation.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/wording.h"
#include "estimation/calibrate.h"
#include "fitted_model.h"
#include "model/observed_domain.h"
#include "session/joined.h"
#include "turned_plate.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using test::fitted;
using test::modelOf;

using ::testing::HasSubstr;

constexpr double kQuarter = 1.5707963267948966;

EffectSpec scaleOf(const std::string& axis) { return EffectSpec("scale").set("axis", axis); }
EffectSpec squareness() { return EffectSpec("squareness").set("axis", "x").set("of", "y"); }

/// A machine with a scale of x and a squareness; SI.
test::TurnedPlate::Error geometry(double scale, double square) {
  return [=](const Eigen::Vector3d& q, const Eigen::Vector3d&, int, int) {
    return Eigen::Vector3d(scale * q[0] + square * q[1], 0.0, 0.0);
  };
}

TEST(Placements, EachHasAPose) {
  test::TurnedPlate plate(11);
  plate.error = geometry(100e-6, 200e-6);
  const Session s = plate.session("a.bag", {0.0, kQuarter, 2.5});
  const CalibrationResult r = fitted(s, {scaleOf("x"), squareness()});
  EXPECT_TRUE(r.problem->poseFree(0) && r.problem->poseFree(1) && r.problem->poseFree(2));
  EXPECT_NEAR(r.x[0], 100e-6, 4.0 * r.std(0));
  EXPECT_NEAR(r.x[1], 200e-6, 4.0 * r.std(1));
  const double n = r.problem->rowCount(), free = n - r.problem->unknownCount();
  EXPECT_NEAR(r.figures.rms, plate.noise * std::sqrt(free / n), 4.0 * plate.noise / std::sqrt(2.0 * n));
}

TEST(Placements, TurningThePlateTellsItsErrorsFromTheMachines) {
  test::TurnedPlate plate(12);
  plate.error = geometry(60e-6, 150e-6);
  for (std::size_t b = 0; b < 9; ++b)
    plate.deviation.push_back(20e-6 * Eigen::Vector3d(plate.draw(), plate.draw(), plate.draw()));
  for (Feature& f : plate.artifact.features) f.known = false;
  const std::vector<EffectSpec> model = {scaleOf("x"), scaleOf("y"), squareness()};
  const CalibrationResult one = fitted(plate.session("a.bag", {0.0}), model);

  const Session turned = plate.session("b.bag", {0.0, kQuarter, 2.0 * kQuarter, 3.0 * kQuarter});
  const CalibrationResult r = fitted(turned, model);
  // one placement tells them by the shape of the balls alone, several by their places too
  EXPECT_LT(r.std(2), 0.2 * one.std(2));
  EXPECT_NEAR(r.x[2], 150e-6, 4.0 * r.std(2));
  EXPECT_NEAR(r.x[0] - r.x[1], 60e-6, 3e-6) << "the difference of the scales";
  // distances of balls, but for the scale
  const auto at = [&](int f) { return r.problem->featureInArtifact(f, r.x); };
  const auto truth = [&](int f) {
    return Eigen::Vector3d(plate.artifact.features[static_cast<std::size_t>(f)].position +
                           plate.deviation[static_cast<std::size_t>(f)]);
  };
  const double scale = (at(8) - at(0)).norm() / (truth(8) - truth(0)).norm();
  for (const auto& [i, j] : {std::pair(0, 2), std::pair(1, 7), std::pair(2, 6), std::pair(3, 8)})
    EXPECT_NEAR((at(i) - at(j)).norm() / scale, (truth(i) - truth(j)).norm(), 0.5e-6) << i << " " << j;
}

TEST(Placements, TheOffsetOfAStylusIsFound) {
  test::TurnedPlate plate(13);
  plate.error = geometry(100e-6, 0.0);
  plate.artifact.styli = {{"A", 1e-3, Eigen::Vector3d::Zero()},
                          {"B", 1.5e-3, Eigen::Vector3d::Constant(kNotMeasured), false}};
  plate.offset = {Eigen::Vector3d::Zero(), Eigen::Vector3d(12e-3, -3e-3, 7e-3)};
  const Session s = plate.session("a.bag", {0.0});
  const CalibrationResult r = fitted(s, {scaleOf("x")});
  const int at = r.problem->find(UnknownKind::kStylus, 1);
  ASSERT_GE(at, 0);
  EXPECT_EQ(r.problem->find(UnknownKind::kStylus, 0), -1) << "the first is where the machine says";
  const Eigen::Vector3d found = r.problem->reach(1, r.x);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], plate.offset[1][k], 4.0 * r.std(at + k)) << k;
  EXPECT_NEAR(r.x[0], 100e-6, 4.0 * r.std(0));
}

TEST(Placements, WhatBeganBetweenTwoSessionsIsTheSecondOnes) {
  test::TurnedPlate plate(14);
  plate.error = [](const Eigen::Vector3d& q, const Eigen::Vector3d&, int, int day) {
    return Eigen::Vector3d(100e-6 * q[0] + (day > 0 ? 200e-6 * q[0] : 0.0), 0.0, 0.0);
  };
  const Session both =
      joined({plate.session("monday.bag", {0.0}, 0), plate.session("tuesday.bag", {0.0}, 1)});
  const Diagnosis d = diagnose(both, modelOf(both, {scaleOf("x")}), {});
  ASSERT_EQ(d.missing.size(), 1U) << d.sentence;
  EXPECT_EQ(d.missing[0].effect.yaml(), scaleOf("x").set("from_session", 2.0).yaml()) << d.sentence;
  EXPECT_EQ(ownerOf(d.missing[0].effect, d), "session tuesday.bag");
  EXPECT_TRUE(
      std::any_of(d.where.begin(), d.where.end(), [](const auto& w) { return w.variable == "session"; }));
  EXPECT_THAT(d.sentence, HasSubstr("it began between monday.bag and tuesday.bag"));
  EXPECT_NEAR(d.missing[0].parameters[0].value, 200.0, 3.0 * d.missing[0].parameters[0].std);
}

TEST(Placements, WhatOneStylusDoesIsItsOwn) {
  test::TurnedPlate plate(15);
  plate.artifact.styli = {{"A", 1e-3, Eigen::Vector3d::Zero()}, {"B", 1e-3, Eigen::Vector3d(10e-3, 0, 0)}};
  plate.offset = {plate.artifact.styli[0].offset, plate.artifact.styli[1].offset};
  plate.error = [](const Eigen::Vector3d& q, const Eigen::Vector3d& out, int stylus, int) {
    const double lobe =
        stylus == 1 ? 1.5e-6 * std::hypot(out[0], out[1]) * std::cos(3.0 * std::atan2(-out[1], -out[0]))
                    : 0.0;
    return Eigen::Vector3d(100e-6 * q[0] - lobe * out[0], -lobe * out[1], -lobe * out[2]);
  };
  const Session s = plate.session("a.bag", {0.0, kQuarter});
  const Diagnosis d = diagnose(s, modelOf(s, {scaleOf("x")}), {});
  ASSERT_FALSE(d.missing.empty()) << d.sentence;
  EXPECT_EQ(d.missing[0].effect.type, "probe_lobing");
  EXPECT_EQ(ownerOf(d.missing[0].effect, d), "stylus B");
}

TEST(Placements, ASetSaysWhatItTellsApart) {
  test::TurnedPlate plate(16);
  const auto told = [](const Session& session, const std::string& what) {
    for (const Separation& s : separationsOf(session))
      if (s.what.find(what) != std::string::npos) return s.told;
    ADD_FAILURE() << what;
    return false;
  };
  const std::string square = "squareness of y to x";
  const Session flat = plate.session("a.bag", {0.0}), turned = plate.session("b.bag", {0.0, kQuarter});
  EXPECT_FALSE(told(flat, square));
  EXPECT_TRUE(told(turned, square));
  EXPECT_TRUE(told(turned, "squareness of z to x")) << "its balls stand at several heights";
  EXPECT_FALSE(told(turned, "scale of x")) << "one length is missing";
  EXPECT_FALSE(told(turned, "two sessions"));
  EXPECT_TRUE(told(joined({flat, turned}), "two sessions"));
}

TEST(Placements, WhatBeganWithASessionTakesTheOneBefore) {
  test::TurnedPlate plate(17);
  const Session monday = plate.session("a.bag", {0.0}), tuesday = plate.session("b.bag", {0.0});
  ModelSpec model;
  model.effects = {scaleOf("x").set("from_session", 2.0)};
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  EXPECT_THROW(recalibrate(monday, model, options), InputError);
  const Session both = joined({monday, tuesday});
  const Calibration made = recalibrate(both, model, options).calibration;
  EXPECT_EQ(made.sessionParts.size(), 2U);
  EXPECT_EQ(made.ledger.at(0).sessions, (std::vector<std::string>{"a.bag", "b.bag"}));
}

}  // namespace
}  // namespace mm
