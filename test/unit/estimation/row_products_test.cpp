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
