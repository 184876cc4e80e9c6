#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/units.h"
#include "read_contacts.h"
#include "session/sense_checks.h"
#include "session_files.h"

namespace mm {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class RowChecks : public ::testing::Test {
 protected:
  std::vector<std::string> questions(const std::string& csv,
                                     const std::string& machine = "three_axis") const {
    std::vector<std::string> all;
    for (const Doubt& d :
         sensibleDoubts(readContactsCsv(folder_.write("r.csv", csv), Machine::load(machine), nullptr)))
      all.push_back(d.question);
    return all;
  }
  /// Positions in mm times `factor`, deviations of a few um times `scale`, a row every `step` s.
  static std::string run(double factor = 1.0, double scale = 1.0, double step = 10.0) {
    std::string csv = "time_s,x_mm,deviation_x_um\n";
    for (int i = 0; i < 18; ++i)
      csv += std::to_string(step * i) + "," + std::to_string(factor * (-16 + 2 * (i % 17))) + "," +
             std::to_string(scale * (1 + i % 5 + 0.1 * i)) + "\n";
    return csv;
  }
  test::Folder folder_;
};

TEST_F(RowChecks, AnOrdinaryRunRaisesNoQuestion) { EXPECT_THAT(questions(run()), ::testing::IsEmpty()); }

TEST_F(RowChecks, ReadingsInMicrometres) {
  const auto asked = questions(run(1000.0));
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_THAT(asked[0], AllOf(HasSubstr("x is -16000 … 16000 mm"), HasSubstr("from -20 to 20 mm"),
                              HasSubstr("17 of 18 rows"), HasSubstr("divided by 1000 it is within")));
}

TEST_F(RowChecks, BeyondTheTravelByATravelIsNoQuestion) {
  // a URDF of a machine of another size: 40 mm of travel, and readings to 64 mm
  EXPECT_THAT(questions(run(4.0)), ::testing::IsEmpty());
  EXPECT_EQ(questions(run(8.0)).size(), 1u);
}

TEST_F(RowChecks, AMachineOfAnotherSizeIsNoMistakeOfTheUnit) {
  const auto asked = questions(run(25.4));
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_THAT(asked[0],
              AllOf(HasSubstr("is this the machine?"), Not(HasSubstr("divided")), Not(HasSubstr("inch"))));
}

TEST_F(RowChecks, DegreesThatWereCalledRadians) {
  std::string csv = "time_s,b_deg,deviation_b_arcsec\n";
  for (int i = 0; i < 11; ++i)
    csv += std::to_string(i) + "," + std::to_string(57.29578 * (-80 + 16 * i)) + "," + std::to_string(i % 3) +
           "\n";
  const auto asked = questions(csv, "five_axis");
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_THAT(asked[0], AllOf(HasSubstr("from -90 to 90 deg"), HasSubstr("in degrees instead of radians")));
}

/// Readings of x and z of the five-axis machine (0 … 200 and -60 … 60 mm). @param deviation with 0.1 um.
static std::string twoJoints(int xFrom, int zFrom) {
  std::string csv = "time_s,x_mm,z_mm,deviation_x_um\n";
  for (int i = 0; i < 11; ++i)
    csv += std::to_string(i) + "," + std::to_string(xFrom + 11 * i) + "," + std::to_string(zFrom + 10 * i) +
           "," + std::to_string(i) + "\n";
  return csv;
}

TEST_F(RowChecks, ExchangedJointsAreBothBeyondAndWithinWhenExchanged) {
  const auto asked = questions(twoJoints(-55, 100), "five_axis");
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_THAT(asked[0], AllOf(HasSubstr("x is -55 … 55 mm"), HasSubstr("z are both beyond"),
                              HasSubstr("are the two mixed up?")));
  EXPECT_THAT(questions(twoJoints(-55, -50), "five_axis"), ::testing::IsEmpty()) << "one alone is beyond";
  EXPECT_THAT(questions(twoJoints(0, 100), "five_axis"), ::testing::IsEmpty()) << "the other alone is beyond";
}

TEST_F(RowChecks, DeviationsThatArePositionsOrMillimetres) {
  const auto large = questions(run(1.0, 1000.0));
  ASSERT_EQ(large.size(), 1u);
  EXPECT_THAT(large[0], AllOf(HasSubstr("while x moves over 32 mm"), HasSubstr("measured positions")));
  const auto small = questions(run(1.0, 1e-4));
  ASSERT_EQ(small.size(), 1u);
  EXPECT_THAT(small[0], HasSubstr("are they in millimetres?"));
}

TEST_F(RowChecks, TimeThatGoesBack) {
  const auto asked = questions("time_s,x_mm,deviation_x_um\n0,1,1\n10,2,2\n20,3,1\n0,1,2\n10,2,3\n");
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_THAT(asked[0],
              AllOf(HasSubstr("back at 1 place"), HasSubstr("from 20 s to 0 s"), HasSubstr("line 5")));
}

TEST_F(RowChecks, ASortedTableGoesBackAgainAndAgainAndIsNoQuestion) {
  std::string csv = "time_s,x_mm,deviation_x_um\n";
  for (int x = 0; x < 8; ++x)
    for (int k = 0; k < 3; ++k)
      csv += std::to_string(10 * (8 * k + x)) + "," + std::to_string(x) + "," + std::to_string(0.1 * k + x) +
             "\n";
  EXPECT_THAT(questions(csv), ::testing::IsEmpty());
}

TEST_F(RowChecks, AnHourlyLogOfTwoMonthsIsNoQuestion) {
  EXPECT_THAT(questions(run(1.0, 1.0, 3e5)), ::testing::IsEmpty());
}

TEST_F(RowChecks, TimesInMilliseconds) {
  const auto asked = questions(run(1.0, 1.0, 1e7));
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_THAT(asked[0], HasSubstr("are the times in milliseconds"));
}

TEST_F(RowChecks, ARunThatIsThereTwice) {
  std::string rows, csv = "time_s,x_mm,deviation_x_um\n";
  for (int copy = 0; copy < 2; ++copy)
    for (int i = 0; i < 9; ++i)
      csv += std::to_string(10 * (9 * copy + i)) + "," + std::to_string(4 * i - 16) + "," +
             std::to_string(0.37 * ((i * 7) % 5) + 0.013 * i) + "\n";
  const auto asked = questions(csv);
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_THAT(asked[0], AllOf(HasSubstr("9 rows from line 11"), HasSubstr("line 2 of r.csv"),
                              HasSubstr("included twice?")));
}

TEST_F(RowChecks, RepeatedReadingsOfACoarseInstrumentAreNoQuestion) {
  std::string csv = "time_s,x_mm,deviation_x_um\n";
  for (int i = 0; i < 30; ++i) csv += std::to_string(i) + ",5,2\n";
  EXPECT_THAT(questions(csv), ::testing::IsEmpty());
}

// before, of a scale of 0.887 um that reads two runs alike: asked whether a run is there twice, or, of ten
// rows and more, the second run set aside
TEST_F(RowChecks, RunsReadInStepsOfNoRoundNumberAreNoCopies) {
  for (const int rows : {9, 30})
    for (const char* written : {"%d,%d,%.9f\n", "%d,%d,%.6f\n", "%d,%d,%.3f\n"}) {
      std::string csv = "time_s,x_mm,deviation_x_um\n";
      for (int i = 0; i < 2 * rows; ++i) {
        const int place = i % rows;
        char line[80];
        std::snprintf(line, sizeof line, written, 10 * i, place - 16, 0.887352983 * (place * 7 % 10));
        csv += line;
      }
      EXPECT_THAT(questions(csv), ::testing::IsEmpty()) << written;
      const Session session =
          readContactsCsv(folder_.write("r.csv", csv), Machine::load("three_axis"), nullptr);
      EXPECT_EQ(session.observations.size(), 2u * static_cast<std::size_t>(rows)) << written;
    }
}

TEST_F(RowChecks, RealRunsRaiseNone) {
  const auto data = test::sharedData();
  if (data.empty()) return;
  for (const char* axis : {"x", "y", "z"})
    EXPECT_THAT(
        sensibleDoubts(readContactsCsv(data / "iso230_interferometer" / (std::string(axis) + "_axis.csv"),
                                       Machine::load("three_axis"), nullptr)),
        ::testing::IsEmpty())
        << axis;
  EXPECT_THAT(sensibleDoubts(readContactsCsv(data / "frame_thermal/z_against_temperatures.csv",
                                             Machine::load("three_axis"), nullptr)),
              ::testing::IsEmpty());
}

}  // namespace
}  // namespace mm
