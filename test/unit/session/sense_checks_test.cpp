#include "session/sense_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <functional>
#include <iostream>

#include "plate_rows.h"
#include "read_contacts.h"
#include "session/artifact_file.h"
#include "session_files.h"

namespace mm {
namespace {

using test::Folder;
using test::PlateRow;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class SenseChecks : public ::testing::Test {
 protected:
  Session read(const std::vector<PlateRow>& rows) const {
    const Artifact plate = parseArtifact(test::plateArtifact(), "plate.yaml");
    return readContactsCsv(folder_.write("c.csv", test::plateCsv(rows, false)), Machine::load("three_axis"),
                           &plate);
  }
  /// The only doubt about the plate's rows, each changed.
  Doubt doubt(const std::function<void(PlateRow&)>& change) const {
    std::vector<PlateRow> rows = test::plateRows();
    for (PlateRow& r : rows) change(r);
    const std::vector<Doubt> doubts = sensibleDoubts(read(rows));
    for (const Doubt& d : doubts) std::cout << d.question << "\n";
    EXPECT_EQ(doubts.size(), 1u);
    return doubts.empty() ? Doubt() : doubts[0];
  }
  Folder folder_;
};

TEST_F(SenseChecks, AskNothingOfASensibleSession) {
  EXPECT_TRUE(sensibleDoubts(read(test::plateRows())).empty());
  std::vector<PlateRow> rows = test::plateRows(25e-3);  // 25 um of play
  for (PlateRow& r : rows) {
    r.position.y() += 2e-3 * r.position.x();  // 2 mm/m out of square
    r.bed += 40.0;                            // heated
  }
  Session s = read(rows);
  s.temperatures.push_back({"room", "degC", {0.0}, {21.0}});
  EXPECT_TRUE(sensibleDoubts(s).empty());
}

TEST_F(SenseChecks, AskForKelvinAndFahrenheit) {
  EXPECT_THAT(
      doubt([](PlateRow& r) { r.bed += 273.15; }).question,
      AllOf(StartsWith("temperature bed is 291.6 to 295.6: is it kelvin?"), HasSubstr("degC expected")));
  EXPECT_THAT(doubt([](PlateRow& r) { r.bed = 32.0 + 1.8 * r.bed; }).question,
              AllOf(HasSubstr("is it Fahrenheit?"), HasSubstr("it would be 18.5 to 22.5 degC")));
}

TEST_F(SenseChecks, WhatMustBeAnsweredFirst) {
  EXPECT_TRUE(doubt([](PlateRow& r) { r.bed += 273.15; }).first);
  EXPECT_FALSE(doubt([](PlateRow& r) { r.bed = 32.0 + 1.8 * r.bed; }).first) << "a chamber may be that warm";
  EXPECT_TRUE(doubt([](PlateRow& r) { r.position /= 25.4; }).first);
}

TEST_F(SenseChecks, AskForAReferenceThatIsTheReadingItself) {
  const auto doubts = [&](double reference) {  // of a surface that was probed at many places, mm
    std::string csv = "time_s,x_mm,z_mm,deviation_z_um\n";
    for (int i = 0; i < 20; ++i) {
      const double z = 0.05 * std::sin(1.3 * i);
      csv += std::to_string(i) + "," + std::to_string(5 * i) + "," + std::to_string(z) + "," +
             std::to_string(1e3 * (reference * z - z) + 0.01 * (i % 3)) + "\n";
    }
    return sensibleDoubts(readContactsCsv(folder_.write("z.csv", csv), Machine::load("three_axis"), nullptr));
  };
  ASSERT_EQ(doubts(0.0).size(), 1u);
  EXPECT_TRUE(doubts(0.0)[0].first);
  EXPECT_THAT(doubts(0.0)[0].question,
              StartsWith("the deviations of z are its readings with the other sign"));
  EXPECT_TRUE(doubts(0.99).empty()) << "an instrument that found one per cent of error";
}

TEST_F(SenseChecks, AskForUnitsOfLength) {
  Doubt d = doubt([](PlateRow& r) { r.position /= 25.4; });
  EXPECT_THAT(d.question,
              AllOf(StartsWith("with x_mm, y_mm, z_mm in inches the contacts agree with the artifact within"),
                    HasSubstr(" um instead of "), HasSubstr("are they in inches?")));
  EXPECT_GT(d.before, 5e-3);
  EXPECT_LT(d.after, 5e-6);
  d = doubt([](PlateRow& r) { r.position.x() /= 25.4; });
  EXPECT_THAT(d.question, AllOf(StartsWith("with x_mm in inches"), HasSubstr("is it in inches?")));
  EXPECT_THAT(doubt([](PlateRow& r) { r.position /= 1000.0; }).question,
              StartsWith("with x_mm, y_mm, z_mm in metres"));
  EXPECT_THAT(doubt([](PlateRow& r) { r.position *= 1000.0; }).question,
              StartsWith("with x_mm, y_mm, z_mm in micrometres"));
}

/// A mirror image may be made in several ways; the one that leaves the plate where it lies comes first.
TEST_F(SenseChecks, AskForSignsAndExchangedColumns) {
  Doubt d = doubt([](PlateRow& r) { r.position.x() *= -1.0; });
  EXPECT_THAT(d.question,
              AllOf(StartsWith("with x_mm reversed"), HasSubstr("is its sign wrong?"), HasSubstr("as well")));
  EXPECT_LT(d.after, 0.01 * d.before);
  d = doubt([](PlateRow& r) { std::swap(r.position.x(), r.position.y()); });
  EXPECT_THAT(d.question,
              AllOf(StartsWith("with x_mm and y_mm exchanged"), HasSubstr("are the two mixed up?")));
}

TEST_F(SenseChecks, AskForExchangedNames) {
  const Doubt d = doubt([](PlateRow& r) {
    if (r.feature == "b3" || r.feature == "b4") r.feature = r.feature == "b3" ? "b4" : "b3";
  });
  EXPECT_THAT(d.question, AllOf(StartsWith("with ball 'b3' as 'b4', 'b4' as 'b3'"),
                                HasSubstr("are the names mixed up?")));
  EXPECT_GT(d.before, 1e-3);
  EXPECT_LT(d.after, 5e-6);
  EXPECT_THAT(doubt([](PlateRow& r) {  // three in a round
                if (r.feature == "b0")
                  r.feature = "b5";
                else if (r.feature == "b5")
                  r.feature = "b7";
                else if (r.feature == "b7")
                  r.feature = "b0";
              })
                  .question,
              HasSubstr("are the names mixed up?"));
}

TEST_F(SenseChecks, AskForTheDirectionOfTheApproach) {
  const std::vector<PlateRow> rows = test::plateRows();
  Session s = read(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) s.observations[i].approach = rows[i].velocity.normalized();
  EXPECT_TRUE(sensibleDoubts(s).empty());
  for (Observation& o : s.observations) o.approach = -o.approach;
  ASSERT_EQ(sensibleDoubts(s).size(), 1u);
  EXPECT_THAT(sensibleDoubts(s)[0].question, HasSubstr("is the approach reversed?"));
  for (Observation& o : s.observations) o.approach = -o.approach, o.position[1] = -o.position[1];
  ASSERT_EQ(sensibleDoubts(s).size(), 1u);
  EXPECT_THAT(sensibleDoubts(s)[0].question,
              AllOf(StartsWith("with y_mm reversed"), ::testing::Not(HasSubstr("as well"))));
}

/// A velocity of another sign or column is a backlash of another sign, or a trigger that comes too early.
TEST_F(SenseChecks, AskForVelocitiesThatLeaveTheBall) {
  const auto asked = [&](const std::function<void(Eigen::Vector3d&)>& change) {
    std::vector<PlateRow> rows = test::plateRows(3e-3);
    for (PlateRow& r : rows) change(r.velocity);
    const Artifact plate = parseArtifact(test::plateArtifact(), "plate.yaml");
    const std::vector<Doubt> doubts = sensibleDoubts(readContactsCsv(
        folder_.write("v.csv", test::plateCsv(rows, true)), Machine::load("three_axis"), &plate));
    EXPECT_LE(doubts.size(), 1u);
    return doubts.empty() ? "" : doubts[0].question;
  };
  EXPECT_EQ(asked([](Eigen::Vector3d&) {}), "");
  EXPECT_EQ(asked([](Eigen::Vector3d& v) { v *= 4.0; }), "");
  EXPECT_THAT(
      asked([](Eigen::Vector3d& v) { v.x() *= -1.0; }),
      AllOf(StartsWith("with the velocities of x reversed the tip moves into the balls (mean cosine 1.00"),
            HasSubstr("is the sign of its velocity wrong?")));
  EXPECT_THAT(asked([](Eigen::Vector3d& v) { v *= -1.0; }),
              StartsWith("with the velocities of all joints reversed"));
  EXPECT_THAT(asked([](Eigen::Vector3d& v) { std::swap(v.y(), v.z()); }),
              AllOf(StartsWith("with the velocities of y and z exchanged"), HasSubstr("mixed up?")));
  // a scan moves along the surface
  EXPECT_EQ(asked([](Eigen::Vector3d& v) { v = v.cross(Eigen::Vector3d(0.2, -0.5, 0.8)); }), "");
}

/// Five runs there and back over eleven targets.
TEST_F(SenseChecks, AskForDirectionsAgainstTheOrderOfPositions) {
  const auto asked = [&](const std::function<int(int, int)>& direction) {
    std::string csv = "time_s,x_mm,deviation_x_um,x_velocity_mm_s\n";
    int time = 0;
    for (int run = 0; run < 10; ++run)
      for (int i = 0; i < 11; ++i) {
        const int way = run % 2 == 0 ? 1 : -1, target = way > 0 ? i : 10 - i;
        ++time;
        csv += std::to_string(time) + "," + std::to_string(3 * target) + "," +
               std::to_string(0.01 * ((7 * time) % 5) - way) + "," + std::to_string(direction(way, i)) + "\n";
      }
    const std::vector<Doubt> doubts =
        sensibleDoubts(readContactsCsv(folder_.write("d.csv", csv), Machine::load("three_axis"), nullptr));
    EXPECT_LE(doubts.size(), 1u);
    return doubts.empty() ? "" : doubts[0].question;
  };
  EXPECT_EQ(asked([](int way, int) { return way; }), "");
  EXPECT_EQ(asked([](int, int) { return 1; }), "") << "each target from below";
  EXPECT_EQ(asked([](int, int) { return 0; }), "");
  EXPECT_EQ(asked([](int way, int i) { return i % 3 == 0 ? way : -way; }), "") << "no rule of signs";
  EXPECT_THAT(asked([](int way, int) { return -way; }),
              AllOf(StartsWith("x moved against its recorded direction of travel in 100 of 100 rows"),
                    HasSubstr("is the sign of that direction wrong?")));
}

/// Positions by a tracker: the same questions without a ball.
TEST_F(SenseChecks, AskOfAnInstrumentsPositions) {
  std::string csv = "time_s,x_mm,y_mm,z_mm,reference_x_mm,reference_y_mm,reference_z_mm\n";
  for (int i = 0; i < 40; ++i) {
    const int x = i % 4, y = (i / 4) % 5, z = i / 20;
    char line[200];
    std::snprintf(line, sizeof line, "%d,%.6f,%d,%d,%d,%d,%d\n", i, 5.0 * x / 25.4, 6 * y, 7 * z + x * y,
                  5 * x, 6 * y, 7 * z + x * y);
    csv += line;
  }
  const std::vector<Doubt> doubts =
      sensibleDoubts(readContactsCsv(folder_.write("r.csv", csv), Machine::load("three_axis"), nullptr));
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0].question,
              AllOf(StartsWith("with x_mm in inches"), HasSubstr("agree with the instrument"),
                    HasSubstr("is it in inches?")));
}

