#include "interpreters/external_offsets.h"

#include <limits>

#include "interpreter_support.h"

namespace mm {
namespace {

using testing::HasSubstr;

/// Two by two by one and a thermometer, mm.
std::string grid(const std::string& base = "0, 0.001, 0.002, 0.005") {
  return R"({"format": "measuring_machine external offsets", "version": 1, "axes": ["x", "y"],
"positions_mm": {"x": [0, 10], "y": [-5, 5]}, "sensors": ["bed"], "reference_degC": {"bed": 20},
"offset_mm": {"x": [)" +
         base + R"(], "y": [0, 0, 0, 0]},
"offset_mm_per_K": {"bed": {"x": [0, 0, 0, 0], "y": [0.001, 0.001, 0.002, 0.002]}}})";
}

CommandedState at(double x, double y) {
  CommandedState state;
  state.position = {{"x", x * 1e-3}, {"y", y * 1e-3}};
  return state;
}

std::string refusal(const std::string& text) {
  TableFolder folder;
  try {
    ExternalOffsets(folder.file("offsets.json", text).path() / "offsets.json");
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(ExternalOffsets, AreMultilinearAndHoldTheEdge) {
  TableFolder folder;
  const ExternalOffsets offsets(folder.file("offsets.json", grid()).path() / "offsets.json");
  EXPECT_NEAR(offsets.at(at(0.0, -5.0)).at("x"), 0.0, 1e-12);
  EXPECT_NEAR(offsets.at(at(0.0, 5.0)).at("x"), 1e-6, 1e-12);  // y is the fastest
  EXPECT_NEAR(offsets.at(at(10.0, -5.0)).at("x"), 2e-6, 1e-12);
  EXPECT_NEAR(offsets.at(at(5.0, 0.0)).at("x"), 2e-6, 1e-12);
  EXPECT_NEAR(offsets.at(at(99.0, 99.0)).at("x"), 5e-6, 1e-12);
}

TEST(ExternalOffsets, GrowWithTheTemperatureAndAMissingOneIsTheReference) {
  TableFolder folder;
  const ExternalOffsets offsets(folder.file("offsets.json", grid()).path() / "offsets.json");
  CommandedState warm = at(10.0, 0.0);
  EXPECT_NEAR(offsets.at(warm).at("y"), 0.0, 1e-12);
  warm.temperature["bed"] = 21.5;
  EXPECT_NEAR(offsets.at(warm).at("y"), 3e-6, 1e-12);
  warm.temperature["bed"] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(offsets.at(warm).at("y"), 0.0, 1e-12);
  CommandedState lost = at(0.0, 0.0);
  lost.position.erase("y");
  EXPECT_THROW(offsets.at(lost), InputError);
}

TEST(ExternalOffsets, ADamagedFileIsRefusedInOneLine) {
  EXPECT_EQ(refusal(grid()), "");
  EXPECT_THAT(refusal("{"), HasSubstr("offsets.json: is not a file of external offsets"));
  EXPECT_THAT(refusal("[]"), HasSubstr("is not a file of external offsets"));
  EXPECT_THAT(refusal(grid("0, 0, 0")), HasSubstr("'offset_mm' of x has 3 values, the grid 4 points"));
  EXPECT_THAT(refusal(grid("0, 0, 0, 7")), HasSubstr("'offset_mm' of x: 7 is not from -1 to 1"));
  EXPECT_THAT(refusal(grid("0, 0, 0, null")), HasSubstr("null"));
}

}  // namespace
}  // namespace mm
