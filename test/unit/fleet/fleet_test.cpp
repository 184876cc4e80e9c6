#include "fleet/fleet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "fleet_support.h"

namespace mm {
namespace {

bool says(const Fleet& fleet, const std::string& kind, const std::string& machine,
          const std::string& quantity) {
  return std::any_of(fleet.findings.begin(), fleet.findings.end(), [&](const Finding& f) {
    return f.kind == kind && f.machine == machine && f.quantity.find(quantity) != std::string::npos;
  });
}

TEST(Fleet, twoHundredQuietMachinesRaiseHardlyAnAlarm) {
  int alarms = 0;
  constexpr int kFleets = 10;
  for (std::uint64_t seed = 1; seed <= kFleets; ++seed) {
    const Fleet fleet = fleetOf(MadeUpFleet(seed, 200, 10).records, {});
    EXPECT_GT(fleet.questions, 6000.0);
    alarms += !fleet.findings.empty();
  }
  // each with a chance of 0.01: two or more of 10 have a chance of 0.004
  EXPECT_LE(alarms, 1);
}

TEST(Fleet, theWornTheMovedAndTheReturnedAreNamed) {
  MadeUpFleet made(3, 30, 36);
  for (int k = 0; k < made.sessions; ++k) {
    const double share = k / 35.0;
    made.at(4, k).result.parameters[0].value += 2.0 * share;                 // worn
    if (k >= 10) made.at(7, k).result.parameters[1].value += 1.5;            // moved
    if (k < 12 || k >= 24) made.at(9, k).result.parameters[2].value += 2.0;  // repaired, and back
    made.at(11, k).result.parameters[3].value += 9.0;                        // never like its sisters
    if (k < 12 || k >= 24) made.at(13, k).result.found.push_back("{type: lead_screw_periodic, axis: x}");
  }
  const Fleet fleet = fleetOf(made.records, {});
  EXPECT_TRUE(says(fleet, "drifts", "m005", "axis: a0"));
  EXPECT_TRUE(says(fleet, "drifts_apart", "m005", "axis: a0"));
  EXPECT_TRUE(says(fleet, "changed", "m008", "axis: a1"));
  EXPECT_TRUE(says(fleet, "came_back", "m010", "axis: a2"));
  EXPECT_TRUE(says(fleet, "apart", "m012", "axis: a3"));
  EXPECT_TRUE(says(fleet, "came_back", "m014", "lead_screw_periodic"));
  for (const Finding& f : fleet.findings)
    EXPECT_TRUE(f.machine == "m005" || f.machine == "m008" || f.machine == "m010" || f.machine == "m012" ||
                f.machine == "m014")
        << f.inWords;
  const auto moved = std::find_if(fleet.findings.begin(), fleet.findings.end(), [](const Finding& f) {
    return f.machine == "m008" && f.kind == "changed";
  });
  EXPECT_EQ(moved->date.substr(0, 7), "2020-11");
  EXPECT_NEAR(moved->after - moved->before, 1.5, 0.2);
}

TEST(Fleet, sensorsThatWentBadAreNamed) {
  MadeUpFleet made(4, 12, 12);
  for (int k = 6; k < 12; ++k) {
    made.at(1, k).result.sensors[0].offset += 2.0;
    made.at(2, k).result.sensors[1].noise = 0.5;
    made.at(3, k).result.sensors[2].span = 0.0;
    made.at(4, k).result.sensors[0].setAside = 15;
    made.at(5, k).result.sensors.pop_back();
  }
  const Fleet fleet = fleetOf(made.records, {});
  EXPECT_TRUE(says(fleet, "sensor", "m002", "offset of sensor s0"));
  EXPECT_TRUE(says(fleet, "sensor", "m003", "noise of sensor s1"));
  EXPECT_TRUE(says(fleet, "sensor", "m004", "sensor s2"));
  EXPECT_TRUE(says(fleet, "sensor", "m005", "sensor s0"));
  EXPECT_TRUE(says(fleet, "sensor", "m006", "sensor s2"));
}

TEST(Fleet, aMachineOfOneSessionIsNotTakenToBeKnownWell) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    MadeUpFleet made(seed, 30, 6);
    made.records.resize(made.records.size() - 5);  // the last machine has one session
    const Fleet fleet = fleetOf(made.records, {});
    EXPECT_TRUE(fleet.findings.empty()) << fleetText(fleet);
  }
}

