// Files of instruments, printers and telescopes: each format by its example, with numbers that are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "base/format.h"
#include "base/units.h"
#include "import/import_format.h"
#include "import_support.h"
#include "pan_tilt_session.h"
#include "session/sense_checks.h"
#include "session/session_summary.h"

namespace mm {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Formats : public ::testing::Test {
 protected:
  Imported example(const std::string& name, const std::string& mapping = "") const {
    return importer_.file("examples/import/" + name, mapping);
  }
  std::string refusal(const std::string& name, const std::string& mapping = "") const {
    return test::messageOf<InputError>([&] { example(name, mapping); });
  }
  test::Importer importer_;
};

TEST_F(Formats, EachHasANameOfItsOwnAndTheTableIsLast) {
  std::set<std::string> names;
  for (const ImportFormat& f : importFormats()) EXPECT_TRUE(names.insert(f.name).second) << f.name;
  EXPECT_STREQ(importFormats().back().name, "table");
  EXPECT_THAT(test::messageOf<InputError>([&] { importer_.text("a;b\n0;1\n", "", nullptr, "tpiont"); }),
              HasSubstr("did you mean 'tpoint'"));
}

TEST_F(Formats, Iso230TargetsByRuns) {
  const Imported i = example("iso230_2_x.csv");
  EXPECT_EQ(i.format, "iso230-2");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 70u);
  EXPECT_DOUBLE_EQ(o[0].position[0], -18e-3);
  EXPECT_DOUBLE_EQ(o[0].deviation[0], -2.39e-6);
  EXPECT_EQ(o[0].travel[0], 1.0);
  EXPECT_EQ(o[0].velocity[0], 0.0) << "read at standstill; no speed is made up";
  EXPECT_DOUBLE_EQ(o[7].position[0], 18e-3) << "downwards from the last target";
  EXPECT_EQ(o[7].travel[0], -1.0);
  EXPECT_EQ(o[0].row, 8);
  EXPECT_EQ(o[7].row, 14);
  ASSERT_EQ(i.motion.size(), 70u);
  EXPECT_LT(i.motion[7].velocity[0], 0.0);
  EXPECT_TRUE(i.session->assumed.empty());
  EXPECT_EQ(i.session->setups.size(), 1u);
}

TEST_F(Formats, WithoutTimesTellAnOrderAlone) {
  for (const char* name : {"iso230_2_x.csv", "length_bars_y.csv"}) {
    const Session session = *example(name).session;
    EXPECT_FALSE(session.timesAssumed.empty()) << name;
    EXPECT_FALSE(session.timed(session.observations.back())) << name;
    EXPECT_THAT(assumedText(session), HasSubstr("no times were recorded")) << name;
    EXPECT_GT(session.observations[1].time, session.observations[0].time) << "their order stays: " << name;
  }
}

TEST_F(Formats, Iso230RunsByTargetsWithMeasuredPositions) {
  const Imported i = example("iso230_2_z_by_runs.txt");
  EXPECT_EQ(i.format, "iso230-2");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 30u);
  EXPECT_DOUBLE_EQ(o[0].position[2], -10e-3);
  // 50 um/m too long, 1 um behind
  EXPECT_NEAR(o[0].deviation[2], -0.5e-6 - 1e-6, 1e-11);
  EXPECT_NEAR(o[5].deviation[2], 0.5e-6 + 1e-6, 1e-11);
  EXPECT_EQ(o[5].travel[2], -1.0);
}

TEST_F(Formats, Iso230AsksForAxisAndUnit) {
  EXPECT_THAT(importer_.refusal("Target [mm];1+;1-\n0;1;2\n10;1;2\n20;1;-3\n"), HasSubstr("axis: x"));
  EXPECT_THAT(importer_.refusal("axis: x\nTarget [mm];1+;1-\n0;1;2\n10;1;2\n20;1;-3\n"),
              HasSubstr("unit: um"));
  const Imported i = importer_.text("Target [mm];1+;1-\n0;1;2\n10;1;\n20;1;-3\n", "axis: y\nunit: um\n");
  ASSERT_EQ(i.session->observations.size(), 5u) << "an empty cell is not measured";
  EXPECT_THAT(importer_.refusal("axis: x\nunit: um\nTarget [mm];1+;1-\n0;1;2\n10;one;2\n20;1;-3\n"),
              AllOf(HasSubstr("f.txt:5"), HasSubstr("'one'")));
}

