#include "drivers/linuxcnc_state.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.h"

namespace mm {
namespace {

const char* const kLine =
    R"({"time": 2.5, "within": 0.001, "echo": 17, "lapses": 0, "busy": false, "emergency": false, "on": true,
        "homed": [true, false], "limits": [0, -1], "actual": [10, 5, -16.06, 0, 0, 0],
        "commanded": [10, 5, -16.061, 0, 0, 0], "axes": 31, "linear": 1.0, "angular": 1.0, "probe": true,
        "tripped": true, "probed": [10, 5, -16.05, 0, 0, 0], "override": 0.5,
        "said": ["Linear move would exceed X's limit"]})";

TEST(LinuxCncState, ReadsWhatTheHelperTells) {
  const LinuxCncLine line = parseLinuxCncLine(kLine);
  ASSERT_EQ(line.kind, LinuxCncLine::Kind::kState);
  EXPECT_EQ(line.state.actual, (std::vector<double>{10, 5, -16.06, 0, 0, 0}));
  EXPECT_EQ(line.state.homed, (std::vector<bool>{true, false}));
  EXPECT_EQ(line.state.limits, (std::vector<std::int64_t>{0, -1}));
  EXPECT_EQ(line.state.said.size(), 1u);
  EXPECT_TRUE(line.state.on && line.state.probe && line.state.tripped && !line.state.busy);
  const LinuxCncLine taken = parseLinuxCncLine(R"({"taken": 3, "serial": 18})");
  EXPECT_EQ(taken.kind, LinuxCncLine::Kind::kTaken);
  EXPECT_EQ(taken.taken, 3);
  EXPECT_EQ(taken.serial, 18);
  EXPECT_EQ(parseLinuxCncLine(R"({"trouble": "no LinuxCNC"})").trouble, "no LinuxCNC");
}

// A state that lacks something, or in which something is no such value, is none.
TEST(LinuxCncState, ALineThatIsNotWholeIsRefused) {
  const nlohmann::json whole = nlohmann::json::parse(kLine);
  for (const auto& [key, value] : whole.items()) {
    nlohmann::json line = whole;
    line.erase(key);
    EXPECT_THROW(parseLinuxCncLine(line.dump()), Error) << "without " << key;
    line[key] = nullptr;
    EXPECT_THROW(parseLinuxCncLine(line.dump()), Error) << key;
    line[key] = "1";
    EXPECT_THROW(parseLinuxCncLine(line.dump()), Error) << key;
  }
  for (const char* line :
       {"", "{}", "[]", "7", "{\"time\": NaN}", "\x01\xff", "{\"taken\": 1.5, \"serial\": 2}"})
    EXPECT_THROW(parseLinuxCncLine(line), Error) << line;
  nlohmann::json line = whole;
  line["actual"] = {1.0, 2.0};
  EXPECT_THROW(parseLinuxCncLine(line.dump()), Error);
  line = whole;
  line["echo"] = 1e300;
  EXPECT_THROW(parseLinuxCncLine(line.dump()), Error);
}

}  // namespace
}  // namespace mm
