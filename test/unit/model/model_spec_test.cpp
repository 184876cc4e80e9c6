#include "model/model_spec.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"

namespace mm {
namespace {

std::string refusal(const std::string& yaml) {
  try {
    parseModelSpec(yaml, "m.yaml");
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(ModelSpec, understandsTheOlderNameOfSquareness) {
  const ModelSpec spec = parseModelSpec("effects: [{type: cross_talk, axis: x, of: y}]", "m.yaml");
  ASSERT_EQ(spec.effects.size(), 1u);
  EXPECT_EQ(spec.effects[0].yaml(), "{type: squareness, axis: x, of: y}");
}

TEST(ModelSpec, isReadWithTheOrderOfItsKeys) {
  const ModelSpec spec = parseModelSpec(
      "machine: three_axis\n"
      "effects:\n"
      "  - {type: backlash, axis: x}\n"
      "  - type: thermal_bending\n"
      "    sensors: [left, right]\n"
      "    axis: z\n"
      "  - {type: formula, direction: z, formula: 'k1*x*y', start: [1.0, 2e-3]}\n"
      "repeatability_um: 0.3\n",
      "m.yaml");
  EXPECT_EQ(spec.machine, "three_axis");
  EXPECT_DOUBLE_EQ(spec.repeatability, 0.3e-6);
  ASSERT_EQ(spec.effects.size(), 3u);
  EXPECT_EQ(spec.effects[0].text("axis"), "x");
  EXPECT_EQ(spec.effects[1].keys[0].first, "sensors");
  EXPECT_EQ(spec.effects[1].find("sensors")->items, (std::vector<std::string>{"left", "right"}));
  EXPECT_TRUE(spec.effects[1].find("sensors")->list);
  EXPECT_EQ(spec.effects[2].text("formula"), "k1*x*y");
  EXPECT_LT(parseModelSpec("effects: []", "m.yaml").repeatability, 0.0);
}

TEST(ModelSpec, isRefusedWithFileLineAndKey) {
  EXPECT_NE(refusal("machine: a\neffects: []\nefects: []\n")
                .find("m.yaml:3: the model: unknown key 'efects'; did you mean"),
            std::string::npos);
  EXPECT_NE(refusal("effects:\n  - {axis: x}\n").find("m.yaml:2: an effect: 'type' is missing"),
            std::string::npos);
  EXPECT_NE(refusal("effects:\n  - {type: a, axis: x, axis: y}\n").find("'axis' is given twice"),
            std::string::npos);
  EXPECT_NE(refusal("effects:\n  - backlash\n").find("m.yaml:2"), std::string::npos);
  EXPECT_NE(refusal("effects:\n  - {type: a, k: {b: c}}\n").find("'k'"), std::string::npos);
  EXPECT_NE(refusal("effects:\n  - {type: a\nb: }}\n").find("m.yaml:"), std::string::npos);
  EXPECT_NE(refusal("machine: three_axis\n").find("'effects' is missing"), std::string::npos);
  EXPECT_NE(refusal("effects: []\neffects: []\n").find("twice"), std::string::npos);
  EXPECT_NE(refusal("effects: []\nmachine: [a]\n").find("m.yaml:2"), std::string::npos);
  EXPECT_NE(refusal("just text").find("m.yaml:1"), std::string::npos);
  EXPECT_NE(refusal("").find("m.yaml:1"), std::string::npos);
  for (const char* bad : {"0", "-1", "small", ".nan", ".inf", "[1]"})
    EXPECT_NE(refusal("effects: []\nrepeatability_um: " + std::string(bad)).find("m.yaml:2"),
              std::string::npos)
        << bad;
}

TEST(ModelSpec, isLoadedFromAFile) {
  const auto file =
      std::filesystem::temp_directory_path() / ("mm_model_" + std::to_string(::getpid()) + ".yaml");
  std::ofstream(file) << "effects: [{type: scale, axis: x}]\n";
  EXPECT_EQ(loadModelSpec(file).effects.front().type, "scale");
  std::filesystem::remove(file);
  EXPECT_THROW(loadModelSpec(file), InputError);
}

TEST(EffectSpec, isReadFromOneLine) {
  const EffectSpec spec = parseEffectSpec("{type: backlash, axis: x}", "command line");
  EXPECT_EQ(spec.type, "backlash");
  EXPECT_EQ(parseEffectSpec(spec.yaml(), "again"), spec);
  EXPECT_THROW(parseEffectSpec("backlash", "command line"), InputError);
  EXPECT_THROW(parseEffectSpec("{type: [a]}", "command line"), InputError);
  EXPECT_THROW(parseEffectSpec("{type: a, axis: }", "command line"), InputError);
}

}  // namespace
}  // namespace mm
