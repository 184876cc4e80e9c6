// A tracker whose readings come in steps of 3 um (simulated by other physics than the package's: a scale of
// -12 um/m, noise of 1 um).
#include <gtest/gtest.h>

#include "run_mm.h"

namespace mm {
namespace {

// The readings make stairs of the scale: a curve says as much and predicts nothing beside it, which says
// nothing against the scale. It was named, at odds of 1 to 30.
TEST(CoarseReadings, AScaleKeepsItsOdds) {
  const TestFolder work;
  const std::string data = "test/data/stairs_of_a_scale/", machine = data + "machine.urdf";
  const std::string model = work.write("m.yaml", "machine: " + std::filesystem::absolute(machine).string() +
                                                     "\neffects: []\nrepeatability_um: 1.00176\n");
  const std::string session = work / "s.bag", fit = work / "c.yaml";
  ASSERT_EQ(mmRun(work, "import " + data + "contacts.csv --machine " + machine + " -o " + session).status, 0);
  ASSERT_EQ(
      mmRun(work, "calibrate " + session + " --model " + model + " -o " + fit + " --method least_squares")
          .status,
      0);
  const Answer answer = mmRun(work, "diagnose " + session + " --calibration " + fit + " --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  const nlohmann::json d = answer.json();
  ASSERT_FALSE(d["missing"].empty()) << d["sentence"];
  EXPECT_EQ(d["missing"][0]["effect"]["type"], "scale") << d["sentence"];
  EXPECT_GT(d["missing"][0]["odds"].get<double>(), 0.4) << d["sentence"];
}

}  // namespace
}  // namespace mm
