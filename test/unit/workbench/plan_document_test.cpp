#include "workbench/plan_document.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/read_file.h"
#include "session/plan.h"
#include "session_files.h"

namespace mm {
namespace {

using nlohmann::json;

const Machine& machine() {
  static const Machine m = Machine::load("three_axis");
  return m;
}

json planned(const std::string& yaml) { return json::parse(planDocument(yaml, machine())); }

TEST(PlanDocument, EveryMeasurementStandsWhereThePlanPutsIt) {
  const std::string yaml = readWholeFile("config/demo_plan.yaml", "");
  const json out = planned(yaml);
  const Plan plan = Plan::parse(yaml, "plan", "config", machine());
  EXPECT_EQ(out["text"], yaml);
  EXPECT_EQ(out["name"], "demo_plate");
  EXPECT_EQ(out["measurements"], 120);
  EXPECT_EQ(out["moves"], plan.moves.size());
  EXPECT_EQ(out["left_off"], 0);
  ASSERT_EQ(out["features"].size(), 5u);
  EXPECT_EQ(out["features"][1]["centre_mm"], json({13.0, -8.0, 2.0}));
  ASSERT_EQ(out["feature"].size(), 120u);
  ASSERT_EQ(out["from_mm"].size(), 360u);
  EXPECT_EQ(out["readings"].size(), 360u);
  EXPECT_EQ(out["way_mm"].size(), 3 * plan.moves.size());
  std::size_t n = 0;
  for (const PlanMove& move : plan.moves) {
    if (move.kind != MoveKind::kTouch) continue;
    ASSERT_EQ(out["feature"][n], move.feature);
    EXPECT_EQ(out["line"][n], move.line);
    const json& centre = out["features"][move.feature]["centre_mm"];
    Eigen::Vector3d from, to, c;
    for (int k = 0; k < 3; ++k) {
      from[k] = out["from_mm"][3 * n + k];
      to[k] = out["to_mm"][3 * n + k];
      c[k] = centre[k];
      EXPECT_NEAR(out["readings"][3 * n + k], 1e3 * move.position[k], 1e-3);
    }
    EXPECT_NEAR((to - c).norm(), 3.9685 + 1.0, 1e-3) << "the tip stops at the surface";
    EXPECT_GT((from - c).norm(), (to - c).norm());
    ++n;
  }
  EXPECT_EQ(n, 120u);
}

TEST(PlanDocument, ItsTimeIsThatOfTravelApproachesAndWaits) {
  const auto seconds = [](const std::string& second, const std::string& more) {
    const std::string yaml =
        "name: still\nartifact: {name: a, pose: known, probe: {tip_radius_mm: 1, repeatability_um: 1}, "
        "balls: "
        "[{name: b, centre_mm: [0, 0, -6], radius_mm: 4}]}\nspeeds: {rapid_mm_s: 10, approach_mm_s: 2}\n"
        "moves:\n  - {x_mm: 0, y_mm: 0, z_mm: 10}\n  - {x_mm: 10, y_mm: 0, z_mm: 10" +
        second + "}\n" + more + "touch: {features: all, points: 3}\n";
    return planned(yaml)["time_s"].get<double>();
  };
  const double plain = seconds("", "");
  EXPECT_GT(plain, 1.0);
  EXPECT_NEAR(seconds(", wait_s: 30", ""), plain + 30.0, 1.01);
  const std::string slowlyThereAndBack = "  - {x_mm: -10, speed_mm_s: 2}\n  - {x_mm: 10}\n";
  EXPECT_NEAR(seconds("", slowlyThereAndBack), plain + 10.0 + 2.0, 1.01);
}

TEST(PlanDocument, WhatThePlansReaderRefusesIsRefusedInItsWords) {
  const auto refusal = [](const std::string& yaml) {
    return test::messageOf<InputError>([&] { planDocument(yaml, machine()); });
  };
  EXPECT_NE(refusal(""), "");
  EXPECT_NE(refusal("config/demo_plan.yaml").find("paths are not opened"), std::string::npos);
  EXPECT_NE(refusal("artifact: /etc/passwd\ntouch: {points: 3}").find("a file"), std::string::npos);
  std::string beyond = readWholeFile("config/demo_plan.yaml", "");
  beyond.insert(beyond.find("touch:"), "moves:\n  - {x_mm: 900}\n");
  EXPECT_NE(refusal(beyond).find("limits"), std::string::npos) << refusal(beyond);
}

TEST(PlanDocument, ALongPlanIsDrawnInPart) {
  std::string yaml = readWholeFile("config/demo_plan.yaml", "");
  yaml.replace(yaml.find("points: 24"), 10, "points: 1200");
  const json out = planned(yaml);
  EXPECT_EQ(out["measurements"], 6000);
  EXPECT_EQ(out["feature"].size(), 5000u);
  EXPECT_EQ(out["left_off"], 1000);
}

}  // namespace
}  // namespace mm
