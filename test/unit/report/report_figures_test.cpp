#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fitted_model.h"
#include "report/iso_tests.h"
#include "report/report_profiles.h"
#include "report/report_variables.h"
#include "report/report_vectors.h"
#include "report_sessions.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using test::fitted;

const VariableView& view(const std::vector<VariableView>& views, const std::string& name) {
  const auto found =
      std::find_if(views.begin(), views.end(), [&](const VariableView& v) { return v.name == name; });
  if (found == views.end()) throw std::out_of_range(name);
  return *found;
}

TEST(ReportVariables, AStepByTravelIsSeenWithItsSignSizeAndError) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  const CalibrationResult fit = fitted(session);
  const auto views = residualsByVariable(fit, nullptr, {});
  const VariableView& travel = view(views, "x travel direction");
  EXPECT_EQ(travel.direction, "x");
  ASSERT_EQ(travel.bins.size(), 2u);
  ASSERT_EQ(travel.labels.size(), 2u);
  EXPECT_EQ(travel.labels[1], "+");
  EXPECT_EQ(travel.bins[0].count, 45);
  EXPECT_NEAR(travel.bins[0].mean, -2.0, 0.06);
  EXPECT_NEAR(travel.bins[1].mean, 2.0, 0.06);
  EXPECT_NEAR(travel.bins[1].standardError, 0.1 / std::sqrt(45.0), 0.006);
  const VariableView& position = view(views, "x");
  EXPECT_EQ(position.unit, "mm");
  ASSERT_EQ(position.bins.size(), 9u);
  EXPECT_NEAR(position.bins[0].at, -20.0, 1e-9);
  for (const VariableBin& bin : position.bins) EXPECT_NEAR(bin.mean, 0.0, 0.15);
}

TEST(ReportVariables, AnUnknownDirectionOfTravelIsNoLevel) {
  Session session = test::interferometerSession(2e-6, 0.1e-6);
  session.observations[0].velocity[0] = kNotMeasured;
  session.observations[0].travel.clear();
  session.prepare();
  const auto views = residualsByVariable(fitted(session), nullptr, {});
  EXPECT_EQ(view(views, "x travel direction").labels.size(), 2u);
}

TEST(ReportVariables, TheImprovedFitIsShownBesideIt) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  const CalibrationResult fit = fitted(session),
                          improved = fitted(session, {EffectSpec("backlash").set("axis", "x")});
  const VariableView travel = view(residualsByVariable(fit, &improved, {}), "x travel direction");
  EXPECT_NEAR(travel.bins[1].mean, 2.0, 0.06);
  EXPECT_NEAR(travel.bins[1].meanImproved, 0.0, 0.06);
}

TEST(ReportVariables, EachVariableIsInTheUnitThatStandsAtItsAxis) {
  const auto ends = [](const VariableView& v) {
    const auto range = std::minmax_element(v.x.begin(), v.x.end());
    return std::make_pair(*range.first, *range.second);
  };
  const auto views = residualsByVariable(fitted(test::laserSession(0.5e-6)), nullptr, {});
  const VariableView& reading = view(views, "laser reading");
  EXPECT_EQ(reading.unit, "mm");
  EXPECT_NEAR(ends(reading).first, 3.0, 2e-3);
  EXPECT_NEAR(ends(reading).second, 9.0, 2e-3);
  const VariableView& height = view(views, "z");
  EXPECT_EQ(height.unit, "mm");
  EXPECT_NEAR(ends(height).first, -3.0, 1e-9);
  EXPECT_NEAR(ends(height).second, 3.0, 1e-9);
  const VariableView& time = view(views, "time");
  EXPECT_EQ(time.unit, "s");
  EXPECT_NEAR(ends(time).second - ends(time).first, 195.0, 1e-9);
}

/// A beam along z tells of x by rounding alone: along x its residuals would be of any size.
TEST(ReportVariables, ADirectionThatNoRowTellsOfIsNotDrawn) {
  Directions directions;
  directions.names = {"x", "z", "approach"};
  directions.factors.resize(2, 3);
  directions.factors << 1e-9, 1.0, -1.0, -2e-9, -0.9, 0.9;
  dropUnmeasured(directions);
  EXPECT_EQ(directions.names, (std::vector<std::string>{"z", "approach"}));
  ASSERT_EQ(directions.factors.cols(), 2);
  EXPECT_EQ(directions.factors(1, 0), -0.9);
}

