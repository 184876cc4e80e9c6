#include "simulation/correction_table.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace mm {
namespace {

CorrectionTable tableOf(const std::string& text) {
  return CorrectionTable::parse(text, "table.csv", Machine::load("three_axis"));
}

std::string refusalOf(const std::string& text) {
  try {
    tableOf(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(CorrectionTable, isLinearBetweenItsNodesAndEndsAtItsEdge) {
  const CorrectionTable table = tableOf("x_mm,correction_x_um\n10,4\n0,1\n");
  const std::vector<double> still(3, 0.0);
  EXPECT_NEAR(table.drives({5e-3, 0.0, 0.0}, still)[0], 5e-3 + 2.5e-6, 1e-15);
  EXPECT_NEAR(table.drives({20e-3, 0.0, 0.0}, still)[0], 20e-3 + 4e-6, 1e-15);
  EXPECT_EQ(table.drives({5e-3, 7e-3, 0.0}, still)[1], 7e-3);
}

TEST(CorrectionTable, takesTheDirectionOfTravel) {
  const CorrectionTable table = tableOf("x_travel,correction_y_um\n-1,-2\n1,2\n");
  EXPECT_NEAR(table.drives({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0})[1], 2e-6, 1e-18);
  EXPECT_NEAR(table.drives({0.0, 0.0, 0.0}, {-1.0, 0.0, 0.0})[1], -2e-6, 1e-18);
  EXPECT_NEAR(table.drives({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0})[1], 0.0, 1e-18);  // has not moved: the mean
}

TEST(CorrectionTable, refusesWhatItCannotUse) {
  EXPECT_NE(refusalOf("x_mm,correction_q_um\n0,1\n").find("table.csv:1: column 'correction_q_um'"),
            std::string::npos);
  EXPECT_NE(refusalOf("x_mm,correction_x_um\n0,one\n").find("table.csv:2: 'one'"), std::string::npos);
  EXPECT_NE(refusalOf("x_mm,y_mm,correction_x_um\n0,0,1\n0,1,1\n1,0,1\n").find("grid of 4"),
            std::string::npos);
  EXPECT_NE(refusalOf("x_mm,correction_x_um\n0,1\n0,2\n1,1\n").find("3 rows"), std::string::npos);
  EXPECT_NE(refusalOf("x_mm\n0\n").find("corrects nothing"), std::string::npos);
}

}  // namespace
}  // namespace mm
