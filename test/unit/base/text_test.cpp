#include "base/text.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

TEST(Text, TrimTakesBlanksAtTheEndsOnly) {
  EXPECT_EQ(trim(" \t a b\r\n"), "a b");
  EXPECT_EQ(trim("ab"), "ab");
  EXPECT_EQ(trim(" \t"), "");
  EXPECT_EQ(trim(""), "");
  EXPECT_EQ(trim("\" x \"", " \""), "x");
}

TEST(Text, LowerKnowsUmlautsAndLeavesOtherBytes) {
  EXPECT_EQ(lower("PRÜFER ÄÖ x_MM"), "prüfer äö x_mm");
  EXPECT_EQ(lower("µm ×"), "µm ×");  // a multiplication sign stands among the capitals and is no letter
  EXPECT_EQ(lower("\xC3"), "\xC3");
}

TEST(Text, StartsAndEnds) {
  EXPECT_TRUE(startsWith("time_s", "time"));
  EXPECT_FALSE(startsWith("ti", "time"));
  EXPECT_TRUE(endsWith("time_s", "_s"));
  EXPECT_TRUE(endsWith("_s", "_s"));
  EXPECT_FALSE(endsWith("s", "_s"));
  EXPECT_TRUE(startsWith("", ""));
}

TEST(Text, JoinedPutsTheMarkBetweenAlsoOfEmptyWords) {
  EXPECT_EQ(joined({"a", "b", "c"}, ", "), "a, b, c");
  EXPECT_EQ(joined({"", "b"}, "-"), "-b");
  EXPECT_EQ(joined({}, ", "), "");
}

}  // namespace
}  // namespace mm