/// A profile that the model has is drawn with what was measured: the curve, and what it leaves.
TEST(ReportProfiles, TheCurveGoesThroughWhatWasMeasured) {
  Session session = test::interferometerSession(0.0, 0.1e-6);
  for (Observation& o : session.observations) o.deviation[0] += 3e-6 * std::sin(o.position[0] / 5e-3);
  const EffectSpec profile = EffectSpec("profile").set("direction", "x").set("variable", "x");
  EXPECT_TRUE(addedProfiles(fitted(session)).empty());
  const std::vector<AddedProfile> all = addedProfiles(fitted(session, {profile}));
  ASSERT_EQ(all.size(), 1u);
  const AddedProfile& p = all[0];
  EXPECT_EQ(p.direction, "x");
  EXPECT_EQ(p.variableUnit, "mm");
  EXPECT_EQ(p.curve.unit, "um");
  EXPECT_EQ(p.x.size(), session.observations.size());
  const auto& curve = p.curve.points;
  EXPECT_GT(curve.size(), 20u);
  double square = 0.0, measured = 0.0;
  for (std::size_t i = 0; i < p.x.size(); ++i) {
    const auto at = std::lower_bound(curve.begin(), curve.end(), p.x[i],
                                     [](const ProfileCurve::Point& c, double v) { return c.at[0] < v; });
    const double value = at == curve.end() ? curve.back().value : at->value;
    square += std::pow(p.y[i] - value, 2);
    measured += std::pow(p.y[i], 2);
  }
  EXPECT_LT(square, 0.1 * measured);  // the points lie at the curve, which is no straight line at zero
  EXPECT_GT(measured, 1.0 * static_cast<double>(p.x.size()));
}

TEST(ReportVectors, StartAtTheTouchedPointAndRunAlongTheNormal) {
  const Session session = test::ballSession("b0", 3e-6);
  const CalibrationResult fit = fitted(session);
  const ResidualVectors v = residualVectors({{"now", &fit}});
  ASSERT_EQ(v.places.size(), 60u);
  ASSERT_EQ(v.states.size(), 1u);
  ASSERT_EQ(v.balls.size(), 1u);
  EXPECT_TRUE(v.signedValues);
  EXPECT_NEAR(v.balls[0].radius, 4.0, 1e-12);
  for (std::size_t i = 0; i < v.places.size(); ++i) {
    const Eigen::Vector3d outwards = v.places[i].at - Eigen::Vector3d(0, 10, 0);
    EXPECT_NEAR(outwards.norm(), 4.003, 1e-6);
    EXPECT_NEAR(v.states[0].values[i], 3.0, 1e-6);
    EXPECT_NEAR((v.states[0].vectors[i] - 3.0 * outwards.normalized()).norm(), 0.0, 1e-6);
  }
}

TEST(ReportVectors, DeviationsAloneAreNothingToSeeInSpace) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  const CalibrationResult fit = fitted(session);
  EXPECT_TRUE(residualVectors({{"now", &fit}}).places.empty());
}

TEST(ReportPositioning, TheModelTakesTheReversalAway) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  const auto axes = axisPositioning(fitted(session, {EffectSpec("backlash").set("axis", "x")}));
  ASSERT_EQ(axes.size(), 1u);
  EXPECT_EQ(axes[0].axis, "x");
  EXPECT_NEAR(axes[0].measured.figures.meanReversal, 4.0, 0.1);
  EXPECT_NEAR(axes[0].calibrated.figures.meanReversal, 0.0, 0.1);
  EXPECT_EQ(axes[0].name, "x");
}

TEST(ReportPositioning, EachZeroOfTheInstrumentIsATestOfItsOwn) {
  Session session = test::interferometerSession(2e-6, 0.1e-6);
  const std::vector<Observation> first = session.observations;
  session.setups = {"left", "right"};
  for (Observation& o : session.observations) o.setup = 0;
  for (Observation o : first) {  // the same axis along another line, the instrument set up anew
    o.setup = 1;
    o.time += 2000.0;
    o.row += 90;
    o.deviation[0] += 50e-6;
    session.observations.push_back(o);
  }
  session.prepare();
  const auto axes = axisPositioning(fitted(session));
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_EQ(axes[0].name, "x, setup left");
  EXPECT_EQ(axes[1].name, "x, setup right");
  for (const AxisPositioning& axis : axes) EXPECT_LT(axis.measured.figures.repeatability, 6.0) << axis.name;
}

TEST(ReportPositioning, EachLineIsATestOfItsOwnAndAPathOfTwoAxesIsNone) {
  Session session = test::interferometerSession(2e-6, 0.1e-6);
  const std::vector<Observation> first = session.observations;
  for (Observation o : first) {
    o.position[1] = 30e-3;
    o.time += 2000.0;
    o.row += 90;
    session.observations.push_back(o);
  }
  session.prepare();
  const auto axes = axisPositioning(fitted(session));
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_EQ(axes[0].name, "x, at y = 0 mm");
  EXPECT_EQ(axes[1].name, "x, at y = 30 mm");
  for (Observation& o : session.observations) o.position[1] = 0.7 * o.position[0];
  EXPECT_TRUE(axisPositioning(fitted(session)).empty());
}

TEST(ReportPositioning, NoMeasuredRunIsLeftOut) {
  Session session = test::interferometerSession(2e-6, 0.1e-6);
  session.observations[40].deviation[0] += 8e-6;  // a fit leaves it aside, the standard does not
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  const CalibrationResult fit =
      calibrate(session, modelFor(session, {EffectSpec("backlash").set("axis", "x")}), options);
  ASSERT_FALSE(fit.outliers.empty());
  const auto axes = axisPositioning(fit);
  ASSERT_EQ(axes.size(), 1u);
  EXPECT_EQ(axes[0].runs.size(), 90u);
  EXPECT_GT(axes[0].measured.figures.repeatability, 12.0);
}

}  // namespace
}  // namespace mm
