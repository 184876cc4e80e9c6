#include "fleet/fleet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "fleet_support.h"
#include "long_tests.h"

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

TEST(Fleet, coarseSensorsInQuietRoomsRaiseHardlyAnAlarm) {
  for (const double step : {0.5, 0.1, 0.0625}) {
    int alarms = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed)
      for (const int sessions : {6, 24}) {
        MadeUpFleet made(seed, 50, sessions);
        made.readInSteps(seed + 50, step);
        const Fleet fleet = fleetOf(made.records, {});
        alarms += !fleet.findings.empty();
        for (const Finding& f : fleet.findings)
          EXPECT_EQ(f.inWords.find("is stuck"), std::string::npos) << f.inWords;
      }
    EXPECT_LE(alarms, 1) << "steps of " << step << " K";
  }
}

TEST(Fleet, aSensorIsStuckWhereItMovedBefore) {
  MadeUpFleet made(4, 12, 6);
  const auto still = [&](int machine, int from) {
    for (int k = from; k < 6; ++k) made.at(machine, k).result.sensors[1].span = 0.0;
  };
  still(2, 4);
  still(3, 5);  // one still session
  still(5, 4);  // at two values
  made.at(5, 4).result.sensors[1].mean = 20.5;
  still(7, 4);  // never moved by more than some steps
  for (int k = 0; k < 6; ++k) made.at(7, k).result.sensors[1].step = 0.25;
  std::string stuck;
  for (const Finding& f : fleetOf(made.records, {}).findings)
    if (f.inWords.find("is stuck") != std::string::npos) stuck += f.machine + " " + f.quantity + ";";
  EXPECT_EQ(stuck, "m003 sensor s1;");
}

TEST(Fleet, valuesOfAFitThatDidNotConvergeAreNotUsedAndCounted) {
  MadeUpFleet made(5, 6, 10);
  for (int k = 5; k < 10; ++k) {
    made.at(1, k).result.converged = false;
    for (FleetParameter& p : made.at(1, k).result.parameters) p.value += 50.0;
    made.at(1, k).result.heldOutRms *= 30.0;
  }
  const Fleet fleet = fleetOf(made.records, {});
  EXPECT_TRUE(fleet.findings.empty()) << fleetText(fleet);
  EXPECT_EQ(fleet.open, 5);
  EXPECT_NE(fleetText(fleet).find("5 fits did not converge"), std::string::npos);
  for (const FleetSeries& s : fleet.series) {
    if (s.machine != "m002") continue;
    EXPECT_EQ(s.points.size(), s.kind == SeriesKind::kSensor ? 10u : 5u) << s.quantity;
  }
}

TEST(Fleet, aParameterThatIsAskedForLeavesOutAllOtherFindings) {
  MadeUpFleet made(3, 12, 36);
  for (int k = 0; k < made.sessions; ++k) {
    if (k >= 10) made.at(7, k).result.parameters[1].value += 1.5;
    if (k < 12 || k >= 24) made.at(9, k).result.found.push_back("{type: lead_screw_periodic, axis: x}");
    if (k > 20) made.at(5, k).result.sensors.pop_back();
  }
  EXPECT_EQ(fleetOf(made.records, {}).findings.size(), 3u);
  FleetOptions options;
  for (const char* name : {"axis: a1", "lead_screw", "sensor s2"}) {
    options.parameter = name;
    const Fleet fleet = fleetOf(made.records, options);
    ASSERT_EQ(fleet.findings.size(), 1u) << fleetText(fleet);
    EXPECT_NE(fleet.findings[0].quantity.find(name), std::string::npos);
  }
}

