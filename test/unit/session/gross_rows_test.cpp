#include "session/gross_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "plate_rows.h"
#include "read_contacts.h"
#include "session/artifact_file.h"
#include "session/session_hash.h"
#include "session/session_summary.h"
#include "session_files.h"

namespace mm {
namespace {

using test::Folder;
using test::PlateRow;
using ::testing::AllOf;
using ::testing::HasSubstr;

class GrossRows : public ::testing::Test {
 protected:
  Session read(const std::string& csv, const std::string& machine = "three_axis") const {
    const Artifact plate = parseArtifact(test::plateArtifact(), "plate.yaml");
    return readContactsCsv(folder_.write("c.csv", csv), Machine::load(machine), &plate);
  }
  /// What is set aside of deviations of x at these positions (mm).
  std::vector<SetAside> of(const std::vector<double>& positions, const std::string& column = "x_mm",
                           const std::string& machine = "three_axis") const {
    std::string csv = "time_s," + column + ",deviation_x_um\n";
    for (std::size_t i = 0; i < positions.size(); ++i)
      csv += std::to_string(10 * i) + "," + std::to_string(positions[i]) + ",1\n";
    return read(csv, machine).setAside;
  }
  static std::vector<double> repeated(std::vector<double> once, int times) {
    std::vector<double> all;
    for (int k = 0; k < times; ++k) all.insert(all.end(), once.begin(), once.end());
    return all;
  }
  Folder folder_;
};

/// x = -12.364 entered as -1236.4: the session is that without the row, to the bit.
TEST_F(GrossRows, AMistypedReadingIsSetAsideByItsLine) {
  std::vector<PlateRow> rows = test::plateRows();
  const std::size_t typed = 300;
  std::vector<PlateRow> without = rows;
  without.erase(without.begin() + typed);
  rows[typed].position.x() *= 100.0;
  const Session s = read(test::plateCsv(rows, true));
  ASSERT_EQ(s.setAside.size(), 1u);
  EXPECT_EQ(s.setAside[0].row, static_cast<std::int64_t>(typed) + 2);
  EXPECT_EQ(s.setAside[0].field, "x");
  EXPECT_THAT(s.setAside[0].value, HasSubstr(" mm"));
  EXPECT_THAT(
      setAsideText(s, s.setAside[0]),
      AllOf(HasSubstr("line 302 of c.csv: the row is set aside: x = "), HasSubstr("all others are within")));
  Session other = read(test::plateCsv(without, true));
  ASSERT_EQ(s.observations.size(), other.observations.size());
  for (std::size_t i = 0; i < s.observations.size(); ++i) {
    EXPECT_EQ(s.observations[i].position, other.observations[i].position);
    EXPECT_EQ(s.observations[i].time, other.observations[i].time);
  }
  Session again = s;
  again.prepare();
  EXPECT_EQ(sessionHash(again), sessionHash(s));
  EXPECT_EQ(again.setAside.size(), 1u);
  takeBackGrossRows(again);
  EXPECT_EQ(again.observations.size(), rows.size());
  EXPECT_EQ(again.observations[typed].row, s.setAside[0].row) << "back in its place";
}

/// A smaller slip stays within the machine's reach, but not on the ball.
// The same contact at the same time is one contact; one that was touched again is another.
TEST_F(GrossRows, ARowThatIsThereTwiceCountsOnce) {
  const std::vector<PlateRow> rows = test::plateRows();
  std::vector<PlateRow> with = rows;
  with.push_back(rows[17]);
  for (int i = 100; i < 120; ++i) with.push_back(rows[static_cast<std::size_t>(i)]);
  PlateRow again = rows[5];
  again.time += 1e-3;
  with.push_back(again);
  const Session once = read(test::plateCsv(rows, true)), s = read(test::plateCsv(with, true));
  EXPECT_EQ(s.setAside.size(), 21u);
  EXPECT_EQ(s.observations.size(), once.observations.size() + 1);
  const std::vector<std::string> lines = setAsideLines(s);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0],
            "line 677 of c.csv is line 19 of c.csv once more, to the same time and the last digit; it is "
            "used once");
  EXPECT_EQ(lines[3], "18 more rows appear twice and are used once");
  Session prepared = s;
  prepared.prepare();
  EXPECT_EQ(sessionHash(prepared), sessionHash(s));
  EXPECT_EQ(prepared.setAside.size(), 21u);
}