TEST_F(Formats, BallBarRowsAreContactsWithABallOfItsLength) {
  const Imported i = example("ball_bar_xy.csv");
  EXPECT_EQ(i.format, "ballbar");
  const Session& s = *i.session;
  ASSERT_EQ(s.observations.size(), 72u);
  ASSERT_EQ(s.artifact.features.size(), 1u);
  EXPECT_DOUBLE_EQ(s.artifact.features[0].radius, 14e-3);
  EXPECT_NEAR((s.artifact.features[0].position - Eigen::Vector3d(0, 5e-3, 0)).norm(), 0.0, 1e-15);
  for (const Observation& o : s.observations) {
    const double x = o.position[0], y = o.position[1] - 5e-3, r = std::hypot(x, y);
    // 100 urad out of square: 100e-6 · 14 mm · sin φ cos φ beyond the nominal radius, with 0.02 um of noise
    EXPECT_NEAR(14e-3 - r, 100e-6 * 14e-3 * x * y / (r * r), 0.1e-6);
    EXPECT_NEAR(std::hypot(o.velocity[0], o.velocity[1]), 5e-3, 1e-12);
    const double turn = (x * o.velocity[1] - y * o.velocity[0]) > 0.0 ? 1.0 : -1.0;
    EXPECT_EQ(turn, o.row <= 44 ? 1.0 : -1.0) << o.row;
  }
  EXPECT_NEAR(s.observations[1].time, 14.0 * 10 * kDegree / 5.0, 1e-9) << "from the feed";
}

TEST_F(Formats, BallBarByTimeAndItsRefusals) {
  const std::string head =
      "ballbar\nPlane: ZX\nRadius: 10 mm\nFeed: 600 mm/min\nDirection: CW\nStart angle: 90 deg\n";
  const Imported i =
      importer_.text(head + "time [s];radius [mm]\n0;10.001\n1;9.999\n", "centre_mm: [0, 0, 0]\n");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 2u);
  EXPECT_NEAR(o[0].position[0], 9.999e-3, 1e-12) << "the second joint of the plane zx is x";
  EXPECT_NEAR(o[0].position[2], 0.0, 1e-12);
  EXPECT_NEAR(std::atan2(o[1].position[0], o[1].position[2]), kPi / 2 - 1.0, 1e-9);
  EXPECT_THAT(importer_.refusal(head + "time [s];radius [mm]\n0;10\n"), HasSubstr("centre_mm: [0, 0, 0]"));
  const std::string nothing = importer_.refusal("ballbar\nangle [deg];deviation [um]\n0;10\n");
  EXPECT_THAT(nothing, AllOf(HasSubstr("plane: xy"), HasSubstr("radius_mm: 100"), HasSubstr("centre_mm")));
  EXPECT_THAT(importer_.refusal("ballbar\nangle [deg];deviation\n0;10\n10;11\n",
                                "plane: xy\nradius_mm: 100\ncentre_mm: [0, 0]\n"),
              HasSubstr("'deviation' has no unit"));
  EXPECT_THAT(importer_.refusal(head + "time [s];radius [mm]\n0;20\n1;20\n", "centre_mm: [0, 0, 0]\n"),
              HasSubstr("neither close to the nominal"));
}

TEST_F(Formats, AFixedReadingOfNoJointIsRefusedWhateverTheFormat) {
  const std::string ball = "ballbar\nPlane: XY\nRadius: 10 mm\nangle [deg];deviation [um]\n0;10\n90;11\n";
  EXPECT_THAT(importer_.refusal(ball, "fixed: {zz_mm: 5}\n"), HasSubstr("fixed: 'zz_mm' is not"));
  EXPECT_THAT(importer_.refusal(ball, "fixed: {z_deg: 5}\n"), HasSubstr("fixed: 'z_deg' is not"));
  EXPECT_TRUE(importer_.text(ball, "fixed: {z_mm: 5}\ncentre_mm: [0, 0, 5]\n").session);
}

TEST_F(Formats, BallBarWithAHeadOfCommas) {
  const Imported i = importer_.text(
      "Ballbar export\nRadius (mm),100\nFeed rate (mm/min),1000\nPlane,XY\nCentre (mm),0 0 0\n\n"
      "Angle (deg),Radius (mm)\n0,100.0012\n1,100.0013\n2,99.9991\n,\n");
  ASSERT_EQ(i.session->observations.size(), 3u);
  EXPECT_NEAR(i.session->observations[0].position[0], 99.9988e-3, 1e-12);
}

