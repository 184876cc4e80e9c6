// What a table says of itself, and what it does not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/units.h"
#include "import/unit.h"
#include "import_support.h"
#include "session/input_faults.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

using test::columnNamed;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Units, AreReadAsPeopleWriteThem) {
  const auto factor = [](const char* text) { return parseUnit(text)->factor; };
  EXPECT_DOUBLE_EQ(factor("mm"), 1e-3);
  for (const char* um : {"µm", "μm", "um", "UM", "micron"}) EXPECT_DOUBLE_EQ(factor(um), 1e-6) << um;
  for (const char* inch : {"in", "inch", "Inches", "in."}) EXPECT_DOUBLE_EQ(factor(inch), 0.0254) << inch;
  for (const char* deg : {"deg", "°", "Degrees"}) EXPECT_DOUBLE_EQ(factor(deg), kDegree) << deg;
  EXPECT_DOUBLE_EQ(factor("mrad"), 1e-3);
  EXPECT_DOUBLE_EQ(factor("arcsec"), kArcsecond);
  EXPECT_DOUBLE_EQ(factor("arcmin"), 60 * kArcsecond);
  EXPECT_DOUBLE_EQ(factor("mm/min"), 1e-3 / 60);
  for (const char* c : {"°C", "degC", "deg C", "C", "Celsius"}) EXPECT_EQ(parseUnit(c)->symbol, "degC") << c;
  EXPECT_NEAR(300.0 * parseUnit("K")->factor + parseUnit("K")->offset, 26.85, 1e-12);
  EXPECT_NEAR(212.0 * parseUnit("°F")->factor + parseUnit("°F")->offset, 100.0, 1e-12);
  EXPECT_EQ(parseUnit("m", UnitKind::kTime)->symbol, "min");
  EXPECT_EQ(parseUnit("\"", UnitKind::kAngle)->symbol, "arcsec");
  EXPECT_FALSE(parseUnit("furlong"));
  EXPECT_FALSE(parseUnit("mm", UnitKind::kAngle));
}

TEST(TimeStamps, OfTheCalendar) {
  constexpr std::int64_t kS = 1000000000, kAt = 1795256103LL * kS;
  for (const char* text :
       {"2026-11-21T10:15:03Z", "2026-11-21 10:15:03", "2026/11/21 10:15:03", "21.11.2026 10:15:03",
        "2026-11-21T11:15:03+01:00", "2026-11-21T05:45:03-0430", "2026-11-21 10:15:03 AM"})
    EXPECT_EQ(parseCalendar(text), kAt) << text;
  EXPECT_EQ(parseCalendar("21.11.2026 10:15:03,25"), kAt + kS / 4);
  EXPECT_EQ(parseCalendar("2026-11-21T10:15:03.000000001Z"), kAt + 1);
  EXPECT_EQ(parseCalendar("2028-02-29"), 1835395200LL * kS);
  for (const char* text :
       {"11/12/2026", "2026-02-29", "2026-13-01", "25:00", "12.5", "2026-11-21T25:00", "soon", ""})
    EXPECT_FALSE(parseCalendar(text)) << text;
}

TEST(TimeStamps, OfTheDay) {
  EXPECT_EQ(parseClock("10:15"), 36900LL * 1000000000);
  EXPECT_EQ(parseClock("2:05:01.5 pm"), 50701500000000LL);
  EXPECT_FALSE(parseClock("10.15"));
  EXPECT_FALSE(parseClock("13:00 PM"));
}

class Understanding : public ::testing::Test {
 protected:
  test::Importer importer_;
};

TEST_F(Understanding, ANightShiftPassesMidnight) {
  const Imported i = importer_.text("clock;x_mm;deviation_x_um\n23:59:50;0;1\n00:00:10;1;2\n");
  EXPECT_DOUBLE_EQ(i.session->observations[1].time, 20.0);
}

TEST_F(Understanding, DateAndTimeInTwoColumns) {
  const Imported i =
      importer_.text("Date,Time,x_mm,deviation_x_um\n2026-11-21,23:59:50,0,1\n2026-11-22,00:00:10,1,2\n");
  EXPECT_DOUBLE_EQ(i.session->observations[1].time, 20.0);
  EXPECT_DOUBLE_EQ(i.session->epoch, 1795305590.0);
}