// Before, only a question was asked of it, and the diagnosis of the doubled session was another.
TEST_F(GrossRows, ARunThatIsPastedAtLaterTimesCountsOnce) {
  const std::vector<PlateRow> rows = test::plateRows();
  for (const int copies : {1, 2}) {
    std::vector<PlateRow> with = rows;
    for (int copy = 1; copy <= copies; ++copy)
      for (PlateRow row : rows) {
        row.time += copy * (rows.back().time + 60.0);
        with.push_back(row);
      }
    const Session once = read(test::plateCsv(rows, true)), s = read(test::plateCsv(with, true));
    ASSERT_EQ(s.observations.size(), rows.size()) << copies;
    for (std::size_t i = 0; i < rows.size(); ++i)
      EXPECT_EQ(s.observations[i].time, once.observations[i].time);
    EXPECT_THAT(setAsideLines(s)[0], HasSubstr("line 677 of c.csv is line 2 of c.csv once more, to the last "
                                               "digit, and so are"));
  }
}

// What differs by a temperature was measured again, and a coarse scale repeats itself.
TEST_F(GrossRows, ARunThatWasMeasuredAgainIsNoCopy) {
  const std::vector<PlateRow> rows = test::plateRows();
  std::vector<PlateRow> warm = rows, coarse = rows;
  for (PlateRow& row : coarse)
    for (int j = 0; j < 3; ++j) row.position[j] = 1.25e-3 * std::round(row.position[j] / 1.25e-3);
  const std::vector<PlateRow> once = coarse;
  for (PlateRow row : rows) {
    row.time += rows.back().time + 60.0;
    row.bed += 0.5;
    warm.push_back(row);
  }
  for (PlateRow row : once) {
    row.time += rows.back().time + 60.0;
    coarse.push_back(row);
  }
  EXPECT_TRUE(read(test::plateCsv(warm, true)).setAside.empty());
  EXPECT_TRUE(read(test::plateCsv(coarse, true)).setAside.empty());
}

TEST_F(GrossRows, AReadingThatIsNotNearItsBallIsSetAside) {
  for (const double factor : {10.0, -1.0, 0.1}) {
    std::vector<PlateRow> rows = test::plateRows();
    rows[300].position.y() = rows[300].position.y() * factor;
    const Session s = read(test::plateCsv(rows, true));
    ASSERT_EQ(s.setAside.size(), 1u) << factor;
    EXPECT_EQ(s.setAside[0].row, 302);
    EXPECT_EQ(s.setAside[0].field, "y");
    EXPECT_THAT(s.setAside[0].why, HasSubstr("mm from the centre of 'b3'"));
  }
}

TEST_F(GrossRows, AContactWithAnotherBallsNameIsSetAside) {
  std::vector<PlateRow> rows = test::plateRows();
  ASSERT_EQ(rows[300].feature, "b3");
  rows[300].feature = "b4";
  const Session s = read(test::plateCsv(rows, true));
  ASSERT_EQ(s.setAside.size(), 1u);
  EXPECT_EQ(s.setAside[0].field, "feature");
  EXPECT_EQ(s.setAside[0].value, "b4");
  EXPECT_THAT(s.setAside[0].why,
              AllOf(HasSubstr("from the centre of 'b4'"), HasSubstr("on 'b3'"), HasSubstr("name wrong?")));
}

TEST_F(GrossRows, AnOrdinaryOutlierIsForTheFit) {
  std::vector<PlateRow> rows = test::plateRows();
  rows[300].position.y() += 0.4;  // a burr, a stem
  EXPECT_TRUE(read(test::plateCsv(rows, true)).setAside.empty());
}

