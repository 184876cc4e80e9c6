#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "diagnosis/answers.h"

namespace mm {
namespace {

constexpr int kRows = 120, kBad = 117;

/// A constant and white noise, and some bad readings.
Questions measured() {
  Questions q;
  Random random(4, "tails");
  q.rows.time.resize(kRows);
  q.rows.factors = RowMatrix::Ones(kRows, 1);
  q.groups.columns.resize(kRows, 0);
  q.rows.target.resize(kRows);
  q.rows.base = RowMatrix::Constant(kRows, 1, 1.0 / std::sqrt(kRows));
  for (int i = 0; i < kRows; ++i) {
    q.rows.time[static_cast<std::size_t>(i)] = 10.0 * i;
    q.rows.target[i] = random.normal();
  }
  for (const int i : {10, 25, 40, 55, 70, 85}) q.rows.target[i] += i % 2 == 0 ? 20.0 : -20.0;
  q.rows.target[kBad] += 25.0;
  return q;
}

/// One of two steps of two axes behind the same row: they differ in one reading.
Member stepThatDiffersBy(double more) {
  RowMatrix columns = RowMatrix::Zero(kRows, 1);
  columns.bottomRows(5).setOnes();
  columns(kBad, 0) += more;
  Member m;
  m.size = 30.0;
  m.columns = std::make_shared<RowMatrix>(columns);
  return m;
}

TEST(Tails, AReadingForWhichACauseWasFoundIsStillABadOne) {
  const Questions q = measured();
  Explanation found;
  found.noise.variance = Eigen::VectorXd::Ones(kRows);
  found.members = {stepThatDiffersBy(0.0), stepThatDiffersBy(0.3)};
  const Search search(q);
  const double left = q.rows.target[kBad] - search.evidenceAt(found)->fit(found.members).expected[kBad];
  ASSERT_LT(std::abs(left), 2.0) << "the two explain it";
  const Tails tails = tailsOf(search, found);
  ASSERT_GT(tails.dof, 0.0);
  EXPECT_GT(tails.variance[kBad], 3.0);
  EXPECT_LT(tails.variance[kBad - 1], 2.0);
}

TEST(Tails, ThereAreNoneWhereNoReadingIsBad) {
  Questions q = measured();
  Random random(5, "no tails");
  for (double& value : q.rows.target) value = random.normal();
  Explanation found;
  found.noise.variance = Eigen::VectorXd::Ones(kRows);
  EXPECT_EQ(tailsOf(Search(q), found).dof, 0.0);
}

}  // namespace
}  // namespace mm