/// Epoch of a run with these lines above it, s since 1970.
static double epochBelow(const test::Importer& importer, const std::string& head,
                         const std::string& mapping = "") {
  const std::string run = "Soll [mm];1+;1-\n0;1;2\n10;1;2\n20;1;-3\n";
  return importer.text(head + "\n" + run, "axis: x\nunit: um\n" + mapping).session->epoch;
}

TEST_F(Understanding, TheDateOfMeasurementInTheHead) {
  constexpr double kNovember27 = 1795737600.0, kNone = 1e9;
  for (const char* head :
       {"Datum: 27.11.2026", "# Date: 2026-11-27", "Date;27/11/2026;", "\"Measurement date\",\"2026-11-27\"",
        "gemessen am 27.11.2026 durch N. N.", "Date de mesure : 27/11/2026", "Fecha = 2026/11/27",
        "Datum: 28.11.2026\nMessdatum: 27.11.2026", "Date: 11/27/2026  Time: 09:12 AM"})
    EXPECT_EQ(epochBelow(importer_, head), kNovember27) << head;
  EXPECT_EQ(epochBelow(importer_, "Datum: 27.11.2026 10:15"), kNovember27 + 36900.0);
  for (const char* head : {"Kalibrierdatum: 27.11.2026", "Datum: 31.02.2026", "Date: ", "Date: 11/12/2026"})
    EXPECT_EQ(epochBelow(importer_, head), kNone) << head;
  EXPECT_EQ(epochBelow(importer_, "Date: 12/11/2026", "date: day_first\n"), kNovember27 - 15 * 86400.0);
  const Imported unclear = importer_.text("Date: 11/12/2026\nclock;x_mm;deviation_x_um\n10:15;0;1\n");
  EXPECT_THAT(unclear.notes, ::testing::Contains(AllOf(HasSubstr("line 1"), HasSubstr("date: day_first"))));
}

TEST_F(Understanding, ADateInTheHeadIsTheDayOfTheRowsTimes) {
  const auto epoch = [&](const std::string& times) {
    return importer_.text("Datum: 27.11.2026 08:00\n" + times + ",0,1\n").session->epoch;
  };
  constexpr double kNovember27 = 1795737600.0;
  EXPECT_EQ(epoch("clock,x_mm,deviation_x_um\n10:15"), kNovember27 + 36900.0);
  EXPECT_EQ(epoch("t [s],x_mm,deviation_x_um\n1000000"), kNovember27 + 28800.0) << "counted from anywhere";
  EXPECT_EQ(epoch("when,x_mm,deviation_x_um\n2026-11-21T10:15:00"), 1795256100.0) << "the rows' own";
}

TEST_F(Understanding, LengthsThatMayBeInchesAreNotGuessed) {
  // ±0.6 of a machine of ±20 mm: 3 % of its travel in mm, three quarters of it in inches
  const std::string csv = "X;deviation_x_um\n-0.6;1\n0;2\n0.6;3\n";
  EXPECT_THAT(importer_.refusal(csv),
              AllOf(HasSubstr("f.txt:1: column 'X'"), HasSubstr("columns: {X: x_mm}")));
  EXPECT_DOUBLE_EQ(importer_.text(csv, "columns: {X: x_inch}\n").session->observations[2].position[0],
                   0.01524);
}

TEST_F(Understanding, AUnitThatCannotBe) {
  EXPECT_THAT(importer_.refusal("x [arcsec];deviation_x_um\n0;1\n"),
              AllOf(HasSubstr("'arcsec'"), HasSubstr("length"), HasSubstr("{'x [arcsec]': x_mm}")));
}

TEST_F(Understanding, TwoColumnsOfOneMeaning) {
  EXPECT_THAT(importer_.refusal("x_mm;X pos [mm];deviation_x_um\n0;0;1\n"), HasSubstr("both understood as"));
}

TEST_F(Understanding, DatesWithSlashes) {
  const std::string tail = " 10:15:03,0,1\n";
  const auto csv = [&](const char* a, const char* b) {
    return std::string("when,x_mm,deviation_x_um\n") + a + tail + b + tail;
  };
  EXPECT_DOUBLE_EQ(importer_.text(csv("11/20/2026", "11/21/2026")).session->epoch, 1795256103.0 - 86400.0);
  EXPECT_DOUBLE_EQ(importer_.text(csv("1/11/2026", "21/11/2026")).session->epoch,
                   1795256103.0 - 20 * 86400.0);
  EXPECT_THAT(importer_.refusal(csv("11/03/2026", "11/04/2026")), HasSubstr("date: month_first"));
  EXPECT_DOUBLE_EQ(
      importer_.text(csv("11/03/2026", "11/04/2026"), "date: day_first\n").session->observations[1].time,
      2678400.0)
      << "a month, not a day";
}

