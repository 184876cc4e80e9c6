// A controller that can carry a part of the calibration alone.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "export/export_folder.h"
#include "export/export_page.h"
#include "export/representability.h"
#include "loaded_controller.h"
#include "long_tests.h"
#include "session_files.h"

namespace mm {
namespace {

using namespace test;  // NOLINT: helpers of this test alone

/// What `mm export` writes.
void exportTo(const std::filesystem::path& folder, const Calibration& calibration,
              const std::string& target) {
  const ExportTarget& to = exportTarget(target);
  const NeededCorrection needed(calibration, {});
  const Exported exported = to.write(needed, {});
  Representability judged = representability(calibration, to, {}, needed, exported);
  writeExportFolder(folder, exportFolderOf(calibration, to, needed, exported, judged));
}

/// Every second machine is rough.
std::string roughly(std::uint64_t seed) { return seed / 10 % 2 == 0 ? "" : "drift,correlated"; }

/// The table of the simulated controller that adds what the target does with the tables in `folder`.
std::string tableOf(const std::filesystem::path& folder, const std::string& target,
                    const std::string& sign = {}) {
  const auto interpreter = interpret(target, folder);
  std::string text =
      "x_mm,y_mm,z_mm,x_travel,y_travel,z_travel,correction_x_um,correction_y_um,correction_z_um\n";
  constexpr double kMm = 1e-3;
  for (double x = -20.0; x <= 20.0; x += 10.0)
    for (double y = -15.0; y <= 35.0; y += 12.5)
      for (double z = -20.0; z <= 20.0; z += 10.0)
        for (int way = 0; way < 8; ++way) {
          CommandedState state;
          state.position = {{"x", x * kMm}, {"y", y * kMm}, {"z", z * kMm}};
          state.direction = {{"x", way & 1 ? 1 : -1}, {"y", way & 2 ? 1 : -1}, {"z", way & 4 ? 1 : -1}};
          auto added = interpreter->motors(state);
          for (auto& [axis, motor] : added)
            motor = (sign == axis ? -1.0 : 1.0) * (motor - state.position.at(axis)) * 1e6;
          text += format("%g,%g,%g,%d,%d,%d,%.5f,%.5f,%.5f\n", x, y, z, state.direction["x"],
                         state.direction["y"], state.direction["z"], added["x"], added["y"], added["z"]);
        }
  return text;
}

Verification judged(const LoadedController& controller, const Session& session,
                    const std::filesystem::path& folder) {
  VerifyOptions options;
  options.loaded = true;
  options.calibrate.threads = 1;
  if (!folder.empty())
    options.exported = std::make_shared<const LoadedExport>(folder, controller.calibration);
  return verify(session, controller.calibration, options);
}

TEST(VerifyExport, whatNoTableCarriesIsNoDrift) {
  const std::uint64_t runs = mm_test::longTests() ? 20 : 2;
  for (std::uint64_t seed = 6000; seed < 6000 + 10 * runs; seed += 10) {
    const LoadedController controller(seed, roughly(seed));
    const Folder folder;
    exportTo(folder.path("linuxcnc"), controller.calibration, "linuxcnc");
    const std::string table = tableOf(folder.path("linuxcnc"), "linuxcnc");
    const Session session = controller.measure(seed + 1, table, roughly(seed));
    const Verification v = judged(controller, session, folder.path("linuxcnc"));
    EXPECT_EQ(v.verdict, VerifyVerdict::kHelped) << v.inWords;
    EXPECT_EQ(v.finding, "corrected") << v.inWords;
    EXPECT_FALSE(v.drifted) << v.inWords;
    EXPECT_FALSE(v.moreLeft) << v.inWords;
    // Both squarenesses, 250 and 150 urad, at these points.
    EXPECT_GT(v.notCarried, 0.5e-6) << v.inWords;
    EXPECT_NE(v.inWords.find("do not carry"), std::string::npos) << v.inWords;
    for (const RemainingOfEffect& effect : v.effects) {
      const bool carried = effect.effect.type != "squareness";
      EXPECT_NEAR(effect.notCarried, carried ? 0.0 : 1.0, 0.1) << effect.effect.yaml();
      // A machine that wanders does so by a share of an effect.
      if (!carried || (effect.std < 0.2 && roughly(seed).empty())) {
        EXPECT_EQ(effect.inWords, carried ? "corrected" : "no table carries it") << effect.effect.yaml();
      }
    }
    // Without the export nobody can know.
    const Verification blind = judged(controller, session, {});
    EXPECT_TRUE(blind.drifted) << blind.inWords;
    EXPECT_NE(blind.inWords.find("name them with --export"), std::string::npos) << blind.inWords;
  }
}

TEST(VerifyExport, whatIsLoadedWronglyIsSaid) {
  const std::uint64_t seed = 6100;
  const LoadedController controller(seed);
  const Folder folder;
  exportTo(folder.path("linuxcnc"), controller.calibration, "linuxcnc");
  const auto found = [&](int i, const std::string& table,
                         const std::vector<std::string>& errors = loadedErrors()) {
    return judged(controller, controller.measure(seed + static_cast<std::uint64_t>(i), table, {}, errors),
                  folder.path("linuxcnc"));
  };
  const std::string right = tableOf(folder.path("linuxcnc"), "linuxcnc");
  const Verification none = found(1, {});
  EXPECT_EQ(none.finding, "not_corrected") << none.inWords;
  EXPECT_EQ(none.verdict, VerifyVerdict::kNoChange) << none.inWords;
  const Verification wrong = found(2, tableOf(folder.path("linuxcnc"), "linuxcnc", "y"));
  EXPECT_EQ(wrong.finding, "partly") << wrong.inWords;
  EXPECT_NE(wrong.inWords.find("y has the wrong sign"), std::string::npos) << wrong.inWords;
  const Verification later = found(3, right, loadedErrors(5.0, 80.0));
  EXPECT_EQ(later.finding, "corrected") << later.inWords;
  EXPECT_TRUE(later.drifted) << later.inWords;
  for (const ChangedEffect& c : later.changed) EXPECT_NE(c.effect.type, "squareness") << later.inWords;
}

TEST(VerifyExport, ofOtherFoldersIsRefused) {
  const LoadedController controller(6200);
  const Folder folder;
  const auto refusal = [&](const Calibration& calibration) {
    return messageOf<InputError>([&] { LoadedExport(folder.path("out"), calibration); });
  };
  EXPECT_NE(refusal(controller.calibration).find("holds no representability.json"), std::string::npos);
  exportTo(folder.path("out"), controller.calibration, "linuxcnc");
  EXPECT_EQ(refusal(controller.calibration), "");
  Calibration other = controller.calibration;
  other.id = "other";
  EXPECT_NE(refusal(other).find("was made of calibration 'test', not of 'other'"), std::string::npos);
  VerifyOptions options;
  options.exported = std::make_shared<const LoadedExport>(folder.path("out"), controller.calibration);
  const Session session = controller.measure(6201, {});
  EXPECT_NE(messageOf<InputError>([&] { verify(session, controller.calibration, options); }).find("--loaded"),
            std::string::npos);
  folder.write("out/representability.json", "{");
  EXPECT_NE(refusal(controller.calibration).find("is not what mm export writes"), std::string::npos);
}

}  // namespace
}  // namespace mm