TEST(Fleet, oneCauseIsToldOnce) {
  MadeUpFleet made(4, 12, 12);
  for (int k = 6; k < 12; ++k) {
    made.at(7, k).result.parameters[0].value += 6.0;  // a step: also a slope, and not what the sisters have
    made.at(1, k).result.sensors[0].offset += 2.0;    // moves the offsets of the others of its machine
    made.at(1, k).result.sensors[1].offset -= 1.0;
    made.at(1, k).result.sensors[2].offset -= 1.0;
  }
  const Fleet fleet = fleetOf(made.records, {});
  ASSERT_EQ(fleet.findings.size(), 2u) << fleetText(fleet);
  EXPECT_TRUE(says(fleet, "changed", "m008", "axis: a0"));
  EXPECT_TRUE(says(fleet, "sensor", "m002", "offset of sensor s0"));
}

TEST(Fleet, oneMachineAndOneParameterCanBeAskedFor) {
  const MadeUpFleet made(5, 6, 8);
  FleetOptions options;
  options.machine = "m002";
  options.parameter = "a3";
  const Fleet fleet = fleetOf(made.records, options);
  ASSERT_EQ(fleet.series.size(), 1u);
  EXPECT_EQ(fleet.series[0].quantity, "gap of {type: backlash, axis: a3}");
  const auto json = nlohmann::json::parse(fleetJson(fleet, true));
  EXPECT_EQ(json["series"][0]["points"].size(), 8u);
  options.parameter = "a99";
  EXPECT_THROW(fleetOf(made.records, options), InputError);
  options.parameter.clear();
  options.machine = "m02";
  EXPECT_THROW(fleetOf(made.records, options), InputError);
}

TEST(Fleet, failedJobsAreListedAndNotCounted) {
  MadeUpFleet made(6, 6, 8);
  made.at(2, 3).result.status = "failed";
  made.at(2, 3).result.failed = "calibrate";
  made.at(2, 3).result.why = "no contacts";
  const Fleet fleet = fleetOf(made.records, {});
  EXPECT_EQ(fleet.done, 47);
  EXPECT_EQ(fleet.failed, 1);
  EXPECT_NE(fleetText(fleet).find("calibrate: no contacts"), std::string::npos);
  EXPECT_NE(fleetPage(fleet).find("no contacts"), std::string::npos);
}

TEST(Fleet, theModelOfMostJobsIsComparedAndTheOthersAreSaid) {
  MadeUpFleet made(6, 6, 8);
  for (int k = 0; k < 4; ++k) made.at(0, k).model = "/data/other.yaml";
  const Fleet fleet = fleetOf(made.records, {});
  EXPECT_EQ(fleet.model, "/data/model.yaml");
  EXPECT_EQ(fleet.otherModels, std::vector<std::string>{"/data/other.yaml"});
  FleetOptions options;
  options.model = "other";
  EXPECT_EQ(fleetOf(made.records, options).done, 4);
}

TEST(FleetPage, holdsNoMarkupOfNamesAndNoLinkToTheNetwork) {
  MadeUpFleet made(7, 6, 8);
  for (int k = 0; k < 8; ++k) made.at(1, k).machine = "<script>alert(1)</script>";
  const std::string page = fleetPage(fleetOf(made.records, {}));
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;"), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos);
  EXPECT_NE(page.find("<svg"), std::string::npos);
}

TEST(FleetCsv, hasALineAParameterOfASession) {
  const std::string csv = fleetCsv(fleetOf(MadeUpFleet(8, 4, 3, 2).records, {}));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4 * 3 * 2);
  EXPECT_NE(csv.find("\"{type: backlash, axis: a1}\""), std::string::npos);
}

TEST(DayOf, countsFrom1970) {
  EXPECT_DOUBLE_EQ(dayOf("1970-01-01T00:00:00Z"), 0.0);
  EXPECT_DOUBLE_EQ(dayOf("2024-02-29T12:00:00Z"), 19782.5);
  EXPECT_TRUE(std::isnan(dayOf("")));
}

}  // namespace
}  // namespace mm