TEST_F(Understanding, UnitsBehindTheNumbers) {
  const Imported i = importer_.text("time,X,deviation X\n0 ms,1.5 inch,1.5 um\n500 ms,1.6 inch,-2 um\n");
  ASSERT_EQ(i.session->observations.size(), 2u);
  EXPECT_DOUBLE_EQ(i.session->observations[1].position[0], 1.6 * 0.0254);
  EXPECT_DOUBLE_EQ(i.session->observations[1].deviation[0], -2e-6);
  EXPECT_DOUBLE_EQ(i.session->observations[1].time, 0.5);
  EXPECT_THAT(importer_.refusal("time,X,deviation X\n0 s,1.5 mm,1.5 um\n5 s,1.6 inch,-2 um\n"),
              HasSubstr("'X'"));
}

TEST_F(Understanding, AMeasuredPositionIsAsked) {
  EXPECT_THAT(importer_.refusal("Position X [mm];Istwert [mm]\n0;0.001\n5;5.002\n"),
              HasSubstr("{'Istwert [mm]': measured_x_mm}"));
  const Imported i = importer_.text("Position X [mm];Istwert [mm]\n0;0.001\n5;5.002\n",
                                    "columns: {'Istwert [mm]': measured_x_mm}\n");
  EXPECT_NEAR(i.session->observations[1].deviation[0], 2e-6, 1e-12);
}

TEST_F(Understanding, CapitalsTellTwoColumnsApart) {
  const std::string csv = "t;T;x_mm;deviation_x_um\n0;20.1;1;2\n5;20.3;7;2\n";
  const Session session = *importer_.text(csv, "columns: {t: time_s, T: bed_degC}\n").session;
  EXPECT_DOUBLE_EQ(session.observations[1].time - session.observations[0].time, 5.0);
  ASSERT_EQ(session.temperatures.size(), 1u);
  EXPECT_EQ(session.temperatures[0].name, "bed");
  EXPECT_DOUBLE_EQ(importer_.text("t;x_mm;deviation_x_um\n0;1;2\n5;7;2\n", "columns: {T: time_s}\n")
                       .session->observations[1]
                       .time,
                   5.0)
      << "where there is one, capitals do not count";
}

TEST_F(Understanding, TwoColumnsOfOneNameGoByTheirNumbers) {
  const std::string csv = "x_mm;x_mm;deviation_x_um\n1;7;2\n";
  EXPECT_THAT(importer_.refusal(csv), HasSubstr("columns: {2: ignore}"));
  EXPECT_DOUBLE_EQ(importer_.text(csv, "columns: {1: ignore}\n").session->observations[0].position[0], 7e-3);
}

TEST_F(Understanding, AMisspeltNameIsNoCovariate) {
  EXPECT_THAT(importer_.refusal("time_s,x_velocty_mm_s,deviation_x_um\n0,0,1\n"),
              HasSubstr("columns: {x_velocty_mm_s: x_velocity_mm_s}"));
}

TEST_F(Understanding, WhatWasLoggedBeside) {
  const Imported i =
      importer_.text("x_mm;deviation_x_um;Humidity [%];air pressure (hPa);load_N\n0;1;45;1013;2\n");
  ASSERT_EQ(i.session->covariates.size(), 3u);
  EXPECT_EQ(i.session->covariates[0].name, "air_pressure");
  EXPECT_EQ(i.session->covariates[0].unit, "hPa");
  EXPECT_EQ(i.session->covariates[1].name, "humidity");
  EXPECT_EQ(i.session->covariates[1].unit, "percent");
}

TEST_F(Understanding, TheMappingsOwnFaults) {
  const std::string csv = "a;b\n0;1\n";
  EXPECT_THAT(importer_.refusal(csv, "colums: {a: x_mm}\n"),
              AllOf(HasSubstr("mapping.yaml:1"), HasSubstr("columns")));
  EXPECT_THAT(importer_.refusal(csv, "columns: {c: x_mm}\n"),
              AllOf(HasSubstr("'c' is not in"), HasSubstr("a, b")));
  EXPECT_THAT(importer_.refusal(csv, "columns: {a: w_mm, b: deviation_x_um}\n"),
              HasSubstr("'a: w_mm' is not understood"));
  EXPECT_THAT(importer_.refusal(csv, "separator: x\n"), HasSubstr("separator"));
  EXPECT_THAT(importer_.refusal(csv, "axis: w\n"),
              AllOf(HasSubstr("mapping.yaml:1"), HasSubstr("'w' is not a joint of")));
}

