#include "workbench/request_body.h"

#include <gtest/gtest.h>

#include <random>

#include "base/error.h"
#include "session_files.h"

namespace mm {
namespace {

std::string refusal(const std::string& json) {
  return test::messageOf<InputError>([&] { RequestBody body(json); });
}

TEST(RequestBody, TextsAndWholeNumbersAreRead) {
  const RequestBody body(R"({"effect": "{type: backlash, axis: x}", "seed": 7, "who": "Ada \u2013"})");
  EXPECT_EQ(body.text("effect"), "{type: backlash, axis: x}");
  EXPECT_EQ(body.number("seed"), 7u);
  EXPECT_EQ(body.text("who"), "Ada \xE2\x80\x93");
  EXPECT_EQ(body.text("absent"), "");
  EXPECT_EQ(body.number("absent"), 0u);
  EXPECT_THROW(body.number("who"), InputError);
  EXPECT_THROW(body.text("seed"), InputError);
  EXPECT_THROW(body.refuseOthers("add", {"effect", "seed"}), InputError);
  EXPECT_NO_THROW(body.refuseOthers("add", {"effect", "seed", "who"}));
}

TEST(RequestBody, WhatIsNotFlatIsRefusedInWords) {
  for (const char* bad : {"",
                          "x",
                          "[",
                          "{",
                          "{}{}",
                          "7",
                          "\"a\"",
                          "null",
                          "[1]",
                          R"({"a": [1]})",
                          R"({"a": {"b": 1}})",
                          R"({"a": null})",
                          R"({"a": true})",
                          R"({"a": -1})",
                          R"({"a": 1.5})",
                          R"({"a": 1e400})",
                          R"({"a": 1, "a": 2})",
                          "{\"a\": \"\xff\"}",
                          R"({"a": "\ud800"})",
                          R"({"a": 1}x)"})
    EXPECT_FALSE(refusal(bad).empty()) << bad;
}

TEST(RequestBody, DepthAndLengthDoNotMatter) {
  EXPECT_FALSE(refusal(std::string(1000000, '[')).empty());
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "{\"a\":";
  EXPECT_FALSE(refusal(deep).empty());
  std::string many = "{";
  for (int i = 0; i < 1000; ++i) many += (i ? ",\"k" : "\"k") + std::to_string(i) + "\":1";
  EXPECT_FALSE(refusal(many + "}").empty());
}

TEST(RequestBody, AnythingIsReadOrRefused) {
  std::mt19937 random(7);
  const std::string letters = "{}[]\",:\\/ 0123456789eE+-.truefalsnu\x80\xc3\xa9\n\t";
  for (int i = 0; i < 50000; ++i) {
    std::string text;
    for (std::size_t k = random() % 24; k > 0; --k) text += letters[random() % letters.size()];
    try {
      RequestBody body(text);
    } catch (const InputError&) {
    }
  }
}

TEST(RequestBody, NamesAreShortAndPrintable) {
  EXPECT_EQ(personsName("Ada\n\x1b[2J"), "Ada[2J");
  EXPECT_EQ(personsName(std::string(99, 'a')).size(), 40u);
  EXPECT_EQ(personsName(std::string(39, 'a') + "\xC3\xA9"), std::string(39, 'a'))
      << "a letter was cut in two";
  EXPECT_EQ(shownFileName("plate\n.bag"), "plate.bag");
  const std::string shown = shownFileName("\xC3\xA9" + std::string(119, 'a') + ".bag");
  EXPECT_EQ(shown, "…" + std::string(116, 'a') + ".bag");
}

}  // namespace
}  // namespace mm
