#include "session/csv_cells.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

double read(const char* cell, bool decimalComma) {
  double value = NAN;
  return parseNumber(cell, decimalComma, value) ? value : NAN;
}

TEST(CsvCells, NumbersWithADecimalPoint) {
  EXPECT_EQ(read("12.5", false), 12.5);
  EXPECT_EQ(read("+.5", false), 0.5);
  EXPECT_EQ(read("-1e-3", false), -1e-3);
  EXPECT_EQ(read("\xE2\x88\x92 2", false), -2.0) << "a minus of typesetters, and a blank behind it";
  EXPECT_EQ(read("1,234.567", false), 1234.567);
  EXPECT_EQ(read("-1,234,567", false), -1234567.0);
  EXPECT_EQ(read("1 234.5", false), 1234.5);
  EXPECT_EQ(read("1'234.5", false), 1234.5);
  EXPECT_EQ(read("1\xE2\x80\x99"
                 "234",
                 false),
            1234.0);
  EXPECT_EQ(read("16\xC2\xA0"
                 "000",
                 false),
            16000.0);
}

TEST(CsvCells, NumbersWithADecimalComma) {
  EXPECT_EQ(read("12,5", true), 12.5);
  EXPECT_EQ(read("-0,250", true), -0.25);
  EXPECT_EQ(read("1.234,567", true), 1234.567);
  EXPECT_EQ(read("1.234.567", true), 1234567.0);
  EXPECT_EQ(read("16\xE2\x80\xAF"
                 "000,25",
                 true),
            16000.25);
  EXPECT_EQ(read("1,5e-3", true), 1.5e-3);
  EXPECT_EQ(read("12", true), 12.0);
}

TEST(CsvCells, WhatIsNoNumber) {
  for (const char* cell : {"", "-", "--2", "1-2", "23:59:50", "12.03.2025", "1.2.3", "1+", "oops", "inf",
                           "nan", "1 2", "1,23,456", "0,123,456", "1,234e3", "12 mm", "1,234 567", "1e", "."})
    EXPECT_TRUE(std::isnan(read(cell, false))) << cell;
  for (const char* cell :
       {"1.23", "12.5", "1.5e3", "1,5.2", "12.03.2025", "0.123", "1,2,3", "1.2345", ",", "1,234.5"})
    EXPECT_TRUE(std::isnan(read(cell, true))) << cell;
}

TEST(CsvCells, WhatTheMarksSay) {
  for (const char* cell : {"12.5", "1,234.5", "1,234,567", "0.123", "1234.567", "1.5e3", "12.5 mm"})
    EXPECT_EQ(decimalMarkOf(cell), DecimalMark::kPoint) << cell;
  for (const char* cell : {"12,5", "1.234,5", "1.234.567", "0,123", "1234,567", "-,5"})
    EXPECT_EQ(decimalMarkOf(cell), DecimalMark::kComma) << cell;
  for (const char* cell : {"1.234", "-12.345", "123.456 mm"})
    EXPECT_EQ(decimalMarkOf(cell), DecimalMark::kPointOrNot) << cell;
  for (const char* cell : {"1,234", "-12,345"})
    EXPECT_EQ(decimalMarkOf(cell), DecimalMark::kCommaOrNot) << cell;
  for (const char* cell : {"12", "", "-", "x", "12.03.2025", "10:15:03,5", "2025-03-12 14:00:05.123"})
    EXPECT_EQ(decimalMarkOf(cell), DecimalMark::kNone) << cell;
}

TEST(CsvCells, NotMeasured) {
  for (const char* cell : {"nan", "NaN", "n/a", "#N/A", "<NA>", "n.d.", "-", "---", "-----", "\xE2\x80\x93",
                           "#DIV/0!", "#WERT!", "null"})
    EXPECT_TRUE(meansNothing(cell)) << cell;
  for (const char* cell : {"", "0", "-1", "soon", "nano", "x-"}) EXPECT_FALSE(meansNothing(cell)) << cell;
}

TEST(CsvCells, UnitsBehindNumbers) {
  EXPECT_EQ(withoutUnit("12.5 mm", "mm"), "12.5");
  EXPECT_EQ(withoutUnit("12.5", "mm"), "12.5");
  EXPECT_EQ(withoutUnit("mm", "mm"), "mm");
}

}  // namespace
}  // namespace mm
