#include "ros_bridge/bag_session.h"

#include <gtest/gtest.h>

#include "session/artifact_file.h"
#include "session/contacts_csv.h"
#include "session/session_hash.h"
#include "session_files.h"

namespace mm {
namespace {

using test::Folder;

const char* const kPlate = R"(name: plate
pose: free
probe: {tip_radius_mm: 1.0, repeatability_um: 0.3}
expansion_per_K: 11.5e-6
temperature_sensor: bed
balls:
  - {name: b0, centre_mm: [-16.0, -11.0, -5.1], radius_mm: 3.9685, radius_std_um: 0.1, centre_std_um: 0.2}
  - {name: b1, centre_mm: [16.0, 11.0, 5.1], radius_mm: 3.9685, centre: free}
)";

/// Rows out of order, equal times, empty cells, a row that only logs: whatever a CSV can hold.
const char* const kContacts =
    "time_s,feature,x_mm,z_mm,y_mm,x_velocity_mm_s,bed_degC,humidity_percent\n"
    "12.000000001,b1,0.1,0.30000000000000004,1e-7,-1,20.1,\n"
    "12.000000001,b0,0.2,-3.3333333333333335,2,0,20.2,41\n"
    "3.7,b0,1.1,2,-19.999999999999996,1.5,,40.5\n"
    "-5,,,,,,19.7,\n"
    "40,b1,0.7,0,0,,20.9,39\n";

TEST(BagSession, GivesTheSameSessionAsItsCsvToTheBit) {
  const Folder folder;
  const Artifact plate = parseArtifact(kPlate, "plate.yaml");
  const Session csv = readContactsCsv(folder.write("c.csv", kContacts), Machine::load("three_axis"), &plate);
  writeSessionBag(csv, folder.path("s.bag"));
  const Session bag = readSessionBag(folder.path("s.bag"));

  ASSERT_EQ(bag.observations.size(), 4u);
  EXPECT_EQ(sessionHash(bag), sessionHash(csv));
  EXPECT_EQ(bag.observations[0].time, 8.7);
  EXPECT_EQ(bag.observations[1].position[2], 0.30000000000000004 * 1e-3);
  EXPECT_EQ(bag.temperatures.at(0).time.front(), 0.0);
  EXPECT_EQ(bag.temperatures.at(0).value.front(), 19.7);
  EXPECT_EQ(bag.covariates.at(0).unit, "percent");
  EXPECT_EQ(bag.observations[2].travel[0], -1.0) << "at standstill it is that of the last motion";
  EXPECT_EQ(bag.warning, "");
}

}  // namespace
}  // namespace mm
