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

}  // namespace
}  // namespace mm
