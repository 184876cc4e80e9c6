// What is said of a machine that has more errors than its calibration explains, and of unequal rows.
#include <gtest/gtest.h>

#include <cmath>

#include "compensation_support.h"
#include "loaded_controller.h"
#include "read_contacts.h"
#include "session_files.h"
#include "verification/figures.h"
#include "verification/loading_evidence.h"

namespace mm {
namespace {

using namespace test;  // NOLINT: helpers of this test alone

/// Calibrated for little of what is wrong.
const char* const kPoorModel = "effects: [{type: scale, axis: y}, {type: backlash, axis: z}]";

TEST(VerifyFigures, ofAPoorCalibrationHoldWhatItDoesNotExplain) {
  for (const std::uint64_t seed : {4000U, 4010U, 4020U}) {
    const LoadedController controller(seed, "", kPoorModel);
    const double truth = controller.judge(controller.measure(seed + 1, {}), true).after.rms;
    const Verification v = controller.judge(controller.measure(seed + 2, controller.adds), true);
    // The machine without the table, measured on another day.
    EXPECT_NEAR(v.before.rms, truth, 0.1 * truth) << v.inWords;
    EXPECT_LT(v.after.rms, v.before.rms) << v.inWords;
    EXPECT_NE(v.verdict, VerifyVerdict::kWorse) << v.inWords;
    EXPECT_TRUE(v.better) << v.inWords;
  }
}

TEST(VerifyFigures, thatFellAreSaidToFall) {
  for (const std::uint64_t seed : {4000U, 4010U, 4020U}) {
    const LoadedController controller(seed, "", kPoorModel);
    const Verification v = controller.judge(controller.measure(seed + 3, {}), false);
    EXPECT_LT(v.after.rms, v.before.rms - 3.0 * v.before.std) << v.inWords;
    EXPECT_TRUE(v.better) << v.inWords;
    if (!v.drifted) {
      EXPECT_EQ(v.verdict, VerifyVerdict::kHelped) << v.inWords;
    }
  }
}

/// Deviations of x at -20 to 20 mm of a scale of 100 um/m. @param worse standard uncertainty of every second
/// one, um; of the others 0.2.
Session deviations(const std::string& worse) {
  std::string text = "time_s,x_mm,deviation_x_um,deviation_x_std_um\n";
  for (int i = 0; i <= 40; ++i) {
    const double x = -20.0 + i, scatter = 0.1 * std::sin(7.0 * i);
    text += std::to_string(i) + "," + std::to_string(x) + "," + std::to_string(0.1 * x + scatter) + "," +
            (i % 2 == 0 ? "0.2" : worse) + "\n";
  }
  const Folder folder;
  return readContactsCsv(folder.write("deviations.csv", text), Machine::load("three_axis"), nullptr);
}

Calibration scaled() {
  Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("scale").set("axis", "x")});
  c.values[0].value = 1e-4;
  c.domain.sensors.clear();
  c.domain.sensorLower.clear();
  c.domain.sensorUpper.clear();
  c.repeatability = 0.3e-6;
  c.heldOutRms = 0.5e-6;
  return c;
}

TEST(VerifyFigures, countEveryRowInMicrometres) {
  const Session session = deviations("2.0");
  VerifyOptions options;
  options.calibrate.threads = 1;
  const Verification v = verify(session, scaled(), options);
  double square = 0.0;
  for (int i = 0; i <= 40; ++i) square += std::pow(1e-4 * (-0.020 + 0.001 * i), 2);
  ASSERT_EQ(v.axes.size(), 1u);
  EXPECT_NEAR(v.axes[0].size, std::sqrt(square / 41.0), 0.02e-6);
  EXPECT_NEAR(v.effects[0].size, v.axes[0].size, 1e-9);
}

TEST(VerifyFigures, driftOfAnInstrumentsAxisIsSeenWhole) {
  const Session session = deviations("0.2");
  Calibration c = scaled();
  CalibrateOptions options;
  options.threads = 1;
  const auto left = [&] {
    const FreshPoints points(session, c, options, 0);
    return leftUnexplained(points, PointSystem(points, c), c);
  };
  EXPECT_NEAR(left(), 0.4e-6, 1e-9);  // 0.5^2 - 0.3^2
  c.drift = {{"x", 0.3e-6, 20.0}};
  EXPECT_NEAR(left(), std::sqrt(0.07) * 1e-6, 1e-9);
}

}  // namespace
}  // namespace mm