/// An angle in radians under a heading in degrees.
TEST_F(SenseChecks, AskForRadians) {
  const Artifact ball = parseArtifact(
      "name: ball\nprobe: {tip_radius_mm: 1.0}\nballs:\n  - {name: s, centre_mm: [0, 0, 0], radius_mm: 10, "
      "centre: free}\n",
      "ball.yaml");
  Session s(Machine::load("five_axis"));
  s.source = s.rowFile = "ball.csv";
  s.artifact = ball;
  const Machine& machine = s.machine;
  const int b = machine.findJoint("b"), a = machine.findJoint("a");
  for (int i = 0; i < 60; ++i) {
    Observation o;
    o.time = i;
    o.row = i + 2;
    o.feature = 0;
    o.position.assign(5, 0.0);
    o.position[b] = 0.4 * (i % 4 - 1.5);
    o.position[a] = 0.3 * (i % 5 - 2.0);
    const double z = 1.0 - (i + 0.5) / 60.0, t = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d contact = 11e-3 * Eigen::Vector3d(t * std::cos(2.4 * i), t * std::sin(2.4 * i), z);
    for (int pass = 0; pass < 3; ++pass) {
      const Eigen::Vector3d off = contact - machine.nominal(o.position.data(), kNotMeasured).position;
      const Eigen::Matrix<double, 6, Eigen::Dynamic> j = machine.jacobian(o.position.data(), kNotMeasured);
      for (int k = 0; k < 5; ++k)
        if (machine.joints()[k].kind == JointKind::kLinear) o.position[k] += off.dot(j.col(k).head<3>());
    }
    s.observations.push_back(o);
  }
  s.prepare();
  EXPECT_TRUE(sensibleDoubts(s).empty());
  for (Observation& o : s.observations)
    for (const int j : {a, b}) o.position[j] *= std::acos(-1.0) / 180.0;
  const std::vector<Doubt> doubts = sensibleDoubts(s);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0].question, AllOf(HasSubstr("in radians"), HasSubstr("are they in radians?")));
}

