#include "drivers/linuxcnc_protocol.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

TEST(LinuxCncProtocol, ReadsWhatLinuxcncrshSays) {
  const auto line = parseLinuxCncLine("ABS_ACT_POS 10.000000 5.000000 -16.063333");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->word, "ABS_ACT_POS");
  EXPECT_EQ(parseLinuxCncNumbers(line->rest), (std::vector<double>{10.0, 5.0, -16.063333}));
  EXPECT_TRUE(parseLinuxCncNumbers("1.0 nan").empty());
  EXPECT_TRUE(parseLinuxCncNumbers("1.0 2.0x").empty());
  EXPECT_FALSE(parseLinuxCncLine(""));
  EXPECT_FALSE(parseLinuxCncLine(std::string("ESTOP\x01 ON")));
}

// An answer that comes twice does not stand for one that is missing.
TEST(LinuxCncProtocol, ARoundIsCompleteWhenEachAnswerCameOnce) {
  const std::vector<std::string> answers = {
      "ESTOP OFF",         "MACHINE ON",           "JOINT_HOMED YES YES",    "JOINT_LIMIT OK OK",
      "ABS_ACT_POS 1 2",   "ABS_CMD_POS 1 2",      "PROBE_VALUE 0",          "MODE MDI",
      "FEED_OVERRIDE 100", "USER_LINEAR_UNITS MM", "USER_ANGULAR_UNITS DEG", "PROGRAM_STATUS IDLE"};
  const auto roundOf = [&](const std::vector<std::string>& lines) {
    LinuxCncRound round;
    round.asked = 1.0;
    for (const std::string& line : lines) round.take(*parseLinuxCncLine(line));
    return round;
  };
  EXPECT_TRUE(roundOf(answers).complete());
  for (std::size_t missing = 0; missing < answers.size(); ++missing) {
    std::vector<std::string> lines = answers;
    lines[missing] = lines[(missing + 1) % lines.size()];
    EXPECT_FALSE(roundOf(lines).complete()) << answers[missing];
    lines.push_back(answers[missing]);
    EXPECT_FALSE(roundOf(lines).complete()) << "one is of another round";
  }
}

}  // namespace
}  // namespace mm
