#include "report/report_thermal.h"

#include <gtest/gtest.h>

#include "report_sessions.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

/// The interferometer's nine targets ten times over 900 s while the bed warms by 4.5 K; 2 um/K along x.
Session warmingSession() {
  Session session = test::interferometerSession(0.0, 0.05e-6);
  session.temperatures.resize(2);
  session.temperatures[0].name = "bed";
  session.temperatures[1].name = "air";
  for (Observation& o : session.observations) {
    const double bed = 20.0 + 0.005 * o.time;
    o.deviation[0] += 2e-6 * (bed - 20.0);
    for (Series& series : session.temperatures) {
      series.time.push_back(o.time);
      series.value.push_back(series.name == "bed" ? bed : 21.0);
    }
  }
  return session;
}

CalibrationResult fitOf(const Session& session, const std::vector<EffectSpec>& effects = {}) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  return calibrate(session, modelFor(session, effects), options);
}

TEST(ReportThermal, DriftBeforeAndAfter) {
  const Session session = warmingSession();
  const ThermalTest test =
      thermalTest(fitOf(session, {EffectSpec("thermal_growth").set("direction", "x").set("sensor", "bed")}));
  ASSERT_EQ(test.axes.size(), 1u);
  EXPECT_EQ(test.axes[0].axis, "x");
  ASSERT_EQ(test.axes[0].courses.size(), 3u);  // first, middle, last
  EXPECT_NEAR(test.axes[0].courses[0].at, -20.0, 1e-9);
  EXPECT_NEAR(test.axes[0].courses[2].at, 20.0, 1e-9);
  EXPECT_EQ(test.axes[0].courses[1].hours.size(), 10u);
  // at the ends the runs are 10 to 890 s, two by two: 0.005 K/s * 2 um/K * 720 … 880 s
  EXPECT_NEAR(test.axes[0].measuredRange, 8.0, 1.0);
  EXPECT_LT(test.axes[0].leftRange, 0.4);
  ASSERT_EQ(test.temperatures.size(), 1u);  // the air stood still
  EXPECT_EQ(test.temperatures[0].sensor, "bed");
}

TEST(ReportThermal, NothingWhereNoTemperatureChanges) {
  Session session = warmingSession();
  session.temperatures.erase(session.temperatures.begin());
  EXPECT_TRUE(thermalTest(fitOf(session)).axes.empty());
}

}  // namespace
}  // namespace mm