TEST_F(Understanding, JointsThatStoodElsewhere) {
  const Imported i = importer_.text("x_mm;deviation_x_um\n0;1\n", "fixed: {y_mm: 12.5, z_um: -300}\n");
  EXPECT_DOUBLE_EQ(i.session->observations[0].position[1], 12.5e-3);
  EXPECT_DOUBLE_EQ(i.session->observations[0].position[2], -0.3e-3);
}

TEST_F(Understanding, RotaryJointsInRadiansAndMinutesOfArc) {
  const test::Importer five("five_axis");
  const Imported i = five.text("B [rad]\tdeviation b [arcmin]\n0.5\t0.1\n-0.5\t0.2\n");
  const int b = five.machine().findJoint("b");
  EXPECT_DOUBLE_EQ(i.session->observations[0].position[b], 0.5);
  EXPECT_DOUBLE_EQ(i.session->observations[0].deviation[b], 6 * kArcsecond);
}

TEST_F(Understanding, FilesThatAreNoTables) {
  EXPECT_THAT(importer_.refusal("PK\x03\x04rest"), HasSubstr("save the sheet as CSV"));
  EXPECT_THAT(importer_.refusal("#ROSBAG V2.0\n"), HasSubstr("is a bag"));
  EXPECT_THAT(importer_.refusal(std::string("\0\1\0\0\0binary", 10)), HasSubstr("is binary"));
  EXPECT_THAT(importer_.refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(importer_.refusal("hello\nworld\n"), HasSubstr("no table found"));
}

TEST_F(Understanding, FaultsBeyondTheLimitAreCounted) {
  std::string csv = "time_s,x_mm,deviation_x_um\n";
  for (int i = 0; i < 50; ++i) csv += std::to_string(i) + ",0,bad\n";
  try {
    importer_.text(csv);
    FAIL() << "not refused";
  } catch (const InputFaults& e) {
    EXPECT_EQ(e.faults().size(), FaultList::kShown + 1);
    EXPECT_THAT(e.faults().back(), HasSubstr("30 more faults"));
  }
}

TEST_F(Understanding, TheTableOfColumnsIsShown) {
  const std::string text = understoodText(importer_.text("Zeit;X [mm];deviation_x_um\n0;1,5;2\n5;2,5;3\n"));
  EXPECT_THAT(text, AllOf(HasSubstr("decimal comma"), HasSubstr("reading of joint x"), HasSubstr("1.5 … 2.5"),
                          HasSubstr("s (assumed)"), HasSubstr("times without a unit")));
  EXPECT_THAT(
      understoodText(importer_.text("time_s,x_mm,deviation_x_um\n0,1.5,2\n")),
      AllOf(HasSubstr("the package's own columns"), HasSubstr("deviation of x"), Not(HasSubstr("note"))));
}

TEST_F(Understanding, AMarkThatMayBeDecimalOrNot) {
  // ±16.000 mm is within ±20 mm, ±16000 mm is not; of um it is the other way round
  const std::string rows = ";deviation_x_um\n-16,000;1\n12,000;2\n16,000;3\n";
  const Imported mm = importer_.text("X [mm]" + rows), um = importer_.text("X [um]" + rows);
  EXPECT_DOUBLE_EQ(mm.session->observations[0].position[0], -16e-3);
  EXPECT_DOUBLE_EQ(um.session->observations[0].position[0], -16e-3);
  EXPECT_THAT(mm.notes, ::testing::Contains(HasSubstr("'-16,000' is taken with a decimal comma")));
  EXPECT_THAT(um.notes, ::testing::Contains(HasSubstr("thousands set apart")));
  // without a unit both are possible
  EXPECT_THAT(importer_.refusal("X" + rows),
              AllOf(HasSubstr("f.txt:2: column 'X': whether '-16,000' is -16 or -16000"),
                    HasSubstr("decimal: comma (or point)")));
  EXPECT_DOUBLE_EQ(importer_.text("X [mm]" + rows, "decimal: comma\n").session->observations[1].position[0],
                   12e-3);
}

TEST_F(Understanding, ANumberThatShowsTheMarkShowsItForTheTable) {
  // the zero in front of 0,100 is never that of thousands
  EXPECT_DOUBLE_EQ(
      importer_.text("x_mm;deviation_x_um\n0,100;1\n12,345;2\n").session->observations[1].position[0],
      12.345e-3);
  // 1.234 among decimal commas: not without a number of its own column that says so
  const std::string csv = "x_mm;deviation_x_um\n0,5;1.234\n12,345;2.500\n";
  EXPECT_THAT(importer_.refusal(csv),
              AllOf(HasSubstr("'1.234' is 1.234 or 1234"), HasSubstr("decimal: comma")));
  EXPECT_DOUBLE_EQ(importer_.text(csv, "decimal: comma\n").session->observations[0].deviation[0], 1234e-6);
  EXPECT_DOUBLE_EQ(
      importer_.text("x_mm;deviation_x_um\n0,5;1.234\n12,345;998,5\n").session->observations[0].deviation[0],
      1234e-6);
  // a column that is set aside does not matter
  EXPECT_TRUE(importer_.text("note;x_mm;deviation_x_um\n1.234;0,5;1\n2.345;1,5;2\n").session);
}

TEST_F(Understanding, ThreeDecimalsWithAPointAreNoQuestion) {
  EXPECT_DOUBLE_EQ(
      importer_.text("x_mm;deviation_x_um\n1.234;1\n12.345;2\n").session->observations[1].position[0],
      12.345e-3);
}

TEST_F(Understanding, DeviationsThatDoNotAgreeWithTheMeasuredPositions) {
  const std::string head = "Target X [mm];Measured X [mm];Deviation X [um]\n";
  EXPECT_THAT(importer_.refusal(head + "0;0.002;2\n5;5.003;30\n"),
              AllOf(HasSubstr("f.txt:3: column 'Deviation X [um]' says 30 um"), HasSubstr("is 3 um"),
                    HasSubstr("ignore")));
  // rounding is no disagreement, and the finer one is kept
  const Imported fine = importer_.text(head + "0;0.002;2.4\n5;5.003;2.6\n");
  EXPECT_DOUBLE_EQ(fine.session->observations[1].deviation[0], 2.6e-6);
  const Imported opposite = importer_.text(head + "0;0.002;-2\n5;5.003;-3\n");
  EXPECT_NEAR(opposite.session->observations[1].deviation[0], 3e-6, 1e-12);
  EXPECT_THAT(columnNamed(opposite, "Deviation X [um]")->meaning, HasSubstr("sign changed"));
}

TEST_F(Understanding, AUnitBehindANameOfTime) {
  EXPECT_DOUBLE_EQ(importer_.text("Zeit s;x_mm;deviation_x_um\n0;0;1\n7;1;2\n").session->observations[1].time,
                   7.0);
}

TEST_F(Understanding, DashesOfWindowsAreNotMeasured) {
  const Imported i = importer_.text(
      "x_mm;deviation_x_um;T [\xB0"
      "C]\n0;1;20,5\n1;2;\x96\n2;\x96 3;20,7\n");
  EXPECT_THAT(i.how, HasSubstr("Windows-1252"));
  EXPECT_EQ(i.session->temperatures[0].value.size(), 2u);
  EXPECT_DOUBLE_EQ(i.session->observations[2].deviation[0], -3e-6);
}

/// "Achse X" above the table is said once and counts for every column.
TEST_F(Understanding, AHeadingNamesTheAxis) {
  const std::string csv =
      "Messprotokoll Laserinterferometer Achse Y;;\nMaschine: Messtisch 3;;\n\n"
      "Sollposition [mm];Richtung;Istposition [mm]\n0,000;vor;0,001\n5,000;vor;5,002\n0,000;zurück;0,003\n";
  const Imported i = importer_.text(csv);
  EXPECT_NEAR(i.session->observations[1].position[1], 5e-3, 1e-12);
  EXPECT_NEAR(i.session->observations[1].deviation[1], 2e-6, 1e-12);
  EXPECT_EQ(i.session->observations[2].travel[1], -1.0);
  EXPECT_THAT(::testing::PrintToString(i.notes), HasSubstr("the axis that line 1 names"));
}

/// A bag has no directions but velocities: without motion the next reader would assume them.
TEST_F(Understanding, DirectionsInTheOwnFormatGoIntoTheBag) {
  const Imported i =
      importer_.text("time_s,x_mm,direction_x,deviation_x_um\n0,400,+,-2.3\n8,300,+,1.5\n16,350,-,1.9\n");
  ASSERT_EQ(i.how, "the package's own columns");
  EXPECT_EQ(i.columns[2].unit, "");
  ASSERT_EQ(i.motion.size(), 3u);
  EXPECT_GT(i.motion[1].velocity[0], 0.0) << "though it came from above";
  EXPECT_LT(i.motion[2].velocity[0], 0.0);
  const Imported untold = importer_.text("time_s,x_mm,deviation_x_um\n0,400,-2.3\n8,300,1.5\n16,350,1.9\n");
  EXPECT_TRUE(untold.motion.empty());
}

/// Each line that is proposed can be copied as it stands, and so can the one that has them all.
TEST_F(Understanding, SeveralColumnsGetOneLineForAll) {
  const std::string csv =
      "Sollposition [mm];Richtung;Istposition [mm]\n0,000;vor;0,001\n5,000;vor;5,002\n0,000;zurück;0,003\n";
  const std::string refusal = importer_.refusal(csv);
  const std::string line =
      "columns: {'Sollposition [mm]': x_mm, Richtung: direction_x, 'Istposition [mm]': measured_x_mm}";
  EXPECT_THAT(refusal, HasSubstr("all of these in one line of the mapping (--columns): " + line));
  const Imported i = importer_.text(csv, line + "\n");
  EXPECT_NEAR(i.session->observations[1].deviation[0], 2e-6, 1e-12);
  EXPECT_EQ(i.session->observations[2].travel[0], -1.0);
}

/// The measurement is asked for by its unit; it is never proposed to leave it out.
TEST_F(Understanding, ADialGaugeIsTheMeasurement) {
  const std::string csv =
      "Nr.;Stellung X (mm);Anzeige Messuhr (µm);Bemerkung\n1;0,00;0,2;\n2;1,30;0,7;Umkehr\n3;2,60;-1,0;\n";
  const std::string refusal = importer_.refusal(csv);
  EXPECT_THAT(refusal,
              AllOf(HasSubstr("'Anzeige Messuhr (µm)'"), HasSubstr("error_x_um"), HasSubstr("deviation_x_um"),
                    Not(HasSubstr("Stellung")), Not(HasSubstr("ignore"))));
  const Imported i = importer_.text(csv, "columns: {'Anzeige Messuhr (µm)': deviation_x_um}\n");
  EXPECT_NEAR(i.session->observations[1].deviation[0], 0.7e-6, 1e-12);
  EXPECT_THAT(
      importer_.refusal(csv, "columns: {'Anzeige Messuhr (µm)': ignore}\n"),
      AllOf(HasSubstr("columns: {Anzeige Messuhr (µm): deviation_x_um}"), Not(HasSubstr("feature}"))));
  EXPECT_THAT(importer_.refusal("X (mm);Kragen (µm)\n0;0,2\n1;0,4\n2;-0,1\n"),
              AllOf(HasSubstr("'Kragen (µm)'"), HasSubstr("deviation_x_um"), Not(HasSubstr(": ignore"))));
}

/// What a display shows in mm is where the axis stands.
TEST_F(Understanding, UsualWordsOfGermanAndFrenchFiles) {
  const Imported german = importer_.text(
      "Zeit;Durchlauf;Anzeige X [mm];Abweichung [µm];Anmerkung\n09:00:00;1;0,0;1;a\n09:00:05;1;5,0;2;b\n");
  EXPECT_NEAR(german.session->observations[1].position[0], 5e-3, 1e-12);
  const Imported french = importer_.text(
      "Axe X;;;;\n\nHeure;Consigne [mm];Sens;Écart "
      "[µm];Remarque\n09:00:00;0,0;aller;1;a\n09:00:05;5,0;retour;2;b\n");
  EXPECT_NEAR(french.session->observations[1].position[0], 5e-3, 1e-12);
  EXPECT_NEAR(french.session->observations[1].deviation[0], 2e-6, 1e-12);
  EXPECT_EQ(french.session->observations[1].travel[0], -1.0);
}

}  // namespace
}  // namespace mm
