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

TEST(Text, EnumeratedPutsAndBeforeTheLast) {
  EXPECT_EQ(enumerated({"a", "b", "c"}), "a, b and c");
  EXPECT_EQ(enumerated({"a", "b"}), "a and b");
  EXPECT_EQ(enumerated({"a"}), "a");
  EXPECT_EQ(enumerated({}), "");
}

TEST(Text, WhatSteersATerminalIsReplaced) {
  EXPECT_EQ(printableText("a\x1b[1mb\x7f\tc\nd"), "a\uFFFD[1mb\uFFFD c d");
  EXPECT_EQ(printableText("a\nb\r\n", true), "a\nb \n");
  EXPECT_EQ(printableText("\xC2\x9B\xC2\xB5m \xC2"), "\uFFFDµm \xC2") << "C1 as UTF-8 writes it; micro stays";
  EXPECT_EQ(printableText(std::string_view("\0x", 2)), "\uFFFDx");
}

TEST(Text, ALongTextIsShownByItsFirstLetters) {
  std::string umlauts;
  for (int i = 0; i < 120; ++i) umlauts += "ä";
  EXPECT_EQ(shownText(umlauts), umlauts);
  EXPECT_EQ(shownText(umlauts + "b"), umlauts + "…");
  EXPECT_EQ(shownText("a\x1b"), "a\uFFFD");
}

}  // namespace
}  // namespace mm