TEST(Fleet, figuresOfAnAngularMachineAreAngles) {
  MadeUpFleet made(6, 4, 6);
  for (FleetRecord& r : made.records) r.result.angular = true;
  for (const FleetSeries& s : fleetOf(made.records, {}).series)
    EXPECT_EQ(s.unit == "urad", s.kind == SeriesKind::kFigure) << s.quantity;
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
    made.at(3, k).result.sensors[2].span = 0.0;  // at one value
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

/// Six monthly sessions of eight machines with three gaps, stated to 0.075 um; sessions scatter by `scatter`
/// beyond that, um.
MadeUpFleet smallFleet(std::uint64_t seed, double scatter) {
  MadeUpFleet made(seed, 8, 6, 3);
  std::mt19937_64 random(seed + 1000);
  std::normal_distribution<double> normal;
  for (int m = 0; m < 8; ++m)
    for (int p = 0; p < 3; ++p) {
      const double own = 2.0 + 0.5 * normal(random);
      for (int k = 0; k < 6; ++k) {
        FleetParameter& gap = made.at(m, k).result.parameters[static_cast<std::size_t>(p)];
        gap.std = 0.075;
        gap.value = own + std::hypot(gap.std, scatter) * normal(random);
      }
    }
  return made;
}

// The gap of one machine is worn by 5 um in half a year, that of another was adjusted by as much.
TEST(Fleet, driftsAndStepsOfSixSessionsAreFoundAndNothingElse) {
  const int fleets = mm_test::thoroughTests() ? 500 : 60;
  for (const double scatter : {0.0, 0.075}) {
    int worn = 0, adjusted = 0, apart = 0, alarms = 0, others = 0;
    for (int f = 1; f <= fleets; ++f) {
      const auto seed = static_cast<std::uint64_t>(f);
      alarms += !fleetOf(smallFleet(seed, scatter).records, {}).findings.empty();
      MadeUpFleet made = smallFleet(seed, scatter);
      for (int k = 0; k < 6; ++k) {
        made.at(2, k).result.parameters[0].value += 1.01 * k;
        made.at(4, k).result.parameters[1].value += k < 3 ? 0.0 : 5.05;
        made.at(6, k).result.parameters[2].value += 30.0;
      }
      const Fleet fleet = fleetOf(made.records, {});
      worn += says(fleet, "drifts", "m003", "axis: a0");
      adjusted += says(fleet, "changed", "m005", "axis: a1");
      apart += says(fleet, "apart", "m007", "axis: a2");
      for (const Finding& finding : fleet.findings)
        others += finding.machine != "m003" && finding.machine != "m005" && finding.machine != "m007";
    }
    const double expected = 0.01 * fleets, bound = expected + 3.0 * std::sqrt(expected) + 1.0;
    EXPECT_LE(alarms, bound) << "scatter " << scatter;
    EXPECT_LE(others, bound) << "scatter " << scatter;
    EXPECT_GE(worn, 0.95 * fleets) << "scatter " << scatter;
    EXPECT_GE(adjusted, 0.8 * fleets) << "scatter " << scatter;
    EXPECT_GE(apart, 0.95 * fleets) << "scatter " << scatter;
  }
}

// Stated uncertainties that are ten times too small are no reason to call machines worn.
TEST(Fleet, uncertaintiesThatAreTooSmallRaiseNoAlarm) {
  const int fleets = mm_test::thoroughTests() ? 500 : 60;
  int alarms = 0;
  for (int f = 1; f <= fleets; ++f)
    alarms += !fleetOf(smallFleet(static_cast<std::uint64_t>(f), 0.75).records, {}).findings.empty();
  const double expected = 0.01 * fleets;
  EXPECT_LE(alarms, expected + 3.0 * std::sqrt(expected) + 1.0);
}

TEST(Fleet, aDriftIsToldWithItsUncertaintyAndChance) {
  MadeUpFleet made(1, 1, 6, 1);
  const double gap[] = {0.94, 2.03, 2.87, 4.02, 4.91, 5.99};
  for (int k = 0; k < 6; ++k) {
    made.at(0, k).result.parameters[0].value = gap[k];
    made.at(0, k).result.parameters[0].std = 0.075;
  }
  const Fleet fleet = fleetOf(made.records, {});
  ASSERT_EQ(fleet.findings.size(), 1u) << fleetText(fleet);
  const Finding& drift = fleet.findings[0];
  EXPECT_EQ(drift.kind, "drifts");
  EXPECT_LT(drift.p, 1e-6);
  EXPECT_NEAR(drift.after - drift.before, 5.02, 0.06);
  EXPECT_NEAR(drift.std, 5.0 * 0.075 / std::sqrt(17.5), 2e-3);  // months are of 28 to 31 days
  EXPECT_NE(drift.inWords.find(" \u00b1 0.18 um (k = 2), from "), std::string::npos) << drift.inWords;
  EXPECT_NE(drift.inWords.find("(p = "), std::string::npos) << drift.inWords;
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

}  // namespace
}  // namespace mm