/// Real sessions, some of machines whose probe is yet to be found: nothing to ask, nothing set aside.
TEST_F(SenseChecks, AskNothingOfRealSessions) {
  const std::filesystem::path data = test::sharedData();
  if (data.empty()) GTEST_SKIP() << "the shared data are not there";
  const auto expectQuiet = [](const Session& s) {
    for (const Doubt& d : sensibleDoubts(s)) ADD_FAILURE() << s.source << ": " << d.question;
    for (const SetAside& a : s.setAside) ADD_FAILURE() << s.source << ": " << a.field << " " << a.why;
  };
  const Machine machine = Machine::load("three_axis");
  for (const char* axis : {"x", "y", "z"})
    expectQuiet(readContactsCsv(data / "iso230_interferometer" / (std::string(axis) + "_axis.csv"), machine,
                                nullptr));
  expectQuiet(readContactsCsv(data / "frame_thermal" / "z_against_temperatures.csv", machine, nullptr));
  for (const auto& [folder, rows, urdf] :
       {std::tuple("laser_probe_mount", "poses.csv", (data / "laser_probe_mount/tracked_head.urdf").string()),
        std::tuple("laser_table2", "centres.csv", std::string("five_axis"))}) {
    const Artifact artifact = loadArtifact(data / folder / "artifact.yaml");
    expectQuiet(readContactsCsv(data / folder / rows, Machine::load(urdf), &artifact));
  }
}

TEST_F(SenseChecks, AreQuick) {
  for (const int perBall : {75, 1812}) {
    std::vector<PlateRow> rows = test::plateRows(0.0, perBall);
    for (PlateRow& r : rows) r.position.x() *= -1.0;
    const Session s = read(rows);
    const std::clock_t start = std::clock();  // of the processor: what else runs on it does not count
    sensibleDoubts(s);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    std::cout << rows.size() << " contacts: " << seconds << " s\n";
    EXPECT_LT(seconds, perBall == 75 ? 4.0 : 30.0)
        << "twenty times what is wanted: what grows with the square of the contacts takes minutes";
  }
}

}  // namespace
}  // namespace mm
