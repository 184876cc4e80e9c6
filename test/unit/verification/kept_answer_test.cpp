#include <gtest/gtest.h>

#include <filesystem>

#include "example_calibration.h"
#include "session_files.h"
#include "verification/verify.h"

namespace mm {
namespace {

TEST(KeptAnswer, StandsWhetherOrNotItCouldBeKept) {
  const test::Folder folder;
  Calibration calibration = test::exampleCalibration();
  calibration.id = "example";
  CalibrationStore store(folder.path("store"));
  Verification found;
  found.verdict = VerifyVerdict::kHelped;
  found.before = {3.12e-6, 0.04e-6};
  found.after = {0.31e-6, 0.03e-6};
  found.observations = 54;
  Session session(Machine::load("three_axis"));
  session.source = "fresh.bag";
  EXPECT_EQ(keepAnswer(store, calibration, session, found), "") << "it is not kept there: nothing to note";
  EXPECT_TRUE(store.verifications().empty());
  store.add(calibration);
  EXPECT_EQ(keepAnswer(store, calibration, session, found), "");
  ASSERT_EQ(store.verifications().size(), 1U);
  EXPECT_EQ(store.verifications()[0].verdict, "helped");
  EXPECT_NEAR(store.verifications()[0].before, 3.12e-6, 1e-11);
  EXPECT_NEAR(store.verifications()[0].afterStd, 0.03e-6, 1e-11);
  EXPECT_EQ(store.verifications()[0].session, "fresh.bag");
  std::filesystem::remove(folder.path("store/verifications"));
  std::filesystem::create_directory(folder.path("store/verifications"));
  EXPECT_NE(keepAnswer(store, calibration, session, found).find("is not stored with the calibration"),
            std::string::npos);
}

}  // namespace
}  // namespace mm
