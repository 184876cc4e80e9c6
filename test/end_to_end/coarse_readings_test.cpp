// A tracker whose readings come in steps of 3 um (simulated by other physics than the package's: a scale of
// -12 um/m, noise of 1 um).
#include <gtest/gtest.h>

#include <vector>

#include "long_tests.h"
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
  int named = 0;
  for (const char* seed :
       mm_test::thoroughTests() ? std::vector<const char*>{"1", "2", "3"} : std::vector<const char*>{"1"}) {
    const Answer answer =
        mmRun(work, "diagnose " + session + " --calibration " + fit + " --json --seed " + seed);
    ASSERT_EQ(answer.status, 0) << answer.error;
    const nlohmann::json d = answer.json();
    for (const auto& m : d["missing"]) {
      EXPECT_EQ(m["effect"]["type"], "scale") << d["sentence"];
      EXPECT_GT(m["odds"].get<double>(), 0.4) << d["sentence"];
      ++named;
    }
  }
  EXPECT_GT(named, 0);  // it, or its curve: that one of them acts is just so sure that one is named
}

}  // namespace
}  // namespace mm
