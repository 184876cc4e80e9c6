#include "base/dense.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

Eigen::MatrixXd matrix(std::initializer_list<std::initializer_list<double>> rows) {
  return Eigen::MatrixXd(rows);
}

TEST(Dense, LeastSquaresOfALine) {
  // y = 1 + 2 t, and a residual (1, -2, 1) / 10 that no line sees
  const Eigen::MatrixXd a = matrix({{1, 0}, {1, 1}, {1, 2}});
  const Eigen::VectorXd x = leastSquares(a, Eigen::Vector3d(1.1, 2.8, 5.1));
  EXPECT_NEAR(x[0], 1.0, 1e-14);
  EXPECT_NEAR(x[1], 2.0, 1e-14);
}

TEST(Dense, OfManySolutionsTheShortest) {
  const Eigen::VectorXd x = shortestLeastSquares(matrix({{1, 1}}), Eigen::VectorXd::Constant(1, 2.0));
  EXPECT_NEAR(x[0], 1.0, 1e-15);
  EXPECT_NEAR(x[1], 1.0, 1e-15);
  const Eigen::MatrixXd nearly = matrix({{1, 0}, {0, 1e-6}});
  EXPECT_NEAR(shortestLeastSquares(nearly, Eigen::Vector2d(1, 1))[1], 1e6, 1e-3);
  EXPECT_EQ(shortestLeastSquares(nearly, Eigen::Vector2d(1, 1), 1e-3)[1], 0.0) << "below the threshold";
}

TEST(Dense, RankAndSpanByTheSameThreshold) {
  const Eigen::MatrixXd a = matrix({{1, 1, 0}, {1, 1, 0}, {0, 0, 1e-6}});
  EXPECT_EQ(rankOf(a), 2);
  EXPECT_EQ(rankOf(a, 1e-3), 1);
  const Eigen::MatrixXd span = spanOf(a, 1e-3);
  ASSERT_EQ(span.cols(), 1);
  EXPECT_NEAR(std::abs(span(0, 0)), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(span(0, 0), span(1, 0), 1e-15);
  EXPECT_EQ(spanOf(Eigen::MatrixXd::Zero(3, 2)).cols(), 0);
}

TEST(Dense, SymmetricMatrices) {
  const Eigen::MatrixXd a = matrix({{2, 1}, {1, 2}});  // eigenvalues 1 and 3, inverse [2 -1; -1 2] / 3
  const SymmetricEigen eigen(a);
  EXPECT_NEAR(eigen.values[0], 1.0, 1e-15);
  EXPECT_NEAR(eigen.values[1], 3.0, 1e-15);
  EXPECT_NEAR(std::abs(eigen.vectors(0, 1)), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(inverseOfSymmetric(a)(0, 1), -1.0 / 3.0, 1e-15);
  EXPECT_NEAR(solveSymmetric(a, Eigen::Vector2d(3, 0))[0], 2.0, 1e-15);
  EXPECT_NEAR(pseudoInverse(matrix({{2, 0}, {0, 0}}))(0, 0), 0.5, 1e-15);
}

}  // namespace
}  // namespace mm