TEST_F(Formats, Iso230FromAGermanLaboratory) {
  const Imported i = importer_.text(
      "Messprotokoll ISO 230-2\r\nAchse: X\r\nAbweichungen in \xb5m\r\n\r\nSollposition [mm];1 vor;1 r\xfc"
      "ck;2 vor;2 r\xfc"
      "ck\r\n0,000;0,1;2,3;0,2;2,2\r\n10,000;-1,5;0,8;-1,4;0,7\r\n-10,000;1;3;1,1;\r\n");
  ASSERT_EQ(i.session->observations.size(), 11u);
  EXPECT_DOUBLE_EQ(i.session->observations[0].position[0], -10e-3);
  EXPECT_NEAR(i.session->observations[2].deviation[0], -1.5e-6, 1e-15);
}

TEST_F(Formats, RunsAreNamedInWords) {
  const Imported i = importer_.text(
      "axis: x\nunit: um\nTarget [mm];1 auf;1 ab;Lauf 2 \u2191;Lauf 2 \u2193;3_up;3_down\n"
      "0;1;2;1;2;1;2\n10;1;2;1;2;1;2\n");
  ASSERT_EQ(i.session->observations.size(), 12u);
  for (std::size_t k = 0; k < 12; ++k)
    EXPECT_EQ(i.session->observations[k].travel[0], k % 4 < 2 ? 1.0 : -1.0) << k;
}

TEST_F(Formats, ARemarkThatNamesTheStandardMakesNoMatrix) {
  const Imported i = importer_.text(
      "# ISO 230-2, Achse X\nx_mm;deviation_x_um;Richtung\n0;1,5;auf\n10;2,5;auf\n10;3,5;ab\n0;2,5;ab\n");
  EXPECT_EQ(i.format, "table");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 4u);
  EXPECT_NEAR(o[1].deviation[0], 2.5e-6, 1e-15);
  EXPECT_EQ(o[1].travel[0], 1.0);
  EXPECT_EQ(o[2].travel[0], -1.0);
}

TEST_F(Formats, StepGaugeAndLengthBars) {
  const Imported i = example("step_gauge_x.txt");
  EXPECT_EQ(i.format, "step-gauge");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 14u);
  EXPECT_NEAR(o[13].position[0], -16e-3 + 23.9977e-3, 1e-7);
  EXPECT_NEAR(o[13].deviation[0], 24e-3 * 1e-4, 0.3e-6) << "true minus indicated: the scale is short";
  EXPECT_EQ(i.session->setups.size(), 1u);

  const Imported bars = example("length_bars_y.csv");
  const auto& b = bars.session->observations;
  ASSERT_EQ(b.size(), 16u) << "four bars, each from its first face, three times";
  EXPECT_EQ(bars.session->setups.size(), 4u);
  EXPECT_EQ(b[0].deviation[1], 0.0);
  EXPECT_DOUBLE_EQ(b[0].position[1], -10e-3);
  EXPECT_NEAR(b[1].deviation[1], 0.21e-6, 1e-14) << "the error of indication with its sign changed";
}

TEST_F(Formats, AGaugeAcrossTheAxesIsRefusedWithTheReason) {
  EXPECT_THAT(importer_.refusal(
                  "step gauge\naxis: XY diagonal\nstart: 0\ncalibrated [mm];indicated [mm]\n0;0\n10;10\n"),
              AllOf(HasSubstr("one artifact with one pose"), HasSubstr("XY diagonal")));
  EXPECT_THAT(importer_.refusal("step gauge\naxis: x\ncalibrated [mm];indicated [mm]\n0;0\n10;10\n"),
              HasSubstr("position_mm: [0, 0, 0]"));
}