TEST_F(GrossRows, AnImpossibleSpeedOrTimeIsSetAside) {
  std::vector<PlateRow> rows = test::plateRows();
  rows[10].velocity.y() = 2e6;
  const Session fast = read(test::plateCsv(rows, true));
  ASSERT_EQ(fast.setAside.size(), 1u);
  EXPECT_EQ(fast.setAside[0].field, "y velocity");

  rows = test::plateRows();
  const Session clean = read(test::plateCsv(rows, true));
  rows[0].time = -8e8;  // the clock was not set yet
  const Session late = read(test::plateCsv(rows, true));
  ASSERT_EQ(late.setAside.size(), 1u);
  EXPECT_EQ(late.setAside[0].field, "time");
  EXPECT_EQ(late.setAside[0].row, 2);
  EXPECT_EQ(late.observations[0].time, 0.0) << "the session begins at the first row that counts";
  EXPECT_NEAR(late.observations[5].time, clean.observations[6].time - clean.observations[1].time, 1e-6);
}

TEST_F(GrossRows, ASensorsErrorCodeIsLeftOutOfItsSeries) {
  for (const double code : {-127.0, 85.0, 2053.0}) {
    std::vector<PlateRow> rows = test::plateRows();
    rows[100].bed = rows[300].bed = code;
    const Session s = read(test::plateCsv(rows, true));
    ASSERT_EQ(s.setAside.size(), 2u) << code;
    EXPECT_EQ(s.setAside[0].field, "temperature bed");
    EXPECT_EQ(s.setAside[0].row, 102);
    EXPECT_EQ(s.observations.size(), rows.size()) << "the contact itself counts";
    EXPECT_NEAR(s.temperatures[0].at(rows[100].time), 0.5 * (rows[99].bed + rows[101].bed), 1e-3);
  }
}

/// What only looks odd.
TEST_F(GrossRows, WhatWasMeantStays) {
  EXPECT_TRUE(of(repeated({0, 500}, 15)).empty()) << "a step gauge";
  std::vector<double> once(30, 0.0);
  for (std::size_t i = 0; i < once.size(); ++i) once[i] = 1e-3 * static_cast<double>(i % 3);
  once.push_back(300.0);
  EXPECT_TRUE(of(once, "x_mm", "five_axis").empty())
      << "its far end visited once, within a machine's travel and more";
  std::vector<double> logarithmic;
  for (int i = 0; i < 24; ++i) logarithmic.push_back(1e-4 * std::pow(2.0, i));
  EXPECT_TRUE(of(logarithmic).empty());
  EXPECT_TRUE(of(repeated({0.001, 0.01, 0.1, 1, 10, 100, 1000}, 5)).empty()) << "decades";
  EXPECT_TRUE(of({0, 0, 0, 0, 0, 0, 0, 4000}).empty()) << "too few to judge";
  EXPECT_TRUE(of(repeated({0, 0, 0, 0, 0, 0, 0, 360, 720}, 4), "b_deg", "five_axis").empty()) << "turns";
  std::vector<double> parked(60, 0.0);
  parked[31] = 35.0;
  EXPECT_TRUE(of(parked).empty()) << "an axis that was moved once";
  std::vector<PlateRow> rows = test::plateRows();
  rows.back().time += 24 * 3600.0;
  EXPECT_TRUE(read(test::plateCsv(rows, true)).setAside.empty()) << "looked at again the next day";
  rows = test::plateRows();
  for (std::size_t i = 600; i < rows.size(); ++i) rows[i].bed = 60.0;
  EXPECT_TRUE(read(test::plateCsv(rows, true)).setAside.empty()) << "the bed was switched on";
  rows = test::plateRows();
  for (PlateRow& r : rows)
    if (r.feature == "b3" || r.feature == "b4") r.feature = r.feature == "b3" ? "b4" : "b3";
  EXPECT_TRUE(read(test::plateCsv(rows, true)).setAside.empty()) << "exchanged names are no single rows";
  for (const double unit : {1.0 / 25.4, 1e-3, 1e3}) {
    rows = test::plateRows();
    for (PlateRow& r : rows) r.position *= unit;
    EXPECT_TRUE(read(test::plateCsv(rows, true)).setAside.empty()) << "another unit is no single row";
  }
}

}  // namespace
}  // namespace mm
