#include "estimation/thin_qr.h"

#include <gtest/gtest.h>

#include <random>

namespace mm {
namespace {

/// Three blocks of two columns on rows of their own (not in order), three shared columns, rows of no block.
Eigen::MatrixXd blockMatrix(const std::vector<LocalBlock>& blocks, Eigen::Index rows, Eigen::Index columns) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows, columns);
  std::vector<char> local(static_cast<std::size_t>(columns), 0);
  for (const LocalBlock& block : blocks)
    for (const int c : block.columns) {
      local[static_cast<std::size_t>(c)] = 1;
      for (const int i : block.rows) a(i, c) = normal(generator);
    }
  for (Eigen::Index c = 0; c < columns; ++c)
    if (local[static_cast<std::size_t>(c)] == 0)
      for (Eigen::Index i = 0; i < rows; ++i) a(i, c) = normal(generator);
  return a;
}

const std::vector<LocalBlock> kBlocks = {
    {{0, 5, 9, 2}, {1, 4}}, {{3, 1, 12}, {0, 7}}, {{4, 6, 7, 8, 10}, {5, 6}}};

void expectQr(const Eigen::MatrixXd& a, const ThinQr& qr) {
  Eigen::MatrixXd ordered(a.rows(), a.cols());
  for (Eigen::Index k = 0; k < a.cols(); ++k) ordered.col(k) = a.col(qr.order[static_cast<std::size_t>(k)]);
  EXPECT_LT((qr.q * qr.r - ordered).norm(), 1e-13);
  EXPECT_LT((qr.q * qr.rInOrder() - a).norm(), 1e-13);
  EXPECT_LT((qr.q.transpose() * qr.q - Eigen::MatrixXd::Identity(a.cols(), a.cols())).norm(), 1e-13);
  const Eigen::MatrixXd upper = qr.r.triangularView<Eigen::Upper>();
  EXPECT_EQ(upper, qr.r);
}

TEST(ThinQr, IsAQrWithAndWithoutBlocks) {
  const Eigen::MatrixXd a = blockMatrix(kBlocks, 15, 9);
  expectQr(a, thinQr(a, kBlocks, true));
  expectQr(a, thinQr(a, {}, true));
  EXPECT_EQ(thinQr(a, kBlocks, false).q.size(), 0);
}

TEST(ThinQr, IsAQrOfAMatrixThatLacksRank) {
  Eigen::MatrixXd a = blockMatrix(kBlocks, 15, 9);
  a.col(8) = 2.0 * a.col(2);  // among the shared columns
  a.col(4) = a.col(1);        // within a block
  for (const int i : kBlocks[1].rows) a(i, 3) = a(i, 0);
  expectQr(a, thinQr(a, kBlocks, true));
}

TEST(ThinQr, AllColumnsMayBeLocal) {
  const std::vector<LocalBlock> blocks = {{{0, 2, 4}, {1}}, {{1, 3}, {0, 2}}};
  const Eigen::MatrixXd a = blockMatrix(blocks, 6, 3);
  expectQr(a, thinQr(a, blocks, true));
}

TEST(OrthonormalBasis, HasNoDirectionForAColumnThatTheOthersSpanOrThatIsZero) {
  Eigen::MatrixXd a = blockMatrix({}, 15, 6);
  a.col(1) = 3.0 * a.col(0) + 1e-14 * a.col(4);  // rounding
  a.col(2).setZero();
  a.col(5) = 1e-9 * a.col(3) + 1e-15 * a.col(5);  // small, but its own: judged against its own length
  const Eigen::MatrixXd q = orthonormalBasis(a);
  ASSERT_EQ(q.cols(), 4);
  EXPECT_LT((q.transpose() * q - Eigen::MatrixXd::Identity(4, 4)).norm(), 1e-13);
  for (const int c : {0, 1, 3, 4, 5}) {
    const Eigen::VectorXd left = a.col(c) - q * (q.transpose() * a.col(c));
    EXPECT_LT(left.norm(), 1e-12 * a.col(c).norm()) << c;
  }
  EXPECT_EQ(orthonormalBasis(Eigen::MatrixXd::Zero(4, 2)).cols(), 0);
  EXPECT_EQ(orthonormalBasis(Eigen::MatrixXd(4, 0)).cols(), 0);
}

}  // namespace
}  // namespace mm
