#include "posterior/size_grid.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

using namespace mm;

TEST(SizeGrid, BayesFactorsAreThoseOfDenseMatrices) {
  for (const int k : {1, 2, 3, 7, 20}) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Random(30, k);
    if (k == 7) h.col(3) = h.col(1);  // two that are the same
    if (k == 3) h.col(2).setZero();   // and one of nothing
    const Eigen::VectorXd y = 3.0 * Eigen::VectorXd::Random(30);
    const double rest = y.squaredNorm() + 4.0, freedoms = 33.0;
    Eigen::MatrixXd products = h.transpose() * h;
    Eigen::VectorXd target = h.transpose() * y;
    const Sizes got = logBayesFactors(products, target, rest, freedoms);
    for (int i = 0; i < kSizes; ++i) {
      const double s = sizeGrid()[i];
      const Eigen::MatrixXd v = Eigen::MatrixXd::Identity(30, 30) + s * s * h * h.transpose();
      const Eigen::LLT<Eigen::MatrixXd> llt(v);
      const double determinant = 2.0 * Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum();
      const double left = y.dot(llt.solve(y)) + 4.0;
      EXPECT_NEAR(got[i], -0.5 * determinant - 0.5 * freedoms * std::log(left / rest), 1e-7) << k << " " << i;
    }
  }
}

TEST(SizeGrid, ColumnsOfWhichNothingIsLeftSayNothing) {
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(4, 4);
  Eigen::VectorXd target = Eigen::VectorXd::Zero(4);
  EXPECT_LT(logBayesFactors(products, target, 10.0, 9.0).abs().maxCoeff(), 1e-12);
}
