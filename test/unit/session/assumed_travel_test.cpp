#include "session/assumed_travel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "plate_rows.h"
#include "read_contacts.h"
#include "session/artifact_file.h"
#include "session/session_summary.h"
#include "session_files.h"

namespace mm {
namespace {

using test::Folder;
using ::testing::HasSubstr;

class AssumedTravel : public ::testing::Test {
 protected:
  Session read(const std::string& csv, const std::string& machine = "three_axis") const {
    const Artifact plate = parseArtifact(test::plateArtifact(), "plate.yaml");
    return readContactsCsv(folder_.write("c.csv", csv), Machine::load(machine), &plate);
  }
  /// Travel of x, in the order of time, of deviations read at these positions (mm), each `times` times.
  std::vector<double> xTravel(const std::vector<double>& positions, int times = 1,
                              double scatter = 0.0) const {
    std::string csv = "time_s,x_mm,deviation_x_um\n";
    int row = 0;
    for (const double x : positions)
      for (int k = 0; k < times; ++k, ++row)
        csv += std::to_string(row) + "," + std::to_string(x + (row % 2 == 0 ? scatter : -scatter)) + ",1\n";
    return travel(read(csv), 0);
  }
  static std::vector<double> travel(const Session& s, int joint) {
    std::vector<double> all;
    for (const Observation& o : s.observations) all.push_back(o.travel[joint]);
    return all;
  }
  Folder folder_;
};

/// Five times up and down over 21 targets; the ends are overrun and so read twice in a row.
TEST_F(AssumedTravel, OfABidirectionalRunIsThatOfIso230) {
  std::string csv = "time_s,x_mm,deviation_x_um\n";
  std::vector<double> truth;
  int row = 0;
  for (int run = 0; run < 5; ++run)
    for (const double sign : {1.0, -1.0})
      for (int i = 0; i < 21; ++i) {
        csv += std::to_string(10 * row++) + "," + std::to_string(sign * (-20 + 2 * i)) + ",3\n";
        truth.push_back(sign);
      }
  const Session s = read(csv);
  EXPECT_EQ(travel(s, 0), truth);
  EXPECT_EQ(travel(s, 1), std::vector<double>(210, 0.0)) << "y never moved";
  ASSERT_EQ(s.assumed.size(), 1u);
  EXPECT_EQ(s.assumed[0].joint, "x");
  EXPECT_EQ(s.assumed[0].how, "from the order of positions");
  EXPECT_EQ(s.assumed[0].share, 1.0);
  EXPECT_TRUE(std::isnan(s.observations[3].velocity[0])) << "a speed is not made up";
  EXPECT_THAT(assumedText(s), HasSubstr("from the order of positions (x in 100 %)"));
}

TEST_F(AssumedTravel, OfSeveralReadingsATarget) {
  EXPECT_EQ(
      xTravel({0, 5, 10, 10, 5, 0, 0, 5}, 3, 2e-3),
      (std::vector<double>{1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 1, 1, 1, 1, 1, 1}))
      << "2 um of scatter is no motion";
  EXPECT_EQ(xTravel({0, 5, 10, 5, 0}, 3),
            (std::vector<double>{0, 0, 0, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1}))
      << "read as often at the turning point as elsewhere: it was not overrun";
}

TEST_F(AssumedTravel, OfSingleReadingsIsTheSignOfTheChange) {
  EXPECT_EQ(xTravel({0, 10, 20, 10, 0, 10}), (std::vector<double>{0, 1, 1, -1, -1, 1}));
  EXPECT_EQ(xTravel({3, -7, 12, 4, 19, -2}), (std::vector<double>{0, -1, 1, -1, 1, -1})) << "in any order";
}

/// After a return over all targets nobody knows whether the first was overrun: not guessed.
TEST_F(AssumedTravel, OfOneSidedRunsIsOpenWhereTheyBegin) {
  EXPECT_EQ(xTravel({0, 5, 10, 15, 0, 5, 10, 15, 0, 5, 10, 15}),
            (std::vector<double>{0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1}));
}

/// A raster: at its ends x stands while y moves on; that is no second reading of a target.
TEST_F(AssumedTravel, OfARasterKeepsTheLastMotion) {
  std::string csv = "time_s,x_mm,y_mm,reference_x_mm,reference_y_mm,reference_z_mm\n";
  int row = 0;
  for (int y = 0; y < 3; ++y)
    for (int i = 0; i < 4; ++i) {
      const int x = 5 * (y % 2 == 0 ? i : 3 - i);
      csv += std::to_string(row++) + "," + std::to_string(x) + "," + std::to_string(5 * y) + "," +
             std::to_string(x) + "," + std::to_string(5 * y) + ",0\n";
    }
  const Session s = read(csv);
  EXPECT_EQ(travel(s, 0), (std::vector<double>{0, 1, 1, 1, 1, -1, -1, -1, -1, 1, 1, 1}));
  EXPECT_EQ(travel(s, 1), (std::vector<double>{0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1}));
}

TEST_F(AssumedTravel, IsNotInventedWhereAVelocityWasRecorded) {
  const Session s = read("time_s,x_mm,y_mm,x_velocity_mm_s,deviation_x_um\n0,0,0,,1\n1,5,5,1,1\n2,9,9,,1\n");
  EXPECT_EQ(travel(s, 0), (std::vector<double>{0, 1, 0})) << "of x one is known";
  EXPECT_EQ(travel(s, 1), (std::vector<double>{0, 1, 1})) << "of y none was recorded";
  ASSERT_EQ(s.assumed.size(), 1u);
  EXPECT_EQ(s.assumed[0].joint, "y");
}

/// A machine stands at each reading: that its velocity is zero there says nothing of how it came.
TEST_F(AssumedTravel, IsThatOfTheOrderWhereAllVelocitiesAreZero) {
  const Session s = read("time_s,x_mm,x_velocity_mm_s,deviation_x_um\n0,0,0,1\n1,5,0,1\n2,9,0,1\n3,5,0,1\n");
  EXPECT_EQ(travel(s, 0), (std::vector<double>{0, 1, 1, -1}));
}

/// A touch without velocity and approach: the tip moved square to the ball.
TEST_F(AssumedTravel, OfATouchIsIntoTheSurface) {
  const std::vector<test::PlateRow> rows = test::plateRows();
  const Session known = read(test::plateCsv(rows, true)), assumed = read(test::plateCsv(rows, false));
  EXPECT_TRUE(known.assumed.empty());
  int clear = 0, wrong = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (int j = 0; j < 3; ++j) {
      if (std::abs(rows[i].velocity[j]) < 0.2) continue;  // a tenth of the motion
      ++clear;
      wrong += assumed.observations[i].travel[j] != known.observations[i].travel[j];
    }
  EXPECT_GT(clear, 1700);
  EXPECT_EQ(wrong, 0);
  ASSERT_EQ(assumed.assumed.size(), 6u);
  EXPECT_EQ(assumed.assumed[0].how, "from the approach of the contact");
  EXPECT_GT(assumed.assumed[0].share, 0.85);
  EXPECT_NEAR(assumed.assumed[0].share + assumed.assumed[1].share, 1.0, 0.01);
}

/// A touch by one axis: the others came to their places on the way there, whatever they did at touches
/// before.
TEST_F(AssumedTravel, OfAnAxisThatStandsAtATouchIsThatOfItsWay) {
  const Session s = read(
      "time_s,x_mm,x_velocity_mm_s,y_mm,y_velocity_mm_s,z_mm,z_velocity_mm_s,feature\n"
      "0,-4,3,-8,0,3,0,b1\n5,2,0,-12,3,3,0,b1\n9,-3,0,-12,3,3,0,b1\n12,-3,0,-5,-3,3,0,b1\n");
  EXPECT_EQ(travel(s, s.machine.findJoint("x")), (std::vector<double>{1, 1, -1, -1}));
  ASSERT_EQ(s.assumed.size(), 1u);
  EXPECT_EQ(s.assumed[0].joint, "x");
  EXPECT_EQ(s.assumed[0].how, "from the order of positions");
  EXPECT_DOUBLE_EQ(s.assumed[0].share, 0.75);
}

/// The same at readings of an instrument, of which one alone was read in motion.
TEST_F(AssumedTravel, OfAnAxisThatStandsAtAnInstrumentIsThatOfItsWay) {
  const Session s = read("time_s,x_mm,x_velocity_mm_s,deviation_x_um\n0,0,3,1\n1,5,0,1\n2,2,0,1\n3,2,0,1\n");
  EXPECT_EQ(travel(s, 0), (std::vector<double>{1, 1, -1, -1}));
  ASSERT_EQ(s.assumed.size(), 1u);
  EXPECT_DOUBLE_EQ(s.assumed[0].share, 0.75);
}

/// Where the approach was recorded, it counts, not the normal of the ball; rotary joints stand still in it.
TEST_F(AssumedTravel, OfATouchFollowsARecordedApproach) {
  Session s = read("time_s,x_mm,y_mm,z_mm,b_deg,feature\n0,0,-8,3,0,b1\n5,1,-8,3,30,b1\n", "five_axis");
  s.assumed.clear();
  for (Observation& o : s.observations) {
    std::fill(o.travel.begin(), o.travel.end(), 0.0);
    o.approach = Eigen::Vector3d(0.6, 0.0, -0.8);
  }
  assumeTravel(s);
  const int x = s.machine.findJoint("x"), z = s.machine.findJoint("z"), b = s.machine.findJoint("b");
  EXPECT_EQ(s.observations[0].travel[x], -1.0) << "a positive x moves the table";
  EXPECT_EQ(std::abs(s.observations[0].travel[z]), 1.0);
  EXPECT_EQ(s.observations[0].travel[b], 0.0);
  EXPECT_EQ(s.observations[1].travel[b], 1.0) << "turned to the second touch";
  const auto before = s.observations;
  assumeTravel(s);
  EXPECT_EQ(s.observations[1].travel, before[1].travel);
}

TEST_F(AssumedTravel, OfALaserIsNotKnown) {
  const Session s = read("time_s,x_mm,reading_mm,feature\n0,0,1,b1\n5,4,1,b1\n");
  EXPECT_EQ(travel(s, 0), (std::vector<double>{0, 0}));
  EXPECT_TRUE(s.assumed.empty());
}

}  // namespace
}  // namespace mm