TEST_F(Formats, RTestRowsAreTouchesOfOneBall) {
  const test::Importer five("five_axis");
  const Machine& m = five.machine();
  // The nominal machine follows a ball at (100, 80, 5) mm; the tip stands (2, -3, 1) um off, whatever the
  // posture.
  const Eigen::Vector3d ball(100e-3, 80e-3, 5e-3);
  std::string text = "R-test\nX [mm];Y [mm];Z [mm];B [deg];A [deg];dx [um];dy [um];dz [um]\n";
  for (const auto& [b, a] : {std::pair(0.0, 0.0), {30.0, 10.0}, {-60.0, 45.0}, {90.0, -80.0}}) {
    std::vector<double> q(5, 0.0);
    q[m.findJoint("b")] = b * kDegree;
    q[m.findJoint("a")] = a * kDegree;
    for (int pass = 0; pass < 3; ++pass) {
      const Eigen::Vector3d off = ball - m.nominal(q.data(), 0.0).position;
      const Eigen::MatrixXd by = m.jacobian(q.data(), 0.0).topRows<3>();
      for (const char* name : {"x", "y", "z"}) {
        const int j = m.findJoint(name);
        q[j] += by.col(j).dot(off) / by.col(j).squaredNorm();
      }
    }
    text += format("%.9f;%.9f;%.9f;%g;%g;2;-3;1\n", q[m.findJoint("x")] * 1e3, q[m.findJoint("y")] * 1e3,
                   q[m.findJoint("z")] * 1e3, b, a);
  }
  const Imported i = five.text(text);
  EXPECT_EQ(i.format, "r-test");
  ASSERT_EQ(i.session->observations.size(), 4u);
  for (const Observation& o : i.session->observations) {
    const Eigen::Vector3d tip = m.nominal(o.position.data(), kNotMeasured).position;
    EXPECT_LT((tip - (ball - Eigen::Vector3d(2e-6, -3e-6, 1e-6))).norm(), 2e-9);
  }
  EXPECT_FALSE(i.session->artifact.features[0].known);
  // without the linear joints the nominal machine does not stay at the ball
  EXPECT_THAT(five.refusal("R-test\nB [deg];A [deg];dx [um];dy [um];dz [um]\n0;0;1;2;3\n90;0;1;2;3\n"),
              HasSubstr("the tip does not stay at one position"));
  EXPECT_THAT(five.refusal("R-test\nB [deg];A [deg];dx [um];dy [um];dz [um]\n0;0;1;;3\n"),
              AllOf(HasSubstr("f.txt:3"), HasSubstr("'dy' is empty")));
}

class Pointing : public ::testing::Test {
 protected:
  test::Importer importer_{test_support::panTilt()};
};

TEST_F(Pointing, AzimuthsRunClockwise) {
  const Imported i = importer_.file("examples/import/pointing_altaz.tpt");
  EXPECT_EQ(i.format, "tpoint");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 36u);
  EXPECT_DOUBLE_EQ(o[0].position[0], -15 * kDegree) << "pan turns anticlockwise, seen from above";
  EXPECT_DOUBLE_EQ(o[0].position[1], 20 * kDegree);
  EXPECT_NEAR(o[0].deviation[0], -120 * kArcsecond, 4 * kArcsecond);
  EXPECT_NEAR(o[0].deviation[1], -45 * kArcsecond, 4 * kArcsecond);
  const Imported as = importer_.file("examples/import/pointing_altaz.tpt", "sign: [1, 1]\n");
  EXPECT_DOUBLE_EQ(as.session->observations[0].position[0], 15 * kDegree);
}

TEST_F(Pointing, AnAzimuthBeyondNorth) {
  const Imported i = importer_.text("run\n:ALTAZ\n48 8 23\n0.01 30 359.99 30\nEND\n");
  EXPECT_NEAR(i.session->observations[0].deviation[0], -72 * kArcsecond, 1e-9);
}

TEST_F(Pointing, RightAscensionsOnlyAsObservedPlacesOfAnEquatorialMount) {
  const std::string file = "examples/import/pointing_equatorial.tpt";
  EXPECT_THAT(test::messageOf<InputError>([&] { importer_.file(file); }), HasSubstr("mount: equatorial"));
  const Imported i = importer_.file(file, "mount: equatorial\nsign: [1, 1]\n");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 2u);
  // hour angle = sidereal time - right ascension: the telescope reads 2 s of time less of it, 30 arcsec
  EXPECT_NEAR(o[0].position[0], ((13 + 40.87 / 60) - (14 + 16.0 / 60 + 2.0 / 3600)) * 15 * kDegree, 1e-12);
  EXPECT_NEAR(o[0].deviation[0], 30 * kArcsecond, 1e-10);
  EXPECT_NEAR(o[0].deviation[1], 20 * kArcsecond, 1e-10);
  EXPECT_NEAR(o[1].position[1], -(12 * 60 + 50.0) * kArcsecond, 1e-12) << "the sign of -00";
  EXPECT_NEAR(o[1].deviation[1], 20 * kArcsecond, 1e-10);
}

TEST_F(Pointing, OfAnotherMachineOrWithBrokenRows) {
  const test::Importer mill;
  EXPECT_THAT(test::messageOf<InputError>([&] { mill.file("examples/import/pointing_altaz.tpt"); }),
              HasSubstr("two rotary joints"));
  EXPECT_THAT(importer_.refusal("run\n:ALTAZ\n48 8 23\n10 30 10 30\n10 30 10\nEND\n"),
              AllOf(HasSubstr("f.txt:5"), HasSubstr("4 numbers")));
}

