// Tables as strangers write them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/units.h"
#include "import_support.h"
#include "session/input_faults.h"

namespace mm {
namespace {

using test::columnNamed;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ForeignTables : public ::testing::Test {
 protected:
  Imported import(const std::string& name, const std::string& mapping = "", bool artifact = true) const {
    return importer_.file("test/data/foreign/" + name, mapping, artifact ? &balls_ : nullptr);
  }
  std::string refusal(const std::string& name, const std::string& mapping = "") const {
    return test::messageOf<InputError>([&] { import(name, mapping); });
  }
  /// All of these files but a few hold the same touches of two balls: 14 tips at R + r from a centre.
  static void expectTouches(const Imported& imported, double tolerance) {
    ASSERT_TRUE(imported.session);
    const Session& s = *imported.session;
    ASSERT_EQ(s.observations.size(), 14u);
    for (std::size_t i = 0; i < 14; ++i) {
      const Observation& o = s.observations[i];
      EXPECT_EQ(o.feature, i < 7 ? 0 : 1);
      const Eigen::Vector3d tip(o.position[0], o.position[1], o.position[2]);
      EXPECT_NEAR((tip - s.artifact.features[o.feature].position).norm(), 4.9685e-3, tolerance) << i;
    }
  }
  test::Importer importer_;
  Artifact balls_ = test::twoBalls();
};

TEST_F(ForeignTables, SpreadsheetWithDecimalCommasInUtf16) {
  const Imported i = import("01_excel_german.csv");
  expectTouches(i, 1.5e-6);
  EXPECT_THAT(i.how,
              AllOf(HasSubstr("UTF-16"), HasSubstr("';'"), HasSubstr("decimal comma"), HasSubstr("line 4")));
  EXPECT_EQ(i.session->observations[1].time, 10.0);
  EXPECT_EQ(i.session->epoch, 1795256100.0) << "2026-11-21 10:15:00";
  ASSERT_EQ(i.session->temperatures.size(), 1u);
  EXPECT_EQ(i.session->temperatures[0].name, "tisch");
  EXPECT_DOUBLE_EQ(i.session->temperatures[0].value[0], 20.1);
}

TEST_F(ForeignTables, InchesFahrenheitTabsAndRemarks) {
  const Imported i = import("02_inch_tabs.txt");
  expectTouches(i, 1.5e-6);
  EXPECT_EQ(columnNamed(i, "X (in)")->unit, "inch");
  EXPECT_NEAR(i.session->temperatures[0].value[0], (68.1 - 32.0) / 1.8, 1e-9);
}

TEST_F(ForeignTables, AnInterferometersAxisAndSignAreAskedForAtOnce) {
  const std::string name = "03_interferometer_units_row.csv";
  EXPECT_THAT(refusal(name), AllOf(HasSubstr("axis: x"), HasSubstr("Error: error_x_um"), HasSubstr("VIM")));
  const std::string axis = "axis: y\ncolumns: {Error: ";
  const Imported actual = import(name, axis + "deviation_y_um}\n", false);
  ASSERT_EQ(actual.session->observations.size(), 10u);
  EXPECT_DOUBLE_EQ(actual.session->observations[0].position[1], -20e-3);
  EXPECT_DOUBLE_EQ(actual.session->observations[0].deviation[1], -4.8e-6);
  EXPECT_EQ(actual.session->temperatures[0].name, "env");
  const Imported error = import(name, axis + "error_y_um}\n", false);
  EXPECT_DOUBLE_EQ(error.session->observations[0].deviation[1], 4.8e-6);
}

TEST_F(ForeignTables, ATrackersMetresBetweenBlanks) {
  const Imported i = import("04_tracker_blanks.dat");
  ASSERT_EQ(i.session->observations.size(), 12u);
  const Observation& o = i.session->observations[1];
  EXPECT_EQ(o.kind, ObservationKind::kPosition);
  EXPECT_DOUBLE_EQ(o.position[0], -0.0058467);
  EXPECT_DOUBLE_EQ(o.reference[0], -0.0058469);
  EXPECT_DOUBLE_EQ(o.time, 1.0);
}

TEST_F(ForeignTables, PandasWithItsIndexAZoneAndKelvin) {
  const Imported i = import("05_pandas.csv");
  expectTouches(i, 1.5e-6);
  EXPECT_DOUBLE_EQ(i.session->epoch, 1795256100.25 - 3600.0);
  ASSERT_EQ(i.session->temperatures[0].value.size(), 13u) << "nan is not measured";
  EXPECT_NEAR(i.session->temperatures[0].value[0], 20.15, 1e-9);
}

TEST_F(ForeignTables, CapitalsQuotesAndMillisecondsSince1970) {
  const Imported i = import("06_quoted_bom.csv");
  expectTouches(i, 1.5e-6);
  EXPECT_DOUBLE_EQ(i.session->observations[1].time, 9.0);
  EXPECT_DOUBLE_EQ(i.session->epoch, 1795256100.0);
}

TEST_F(ForeignTables, AProbeLogWithoutNamesAsksForThemInOneLine) {
  const std::string message = refusal("07_linuxcnc_probe.txt");
  EXPECT_THAT(message, HasSubstr("columns: {1: x_mm, 2: y_mm, 3: z_mm, 4: ignore"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  const Artifact one = parseArtifact(
      "name: one\nprobe: {tip_radius_mm: 1}\nballs:\n  - {name: b1, centre_mm: [0, 0, 0], radius_mm: "
      "3.9685}\n",
      "a");
  const Imported i = importer_.file("test/data/foreign/07_linuxcnc_probe.txt",
                                    "columns: {1: x_mm, 2: y_mm, 3: z_mm}\nothers: ignore\n", &one);
  ASSERT_EQ(i.session->observations.size(), 7u) << "the only ball of the artifact is what was touched";
  EXPECT_DOUBLE_EQ(i.session->observations[0].position[2], 4.542502e-3);
}

TEST_F(ForeignTables, AllFaultsAreNamedAtOnce) {
  try {
    import("08_many_faults.csv");
    FAIL() << "not refused";
  } catch (const InputFaults& e) {
    ASSERT_EQ(e.faults().size(), 6u) << e.what();
    const char* const expected[] = {":3: column 'x_mm': 'oops'",
                                    ":4: feature 'b9'",
                                    ":5: column 'y_mm': '--2'",
                                    ":6: 3 cells",
                                    ":7: the reading of joint 'z' is empty",
                                    ":8: column 'time_s': 'soon'"};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_THAT(e.faults()[i], HasSubstr(expected[i]));
  }
}

TEST_F(ForeignTables, Latin1WithTheLineEndsOfOldMacs) {
  const Imported i = import("09_latin1_mac.csv", "", false);
  ASSERT_EQ(i.session->observations.size(), 10u);
  EXPECT_DOUBLE_EQ(i.session->observations[0].position[0], -20e-3);
  EXPECT_DOUBLE_EQ(i.session->observations[0].deviation[0], -3.4e-6);
}

TEST_F(ForeignTables, TargetsMeasuredPositionsAndDirections) {
  const Imported i = import("10_target_measured.csv", "", false);
  ASSERT_EQ(i.session->observations.size(), 16u);
  const Observation& first = i.session->observations[0];
  EXPECT_DOUBLE_EQ(first.position[1], -15e-3);
  EXPECT_NEAR(first.deviation[1], 1e-6, 1e-12);
  EXPECT_EQ(first.travel[1], 1.0);
  EXPECT_EQ(i.session->observations[4].travel[1], -1.0);
  EXPECT_TRUE(i.session->assumed.empty()) << "directions were recorded";
  ASSERT_EQ(i.motion.size(), 16u);
  EXPECT_GT(i.motion[0].velocity[1], 0.0);
  EXPECT_LT(i.motion[4].velocity[1], 0.0);
}

TEST_F(ForeignTables, BareNamesWhereOnlyMillimetresArePossible) {
  const Imported i = import("11_bare_names.csv");
  expectTouches(i, 1.5e-6);
  EXPECT_EQ(columnNamed(i, "X")->unit, "mm");
  EXPECT_EQ(columnNamed(i, "X")->from, "its range");
  EXPECT_DOUBLE_EQ(i.session->observations[3].time, 3.0);
}

TEST_F(ForeignTables, NamesOfTheirOwnAndATimeOfDay) {
  const std::string name = "12_own_names.csv";
  EXPECT_THAT(refusal(name),
              HasSubstr("columns: {enc1/um: x_um, enc2/um: y_um, enc3/um: z_um, what: feature}"));
  const Imported i = import(name,
                            "columns: {enc1/um: x, enc2/um: y_um, enc3/um: z_um, what: feature}\n"
                            "features: {sphere A: b1, sphere B: b2}\n");
  expectTouches(i, 1.5e-6);
  EXPECT_DOUBLE_EQ(i.session->observations[13].time, 130.0);
  ASSERT_EQ(i.notes.size(), 1u);
  EXPECT_THAT(i.notes[0], HasSubstr("--- end of log ---"));
}

/// Twelve targets from -16 mm on, 3 mm apart.
static void expectTargets(const Imported& i) {
  ASSERT_TRUE(i.session);
  ASSERT_EQ(i.session->observations.size(), 12u);
  for (int k = 0; k < 12; ++k)
    EXPECT_NEAR(i.session->observations[k].position[0], (-16 + 3 * k) * 1e-3, 1e-12) << k;
}

TEST_F(ForeignTables, TargetMeasuredAndDeviationOfTheOnlyJointThatIsNamed) {
  const Imported i = import("13_excel_german_windows.csv", "", false);
  expectTargets(i);
  EXPECT_NEAR(i.session->observations[0].deviation[0], 2.0e-6, 1e-12)
      << "'Abweichung [µm]', which names no joint";
  EXPECT_THAT(columnNamed(i, "Abweichung [µm]")->meaning, HasSubstr("left out: measured minus target"));
  EXPECT_THAT(i.notes, ::testing::Contains(HasSubstr("the only joint that the file names")));
}

TEST_F(ForeignTables, AFooterOfAveragesIsNoMeasurement) {
  const Imported i = import("14_quoted_footer.csv", "", false);
  expectTargets(i);
  EXPECT_THAT(i.notes, ::testing::Contains(HasSubstr("line 14 is not a data row")));
  EXPECT_THAT(i.notes, ::testing::Contains(HasSubstr("line 15 is not a data row")));
}

TEST_F(ForeignTables, ALineOfGroupsAboveTheNames) {
  const Imported i = import("15_two_line_header.csv", "", false);
  expectTargets(i);
  EXPECT_EQ(columnNamed(i, "Deviation Y")->meaning, "deviation of y");
  EXPECT_EQ(columnNamed(i, "Position X")->unit, "mm");
  EXPECT_DOUBLE_EQ(i.session->observations[1].time, 10.0);
  EXPECT_EQ(i.session->temperatures[0].name, "bed");
}

TEST_F(ForeignTables, ManyWordsForNotMeasured) {
  const std::string name = "16_missing_values.tsv";
  EXPECT_THAT(refusal(name), AllOf(HasSubstr("an error or a difference"), HasSubstr("{dX_um: error_x_um}")));
  const Imported i = import(name, "columns: {dX_um: deviation_x_um}\n", false);
  EXPECT_EQ(i.session->observations.size(), 11u) << "---, n/a and NaN are no deviations";
  ASSERT_EQ(i.session->temperatures.size(), 2u);
  EXPECT_EQ(i.session->temperatures[1].value.size(), 11u) << "n.d., #N/A and <NA> are no temperatures";
}

TEST_F(ForeignTables, MicroinchesAndTwelveHourClocks) {
  const Imported i = import("17_us_timestamps.csv", "columns: {Error X (µin): error_x_uin}\n", false);
  ASSERT_EQ(i.session->observations.size(), 12u);
  EXPECT_NEAR(i.session->observations[0].deviation[0], -46 * 25.4e-9, 1e-15);
  EXPECT_DOUBLE_EQ(i.session->epoch, 1767193440.0) << "2025-12-31 15:04";
}

TEST_F(ForeignTables, AReportOfARowACoordinateIsRefusedInOneLine) {
  const std::string message = refusal("18_cmm_report.txt");
  EXPECT_THAT(message, AllOf(HasSubstr("column 'Axis' holds X, Y, Z"), HasSubstr("one row per point")));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(ForeignTables, ThousandsSetApart) {
  expectTargets(import("19_thousands_german.csv", "", false));
  const Imported french = import("20_thousands_french.csv", "", false);
  ASSERT_EQ(french.session->observations.size(), 12u);
  EXPECT_NEAR(french.session->observations[0].position[0], -16000.25e-6, 1e-12);
  EXPECT_NEAR(french.session->observations[0].deviation[0], 1.03e-6, 1e-12);
  expectTargets(import("21_thousands_swiss.csv", "", false));
  const Imported quoted = import("22_thousands_quoted.csv", "", false);
  EXPECT_NEAR(quoted.session->observations[5].position[0], -1000.5e-6, 1e-12);
}

TEST_F(ForeignTables, APrintersLogWithTimesOfDay) {
  const Imported i = import("23_klipper_clock.log", "", false);
  ASSERT_EQ(i.session->observations.size(), 18u);
  EXPECT_EQ(i.session->observations[0].time, 0.0);
  EXPECT_NEAR(i.session->observations[17].time, 17 * 1.5, 1e-9);
  EXPECT_THAT(i.notes, ::testing::Not(::testing::Contains(HasSubstr("no times"))));
}

}  // namespace
}  // namespace mm
