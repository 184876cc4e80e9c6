#include "estimation/row_products.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

using namespace mm;

namespace {

RowMatrix drawn(int rows, int columns, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return RowMatrix::NullaryExpr(rows, columns, [&] { return normal(random); });
}

}  // namespace

TEST(RowProducts, AreThoseOfTheDefinitionAtEverySizeOfTheirTiles) {
  for (const int rows : {0, 1, 255, 256, 700})
    for (const int down : {1, 3, 4, 9})
      for (const int across : {1, 11, 12, 13, 30}) {
        const RowMatrix a = drawn(rows, down, 1), b = drawn(rows, across, 2);
        const Eigen::MatrixXd expected = a.transpose() * b;
        EXPECT_LT((rowProducts(a, b) - expected).cwiseAbs().maxCoeff(), 1e-11)
            << rows << " rows, " << down << " x " << across;
      }
}

TEST(RowProducts, OfAMatrixWithItselfAreWholeAndSymmetric) {
  for (const int columns : {1, 5, 12, 13, 29}) {
    const RowMatrix a = drawn(300, columns, 3);
    const RowMatrix own = rowProducts(a);
    EXPECT_EQ(own, RowMatrix(own.transpose()));
    EXPECT_LT((own - RowMatrix(a.transpose() * a)).cwiseAbs().maxCoeff(), 1e-11) << columns;
  }
}

TEST(RowProducts, ReadColumnsOutOfTheMiddle) {
  const RowMatrix all = drawn(50, 20, 4);
  const Eigen::MatrixXd expected = all.middleCols(3, 7).transpose() * all.rightCols(5);
  EXPECT_LT((rowProducts(all.middleCols(3, 7), all.rightCols(5)) - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(PackedColumns, GiveTheSameProductsAsTheColumnsThemselves) {
  for (const int rows : {0, 1, 256, 700})
    for (const int columns : {1, 12, 13, 40}) {
      const RowMatrix all = drawn(rows, columns, 5), few = drawn(rows, 3, 6);
      const RowMatrix expected = few.transpose() * all;
      const PackedColumns packed(all);
      RowMatrix got = RowMatrix::Constant(3, columns, 7.0);
      packed.productsWith(few, 0, columns, got);
      EXPECT_EQ(got.cols(), columns);
      EXPECT_LT((got - expected).cwiseAbs().maxCoeff(), 1e-11) << rows << " rows, " << columns;
      if (columns < 26) continue;
      got.setConstant(7.0);
      packed.productsWith(few, 13, 14, got);
      EXPECT_LT((got.middleCols(12, 12) - expected.middleCols(12, 12)).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_EQ(got.leftCols(12), RowMatrix::Constant(3, 12, 7.0)) << "what nobody asked for stays";
      EXPECT_EQ(got.rightCols(16), RowMatrix::Constant(3, 16, 7.0));
    }
}
