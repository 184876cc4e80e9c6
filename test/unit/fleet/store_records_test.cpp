#include <gtest/gtest.h>

#include <filesystem>

#include "base/format.h"
#include "calibration_file/calibration_store.h"
#include "example_calibration.h"
#include "fleet/fleet.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class StoreRecords : public testing::Test {
 protected:
  StoreRecords() {
    std::string pattern = (fs::temp_directory_path() / "mm_stores_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~StoreRecords() override { fs::remove_all(folder_); }
  /// Keeps a calibration with a scale of x, in um/m, and as many other effects.
  std::string keep(const std::string& machine, int session, double scale, int effects = 0) {
    Calibration c = test::exampleCalibration();
    const EffectSpec formula = c.effects[1];
    c.effects.resize(1);
    c.values = {{0, "s", "um/m", 1e6, 1e-6 * scale, 1e-6, false}};
    for (int i = 0; i < effects; ++i) c.effects.push_back(formula);
    c.covariance = Eigen::MatrixXd::Constant(1, 1, 1e-12);
    c.networks.clear();
    c.id.clear();
    c.created = format("2026-01-%02dT00:%02d:00Z", session + 1, effects);
    c.sessionHash = format("%04d", session);
    return CalibrationStore(folder_ / machine).add(c);
  }
  fs::path folder_;
};

TEST_F(StoreRecords, theStepsOfOneSessionAreOneSession) {
  for (int effects = 0; effects < 8; ++effects) keep("mill", 0, effects < 4 ? 87.5 : -3.43, effects);
  const std::vector<FleetRecord> records = storeRecords(folder_.string());
  ASSERT_EQ(records.size(), 1u);
  EXPECT_NEAR(records[0].result.parameters.at(0).value, -3.43, 1e-9);  // the last
  EXPECT_TRUE(loadFleet(folder_.string(), {}).findings.empty());
}

TEST_F(StoreRecords, whatWasMadeActiveLastCounts) {
  const std::string first = keep("mill", 0, 10.0), second = keep("mill", 0, 20.0, 1);
  keep("mill", 0, 30.0, 2);
  CalibrationStore store(folder_ / "mill");
  store.promote(second);
  store.promote(first);
  const std::string other = keep("mill", 1, 40.0);
  store.promote(other);
  const std::vector<FleetRecord> records = storeRecords(folder_.string());
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].result.key, first);
  EXPECT_EQ(records[1].result.key, other);
}

TEST_F(StoreRecords, aSessionWithAClockCountsFromWhenItWasMeasured) {
  Calibration c = test::exampleCalibration();
  c.id.clear();
  c.created = "2026-05-20T00:00:00Z";
  c.sessionEpoch = 1767225600.0;
  CalibrationStore(folder_ / "mill").add(c);
  const std::vector<FleetRecord> records = storeRecords(folder_.string());
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].date, "2026-01-01T00:00:00Z");
}

TEST_F(StoreRecords, parametersOfOtherModelsAreNotCompared) {
  for (int session = 0; session < 6; ++session) keep("mill", session, 10.0 + 0.1 * session);
  for (int session = 6; session < 10; ++session) keep("mill", session, 90.0, 1);
  const Fleet fleet = loadFleet(folder_.string(), {});
  EXPECT_EQ(fleet.model, "{type: scale, axis: x}");
  EXPECT_EQ(fleet.done, 6);
  ASSERT_EQ(fleet.otherModels.size(), 1u);
  EXPECT_NE(fleet.otherModels[0].find("formula"), std::string::npos);
  EXPECT_TRUE(fleet.findings.empty()) << fleetText(fleet);
  FleetOptions options;
  options.model = "{type: scale, axis: x}";  // in the other one's name, too, and all of this one's
  EXPECT_EQ(loadFleet(folder_.string(), options).model, fleet.model);
}

}  // namespace
}  // namespace mm
