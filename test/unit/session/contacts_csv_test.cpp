#include "session/contacts_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "base/error.h"
#include "read_contacts.h"
#include "session/artifact_file.h"
#include "session/session_hash.h"
#include "session_files.h"

namespace mm {
namespace {

using test::Folder;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kHalfTurn = 3.14159265358979323846;

Artifact plate() {
  return parseArtifact(
      "name: plate\nballs:\n  - {name: b0, centre_mm: [0, 0, 0], radius_mm: 4}\n"
      "  - {name: b1, centre_mm: [9, 0, 0], radius_mm: 4}\n",
      "plate.yaml");
}

class ContactsCsv : public ::testing::Test {
 protected:
  Session read(const std::string& csv, const std::string& machine = "three_axis") {
    const Artifact artifact = plate();
    return readContactsCsv(folder_.write("c.csv", csv), Machine::load(machine), &artifact);
  }
  Session readWithoutArtifact(const std::string& csv, const std::string& machine = "three_axis") {
    return readContactsCsv(folder_.write("c.csv", csv), Machine::load(machine), nullptr);
  }
  std::string errorOf(const std::string& csv, const std::string& machine = "three_axis") {
    return test::messageOf<InputError>([&] { read(csv, machine); });
  }
  Folder folder_;
};

TEST_F(ContactsCsv, ReadsColumnsInAnyOrderInTheirUnits) {
  const Session s = read(
      "feature, y_mm "
      ",a_deg,time_s,reading_mm,b_velocity_deg_s,bed_degC,air_humidity_percent,x_velocity_mm_s\r\n"
      "b1,2.5,-90,100,1.25,180,21.5,40,-3\r\n",
      "five_axis");
  ASSERT_EQ(s.observations.size(), 1u);
  const Observation& o = s.observations[0];
  const Machine& m = s.machine;
  EXPECT_EQ(o.kind, ObservationKind::kContact);
  EXPECT_EQ(o.row, 2);
  EXPECT_EQ(o.feature, 1);
  EXPECT_DOUBLE_EQ(o.position[m.findJoint("y")], 2.5e-3);
  EXPECT_DOUBLE_EQ(o.position[m.findJoint("a")], -kHalfTurn / 2);
  EXPECT_EQ(o.position[m.findJoint("x")], 0.0) << "a joint without a column stays at 0";
  EXPECT_DOUBLE_EQ(o.velocity[m.findJoint("b")], kHalfTurn);
  EXPECT_EQ(o.travel[m.findJoint("x")], -1.0);
  EXPECT_EQ(o.travel[m.findJoint("y")], 0.0);
  EXPECT_TRUE(std::isnan(o.velocity[m.findJoint("y")]));
  EXPECT_DOUBLE_EQ(o.laserReading, 1.25e-3);
  EXPECT_EQ(o.time, 0.0);
  EXPECT_DOUBLE_EQ(s.epoch, 1e9 + 100);
  ASSERT_EQ(s.temperatures.size(), 1u);
  EXPECT_EQ(s.temperatures[0].name, "bed");
  EXPECT_EQ(s.temperatures[0].at(5.0), 21.5);
  ASSERT_EQ(s.covariates.size(), 1u);
  EXPECT_EQ(s.covariates[0].name, "air_humidity");
  EXPECT_EQ(s.covariates[0].unit, "percent");
}

TEST_F(ContactsCsv, ReadsWhatAnIndependentInstrumentFound) {
  const Session s = readWithoutArtifact(
      "time_s,x_mm,deviation_x_um,deviation_x_std_um,deviation_b_arcsec,reference_z_mm,setup\n"
      "0,400,2,0.5,,,first\n"
      "1,1,-3,,7.2,,second\n"
      "2,1,,,,4.5,\n",
      "five_axis");
  ASSERT_EQ(s.observations.size(), 3u);
  const int x = s.machine.findJoint("x"), b = s.machine.findJoint("b");
  EXPECT_EQ(s.observations[0].kind, ObservationKind::kDeviation);
  EXPECT_DOUBLE_EQ(s.observations[0].position[x], 0.4) << "the limits of motion do not bound import";
  EXPECT_DOUBLE_EQ(s.observations[0].deviation[x], 2e-6);
  EXPECT_DOUBLE_EQ(s.observations[0].deviationStd[x], 0.5e-6);
  EXPECT_TRUE(std::isnan(s.observations[0].deviation[b]));
  EXPECT_DOUBLE_EQ(s.observations[1].deviation[b], 7.2 / 3600 * kHalfTurn / 180);
  EXPECT_TRUE(std::isnan(s.observations[1].deviationStd[x]));
  EXPECT_EQ(s.setups, (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(s.observations[1].setup, 1);
  EXPECT_EQ(s.observations[2].kind, ObservationKind::kPosition);
  EXPECT_EQ(s.observations[2].setup, -1);
  EXPECT_DOUBLE_EQ(s.observations[2].reference.z(), 4.5e-3);
  EXPECT_TRUE(std::isnan(s.observations[2].reference.x()));
}

TEST_F(ContactsCsv, DirectionOfTravelIsThatOfTheLastMotion) {
  const Session s = read(
      "time_s,x_mm,x_velocity_mm_s,feature\n"
      "30,0,0,b0\n"  // third in time
      "10,0,0,b0\n"
      "20,0,-0.5,b0\n"
      "40,0,,b0\n"
      "50,0,0,b0\n");
  std::vector<double> travel;
  for (const Observation& o : s.observations) travel.push_back(o.travel[0]);
  EXPECT_EQ(travel, (std::vector<double>{0, -1, -1, 0, -1}));
}

TEST_F(ContactsCsv, KeepsTheOrderOfEqualTimesAndInterpolatesTemperatures) {
  const Session s = read("time_s,feature,x_mm,bed_degC\n5,b1,1,20\n5,b0,2,\n15,b0,3,30\n10,b1,4,\n");
  EXPECT_EQ(s.observations[0].feature, 1);
  EXPECT_EQ(s.observations[1].feature, 0);
  EXPECT_DOUBLE_EQ(s.temperatures[0].at(s.observations[2].time), 25.0);
  EXPECT_EQ(s.temperatures[0].at(-1.0), 20.0);
  EXPECT_EQ(s.temperatures[0].at(99.0), 30.0);
}

TEST_F(ContactsCsv, ARowMayOnlyLogTemperatures) {
  const Session s = read("time_s,feature,x_mm,bed_degC\n0,,,20\n5,b0,2,\n10,,,30\n");
  EXPECT_EQ(s.observations.size(), 1u);
  EXPECT_DOUBLE_EQ(s.temperatures[0].at(s.observations[0].time), 25.0);
}

struct BadTable {
  const char* what;
  const char* csv;
  const char* line;  // `file:line` in the message
  const char* says;
};
void PrintTo(const BadTable& bad, std::ostream* out) { *out << bad.what; }

class BadContactsCsv : public ContactsCsv, public ::testing::WithParamInterface<BadTable> {};

TEST_P(BadContactsCsv, IsRefusedInOneLineThatNamesTheFault) {
  const BadTable& bad = GetParam();
  const std::string message = errorOf(bad.csv);
  EXPECT_THAT(message, AllOf(HasSubstr(std::string("c.csv") + bad.line), HasSubstr(bad.says)));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Each, BadContactsCsv,
    ::testing::Values(
        BadTable{"unknown column", "time_s,x_mm,featur\n0,0,b0\n", ":1:", "'featur' is unknown"},
        BadTable{"nearest name", "time_s,x_velocty_mm_s,feature\n0,0,b0\n",
                 ":1:", "did you mean 'x_velocity_mm_s'"},
        BadTable{"misspelt, with a unit", "tme_s,x_mm,feature\n0,0,b0\n", ":1:", "did you mean 'time_s'"},
        BadTable{"joint of another machine", "time_s,b_deg,feature\n0,0,b0\n",
                 ":1:", "'b_deg' is unknown on this machine"},
        BadTable{"wrong unit", "time_s,x_um,feature\n0,0,b0\n", ":1:", "wants 'x_mm'"},
        BadTable{"wrong unit of a linear joint", "time_s,x_deg,feature\n0,0,b0\n", ":1:", "wants 'x_mm'"},
        BadTable{"wrong unit of time", "time_ms,x_mm,feature\n0,0,b0\n", ":1:", "wants 'time_s'"},
        BadTable{"wrong unit of a deviation", "time_s,x_mm,deviation_x_mm\n0,0,1\n",
                 ":1:", "wants 'deviation_x_um'"},
        BadTable{"wrong unit of a velocity", "time_s,x_velocity_m_s,feature\n0,0,b0\n",
                 ":1:", "wants 'x_velocity_mm_s'"},
        BadTable{"wrong unit of a temperature", "time_s,bed_degF,feature\n0,0,b0\n", ":1:", "'bed_degC'"},
        BadTable{"no unit", "time_s,x,feature\n0,0,b0\n", ":1:", "wants 'x_mm'"},
        BadTable{"doubled column", "time_s,x_mm,x_mm,feature\n0,0,0,b0\n", ":1:", "'x_mm' is given twice"},
        BadTable{"column without a name", "time_s,,feature\n0,0,b0\n", ":1:", "column 2 has no name"},
        BadTable{"semicolons", "time_s;x_mm;feature\n0;0;b0\n", ":1:", "separated by commas"},
        BadTable{"sensor that cannot be a topic", "time_s,be d_degC,feature\n0,0,b0\n",
                 ":1:", "letters, digits and _"},
        BadTable{"no time", "x_mm,feature\n0,b0\n", ":1:", "'time_s' is missing"},
        BadTable{"NaN", "time_s,x_mm,feature\n0,0,b0\n1,nan,b0\n",
                 ":3:", "column 'x_mm': 'nan' is not a finite number"},
        BadTable{"infinite", "time_s,x_mm,feature\n0,inf,b0\n", ":2:", "not a finite number"},
        BadTable{"text for a number", "time_s,x_mm,feature\n\n0,1.5mm,b0\n",
                 ":3:", "'1.5mm' is not a finite number"},
        BadTable{"number too large", "time_s,x_mm,feature\n0,1e999,b0\n", ":2:", "not a finite number"},
        BadTable{"empty time", "time_s,x_mm,feature\n,1,b0\n", ":2:", "'time_s' is empty"},
        BadTable{"time in milliseconds", "time_s,x_mm,feature\n1700000000000,1,b0\n",
                 ":2:", "is it in seconds"},
        BadTable{"empty reading", "time_s,x_mm,feature\n0,,b0\n", ":2:", "the reading of joint 'x' is empty"},
        BadTable{"unknown feature", "time_s,x_mm,feature\n0,0,b2\n",
                 ":2:", "'b2' is not in artifact 'plate'; did you mean"},
        BadTable{"too few cells", "time_s,x_mm,feature\n0,0\n", ":2:", "2 cells, but the header names 3"},
        BadTable{"nothing measured", "time_s,x_mm,feature\n0,0,\n", ":2:", "the row holds no measurement"},
        BadTable{"two kinds at once", "time_s,feature,deviation_x_um\n0,b0,1\n",
                 ":2:", "leave the others empty"},
        BadTable{"weight of zero", "time_s,deviation_x_um,deviation_x_std_um\n0,1,0\n",
                 ":2:", "must be above 0"},
        BadTable{"open quote", "time_s,feature\n0,\"b0\n", ":2:", "a quote is not closed"},
        BadTable{"empty file", "", ":", "is empty"},
        BadTable{"empty session", "time_s,x_mm,feature\n", ":", "no row holds a measurement"}));

TEST_F(ContactsCsv, ContactsNeedAnArtifact) {
  EXPECT_THAT(test::messageOf<InputError>([&] { readWithoutArtifact("time_s,x_mm,feature\n0,0,b0\n"); }),
              HasSubstr("--artifact"));
}

TEST_F(ContactsCsv, AMissingFileIsNamed) {
  EXPECT_THAT(
      test::messageOf<InputError>([&] { readContactsCsv("no.csv", Machine::load("three_axis"), nullptr); }),
      HasSubstr("no.csv: cannot be read"));
}

TEST_F(ContactsCsv, LongLinesAndAMissingLastBreakAreRead) {
  const std::string name(3 << 20, 'n');  // longer than the reader's buffer
  const Session s = readWithoutArtifact("time_s,deviation_x_um,setup\n0,1,\"" + name + "\"\n1,2.5,s");
  ASSERT_EQ(s.observations.size(), 2u);
  EXPECT_EQ(s.setups[0], name);
  EXPECT_DOUBLE_EQ(s.observations[1].deviation[0], 2.5e-6);
}

TEST_F(ContactsCsv, StatesKeepTheirLinesAndOrder) {
  const StatesCsv states = readStatesCsv(
      folder_.write("s.csv", "time_s,x_mm,y_mm,x_velocity_mm_s,feature\n 9 ,1,,0,b9\n3,2,0,-1,\n"),
      Machine::load("three_axis"), nullptr);
  EXPECT_EQ(states.header, "time_s,x_mm,y_mm,x_velocity_mm_s,feature");
  EXPECT_EQ(states.lines, (std::vector<std::string>{" 9 ,1,,0,b9", "3,2,0,-1,"}));
  const auto& o = states.session.observations;
  ASSERT_EQ(o.size(), 2u);
  EXPECT_EQ(o[0].time, 6.0);
  EXPECT_EQ(o[0].feature, -1);
  EXPECT_EQ(o[0].travel[0], -1.0) << "the second row moved before";
  EXPECT_TRUE(std::isnan(o[0].position[1]));
  EXPECT_EQ(o[0].position[2], 0.0);
}

TEST_F(ContactsCsv, StatesNeedNoTime) {
  const StatesCsv states = readStatesCsv(folder_.write("s.csv", "x_mm,bed_degC\n1,20\n2,30\n"),
                                         Machine::load("three_axis"), nullptr);
  const auto& o = states.session.observations;
  EXPECT_LT(o[1].time, 1e-6);
  EXPECT_EQ(states.session.temperatures[0].at(o[0].time), 20.0);
  EXPECT_EQ(states.session.temperatures[0].at(o[1].time), 30.0);
}

TEST_F(ContactsCsv, TellsProgressAndCanBeCancelled) {
  std::string csv = "time_s,deviation_x_um\n";
  for (int i = 0; i < 20000; ++i) csv += std::to_string(i) + ",1\n";
  const auto path = folder_.write("c.csv", csv);
  double last = -1.0;
  const Machine machine = Machine::load("three_axis");
  readContactsCsv(path, machine, nullptr, [&](double f) {
    EXPECT_GE(f, last);
    last = f;
  });
  EXPECT_EQ(last, 1.0);
  EXPECT_THROW(readContactsCsv(path, machine, nullptr, [](double) { throw Cancelled("stop"); }), Cancelled);
}

TEST_F(ContactsCsv, TheHashTellsSessionsApart) {
  const std::string csv = "time_s,x_mm,feature,bed_degC\n0,1,b0,20\n1,2,b1,21\n";
  const std::string hash = sessionHash(read(csv));
  EXPECT_EQ(hash.size(), 32u);
  EXPECT_EQ(sessionHash(read("feature,time_s,bed_degC,x_mm\nb0,50,20,1\nb1,51,21,2\n")), hash)
      << "neither the order of columns nor the file's time zero matters";
  for (const char* other : {"time_s,x_mm,feature,bed_degC\n0,1,b0,20\n1,2.0000000000000004,b1,21\n",
                            "time_s,x_mm,feature,bed_degC\n0,1,b0,20\n1,2,b0,21\n",
                            "time_s,x_mm,feature,bed_degC\n0,1,b0,20\n1,2,b1,21.1\n",
                            "time_s,x_mm,feature,lid_degC\n0,1,b0,20\n1,2,b1,21\n",
                            "time_s,x_mm,feature,bed_degC\n0,1,b0,20\n1.1,2,b1,21\n",
                            "time_s,y_mm,feature,bed_degC\n0,1,b0,20\n1,2,b1,21\n"})
    EXPECT_NE(sessionHash(read(other)), hash) << other;
}

TEST_F(ContactsCsv, RealFilesAreRead) {
  const auto data = test::sharedData();
  if (data.empty()) {
    std::cout << "no shared data here (set MM_SHARED_DATA): real files not read\n";
    return;
  }
  const std::pair<const char*, std::size_t> axes[] = {{"x", 90}, {"y", 90}, {"z", 50}};
  for (const auto& [axis, rows] : axes)
    EXPECT_EQ(readContactsCsv(data / "iso230_interferometer" / (std::string(axis) + "_axis.csv"),
                              Machine::load("three_axis"), nullptr)
                  .observations.size(),
              rows);
  const Session frame = readContactsCsv(data / "frame_thermal/z_against_temperatures.csv",
                                        Machine::load("three_axis"), nullptr);
  EXPECT_EQ(frame.observations.size(), 990u);
  EXPECT_EQ(frame.temperatures.size(), 3u);
  const Artifact target = loadArtifact(data / "laser_probe_mount/artifact.yaml");
  EXPECT_EQ(readContactsCsv(data / "laser_probe_mount/poses.csv",
                            Machine::load((data / "laser_probe_mount/tracked_head.urdf").string()), &target)
                .observations.size(),
            24u);
  const Artifact centre = loadArtifact(data / "laser_table2/artifact.yaml");
  EXPECT_EQ(readContactsCsv(data / "laser_table2/centres.csv", Machine::load("five_axis"), &centre)
                .observations.size(),
            4u);
}

TEST_F(ContactsCsv, NamesWhatChanges) {
  const Artifact artifact = parseArtifact(
      "name: plate\nprobe: {styli: [{name: A, tip_radius_mm: 1}, {name: B, tip_radius_mm: 2}]}\n"
      "balls:\n  - {name: b0, centre_mm: [0, 0, 0], radius_mm: 4}\n",
      "plate.yaml");
  const auto read = [&](const std::string& csv) {
    return readContactsCsv(folder_.write("c.csv", csv), Machine::load("three_axis"), &artifact);
  };
  const Session s =
      read("time_s,x_mm,feature,placement,stylus\n0,1,b0,flat,B\n1,1,b0,turned,\n2,1,b0,flat,A\n");
  EXPECT_EQ(s.placements, (std::vector<std::string>{"flat", "turned"}));
  EXPECT_EQ(s.observations[1].placement, 1);
  EXPECT_EQ(s.observations[0].stylus, 1);
  EXPECT_EQ(s.observations[1].stylus, 0) << "the first, where none is named";
  EXPECT_TRUE(s.poseFree(0)) << "a placement with a name has a pose of its own";
  EXPECT_TRUE(read("time_s,x_mm,feature,placement\n0,1,b0,\n").placements.empty());
  const auto refusal = [&](const std::string& csv) {
    return test::messageOf<InputError>([&] { read(csv); });
  };
  EXPECT_THAT(refusal("time_s,x_mm,feature,stylus\n0,1,b0,C\n"),
              AllOf(HasSubstr("c.csv:2: stylus 'C' is not in the artifact file"), HasSubstr("A, B")));
  EXPECT_EQ(read("time_s,x_mm,deviation_x_um,stylus\n0,1,1,B\n").observations[0].stylus, 1)
      << "a probe that is changed at one place";
  EXPECT_THAT(errorOf("time_s,x_mm,feature,stylus\n0,1,b0,A\n"), HasSubstr("name it there: probe: {styli:"));
}

}  // namespace
}  // namespace mm
