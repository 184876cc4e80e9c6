#include "base/yaml_mapping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/error.h"

namespace mm {
namespace {

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(YamlMapping, refusesAKeyThatIsUnknownDoubledOrMissing) {
  const auto read = [](const std::string& yaml) {
    return refusal([&] {
      const YamlMapping map(YamlMapping::load(yaml, "a.yaml"), "a.yaml", "the plan", {"speed_mm_s", "axis"});
      map.number("speed_mm_s", 1e-3, 0.0, 10.0);
    });
  };
  EXPECT_EQ(read("speed_mm_s: 3\n"), "accepted");
  EXPECT_EQ(read("speed_mm_s: 3\naxes: x\n"),
            "a.yaml:2: the plan: unknown key 'axes'; did you mean 'axis'? (known are speed_mm_s, axis)");
  EXPECT_EQ(read("speed_mm_s: 3\nspeed_mm_s: 4\n"), "a.yaml:2: the plan: key 'speed_mm_s' is given twice");
  EXPECT_EQ(read("axis: x\n"), "a.yaml:1: the plan: 'speed_mm_s' is missing");
  EXPECT_EQ(read("speed_mm_s: 30\n"), "a.yaml:1: the plan: 'speed_mm_s' is 30, but must be from 0 to 10");
  EXPECT_EQ(read("- 1\n"), "a.yaml:1: the plan must be a mapping of keys to values");
  EXPECT_EQ(read("speed_mm_s: [1\n").rfind("a.yaml:", 0), 0u);
}

TEST(YamlMapping, ofAProgramKnowsTheKeysThatAreAskedFor) {
  const auto read = [](const std::string& yaml) {
    return refusal([&] {
      const YamlMapping map =
          YamlMapping::written(YamlMapping::load(yaml, "c.yaml"), "c.yaml", "result", "; do it again");
      map.stored("value");
      for (const YAML::Node& item : map.list("items")) {
        const YamlMapping one = map.item(item, "items", 0);
        one.flag("fixed");
        one.finish();
      }
      map.finish();
    });
  };
  EXPECT_EQ(read("value: .nan\nitems: [{fixed: true}]\n"), "accepted");
  EXPECT_EQ(read("value: 1\nitems: []\nmore: 1\n"), "c.yaml:3: result: unknown key 'more'; do it again");
  EXPECT_EQ(read("value: 1x\nitems: []\n"), "c.yaml:1: result: 'value' must be a number; do it again");
  EXPECT_EQ(read("value: 1\n"), "c.yaml:1: result: 'items' is missing; do it again");
  EXPECT_EQ(read("value: 1\nitems:\n  - {fixed: 1}\n"),
            "c.yaml:3: items[0]: 'fixed' is '1', but must be true or false; do it again");
  EXPECT_EQ(read("value: 1\nitems:\n  - {fixed: true, also: 1}\n"),
            "c.yaml:3: items[0]: unknown key 'also'; do it again");
}

TEST(YamlMapping, readsWhatAProgramWroteToTheLastBit) {
  const YamlMapping map = YamlMapping::written(
      YamlMapping::load("a: 0.1\nb: [.inf, -.inf, .nan, 5e-324]\nc: []\nd: ''\n", "c.yaml"), "c.yaml", "c",
      "");
  EXPECT_EQ(map.stored("a"), 0.1);
  const std::vector<double> b = map.storedList("b");
  ASSERT_EQ(b.size(), 4u);
  EXPECT_TRUE(std::isinf(b[0]) && b[0] > 0.0 && std::isinf(b[1]) && b[1] < 0.0 && std::isnan(b[2]));
  EXPECT_EQ(b[3], 5e-324);
  EXPECT_TRUE(map.storedList("c").empty());
  EXPECT_EQ(map.storedText("d"), "");
}

}  // namespace
}  // namespace mm