TEST_F(Formats, KlipperRepeatsAtOnePlace) {
  const Imported i = example("klipper_probe_accuracy.txt");
  EXPECT_EQ(i.format, "klipper");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 5u);
  EXPECT_DOUBLE_EQ(o[2].position[0], 5e-3);
  for (const Observation& touch : o)
    EXPECT_EQ(touch.position[2], o[0].position[2]) << "the surface has one height: z goes no way";
  EXPECT_DOUBLE_EQ(o[2].deviation[2], -0.01e-3);
  EXPECT_DOUBLE_EQ(o[2].velocity[2], -5e-3) << "the probing speed of the command";
  EXPECT_EQ(o[2].row, 5);
}

TEST_F(Formats, KlipperMeshNeedsAFlatBed) {
  EXPECT_THAT(refusal("klipper_bed_mesh_octoprint.log"),
              AllOf(HasSubstr("9 points on the bed"), HasSubstr("surface: flat")));
  const Imported i = example("klipper_bed_mesh_octoprint.log", "surface: flat\n");
  const auto& o = i.session->observations;
  ASSERT_EQ(o.size(), 9u);
  EXPECT_NEAR(o[1].time, 10.037, 1e-9) << "from the time stamps";
  EXPECT_EQ(i.session->epoch, 1795256100.0);
  EXPECT_DOUBLE_EQ(o[0].deviation[2], 0.02e-3);
  EXPECT_EQ(o[0].travel[2], -1.0);
  EXPECT_TRUE(std::isnan(o[0].velocity[2])) << "the log does not say how fast";
  EXPECT_EQ(i.session->setups, std::vector<std::string>{"bed"});
  const Imported saved = example("klipper_printer.cfg", "surface: flat\n");
  ASSERT_EQ(saved.session->observations.size(), 6u);
  const Observation& last = saved.session->observations[4];
  EXPECT_DOUBLE_EQ(last.position[0], 0.0);
  EXPECT_DOUBLE_EQ(last.position[1], 30e-3);
  EXPECT_DOUBLE_EQ(last.deviation[2], 0.0825e-3);
}

TEST_F(Formats, MarlinG30AndM48) {
  const Imported i = example("marlin_g30.txt");
  EXPECT_EQ(i.format, "marlin");
  ASSERT_EQ(i.session->observations.size(), 4u);
  EXPECT_EQ(i.session->setups.size(), 2u) << "each point has its own unknown height";
  EXPECT_DOUBLE_EQ(i.session->observations[2].position[1], 20e-3);
  EXPECT_DOUBLE_EQ(i.session->observations[2].deviation[2], 0.015e-3);
  const Imported m48 = example("marlin_m48.txt");
  ASSERT_EQ(m48.session->observations.size(), 4u);
  EXPECT_DOUBLE_EQ(m48.session->observations[0].position[0], 12.5e-3);
  EXPECT_DOUBLE_EQ(m48.session->observations[1].deviation[2], -0.025e-3);
  const std::string unplaced =
      "1 of 2: z: 0.020 mean: 0.02 sigma: 0.0\n2 of 2: z: 0.025 mean: 0.0225 sigma: 0.0025\n";
  EXPECT_THAT(importer_.refusal(unplaced), HasSubstr("position_mm: [100, 100]"));
  EXPECT_DOUBLE_EQ(importer_.text(unplaced, "position_mm: [3, 4]\n").session->observations[1].position[1],
                   4e-3);
}

/// What is shipped as an example of a format is as it should be: no question is raised by it.
TEST_F(Formats, ExamplesRaiseNoQuestion) {
  const auto expectNone = [](const std::string& name, const Imported& i) {
    ASSERT_TRUE(i.session) << name;
    for (const Doubt& d : sensibleDoubts(*i.session)) ADD_FAILURE() << name << ": " << d.question;
  };
  for (const char* name : {"iso230_2_x.csv", "iso230_2_z_by_runs.txt", "ball_bar_xy.csv", "length_bars_y.csv",
                           "step_gauge_x.txt", "klipper_probe_accuracy.txt", "marlin_m48.txt"})
    expectNone(name, example(name));
  for (const char* name : {"klipper_bed_mesh_octoprint.log", "klipper_printer.cfg", "marlin_g30.txt"})
    expectNone(name, example(name, "surface: flat\n"));
  expectNone("r_test_ba.csv", test::Importer("five_axis").file("examples/import/r_test_ba.csv"));
}

}  // namespace
}  // namespace mm
