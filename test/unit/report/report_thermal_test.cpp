#include <gtest/gtest.h>

#include "fitted_model.h"
#include "report/iso_tests.h"
#include "report_sessions.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using test::fitted;

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

TEST(ReportThermal, DriftBeforeAndAfter) {
  const Session session = warmingSession();
  const ThermalReport report = thermalReport(
      fitted(session, {EffectSpec("thermal_growth").set("direction", "x").set("sensor", "bed")}));
  ASSERT_EQ(report.tests.size(), 1u);
  const ThermalTestFigures& found = report.tests[0];
  EXPECT_EQ(found.test.kind, ThermalTestKind::kLinearAxis);
  EXPECT_EQ(found.test.joint, "x");
  ASSERT_EQ(found.test.courses.size(), 4u);  // first, middle, last, and the length between the ends
  EXPECT_NEAR(found.test.courses[0].at, -20.0, 1e-9);
  EXPECT_NEAR(found.test.courses[2].at, 20.0, 1e-9);
  EXPECT_EQ(found.test.courses[1].measured.hours.size(), 5u);  // of one direction of travel
  // in one direction the runs follow each other every 180 s: 0.005 K/s * 2 um/K * 720 s
  EXPECT_NEAR(found.measured[1].range.value, 7.2, 0.3);
  EXPECT_LT(found.left[1].range.value, 0.4);
  EXPECT_NEAR(found.measured[1].range.std, 0.07, 0.03);  // two readings of 0.05 um, where repeats tell so
  EXPECT_LT(found.measured[3].range.value, 0.5);         // the same growth everywhere: no expansion
  ASSERT_EQ(report.temperatures.size(), 2u);
  EXPECT_NEAR(report.temperatures[0].range, 4.45, 1e-9);  // bed: 10 to 900 s
}

TEST(ReportThermal, NothingWhereNoTemperatureChanges) {
  Session session = warmingSession();
  session.temperatures.erase(session.temperatures.begin());
  EXPECT_TRUE(thermalReport(fitted(session)).tests.empty());
}

}  // namespace
}  // namespace mm
