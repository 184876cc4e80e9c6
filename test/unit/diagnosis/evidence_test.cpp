#include "diagnosis/evidence.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

using namespace mm;

namespace {

/// Made-up rows and three groups of made-up columns, small enough to write everything out.
struct Made {
  static constexpr int kRows = 50;
  NoiseRows rows;
  Groups groups;
  NoiseModel noise;

  explicit Made(unsigned seed = 2) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    rows.factors = RowMatrix::Ones(kRows, 1);
    rows.target.resize(kRows);
    rows.base = RowMatrix::Constant(kRows, 1, 1.0 / std::sqrt(kRows));
    groups.columns.resize(kRows, 6);
    for (int i = 0; i < kRows; ++i) {
      rows.time.push_back(3.0 * i);
      rows.target[i] = normal(random);
      for (int k = 0; k < 6; ++k) groups.columns(i, k) = normal(random);
    }
    rows.target += 0.8 * groups.columns.col(2);
    const int counts[] = {2, 3, 1};
    int first = 0;
    for (int g = 0; g < 3; ++g) {
      Group group;
      group.key = std::to_string(g);
      Shape shape;
      shape.first = first;
      shape.count = shape.main = counts[g];
      first += counts[g];
      group.shapes = {shape};
      groups.groups.push_back(group);
    }
    noise.variance = Eigen::VectorXd::Constant(kRows, 1.0);
    noise.drift = {{0, 0.7, 20.0}};
  }

  Eigen::MatrixXd covariance() const {
    Eigen::MatrixXd v = noise.variance.asDiagonal();
    for (const DriftTerm& t : noise.drift)
      for (int i = 0; i < kRows; ++i)
        for (int j = 0; j < kRows; ++j)
          v(i, j) += t.ratio * t.ratio * std::exp(-std::abs(rows.time[i] - rows.time[j]) / t.tau);
    return v;
  }

  double brute(const Eigen::MatrixXd& v) const {
    const Eigen::MatrixXd inverse = v.inverse();
    const Eigen::MatrixXd information = rows.base.transpose() * inverse * rows.base;
    const Eigen::MatrixXd p =
        inverse - inverse * rows.base * information.inverse() * rows.base.transpose() * inverse;
    const Eigen::LLT<Eigen::MatrixXd> llt(v);
    double logDeterminant = std::log(information.determinant());
    for (int i = 0; i < v.rows(); ++i) logDeterminant += 2.0 * std::log(llt.matrixLLT()(i, i));
    const double freedoms = kRows - 1, rest = rows.target.dot(p * rows.target);
    return -0.5 * logDeterminant - 0.5 * freedoms * std::log(rest / freedoms);
  }

  Member member(int group, double size) const {
    const Shape& s = groups.groups[group].shapes[0];
    Member m;
    m.group = group;
    m.size = size;
    m.columns = std::make_shared<RowMatrix>(groups.columns.middleCols(s.first, s.count));
    return m;
  }
};

TEST(Evidence, IsThatOfTheDenseFormula) {
  const Made made;
  const Evidence evidence(made.rows, made.groups, made.noise, {}, {});
  Eigen::MatrixXd v = made.covariance();
  EXPECT_NEAR(evidence.given({}).logEvidence, made.brute(v), 1e-6);
  const Member a = made.member(0, 0.5), b = made.member(1, 1.5);
  v += 0.25 * *a.columns * a.columns->transpose() + 2.25 * *b.columns * b.columns->transpose();
  EXPECT_NEAR(evidence.given({a, b}).logEvidence, made.brute(v), 1e-6);
}

TEST(Evidence, AGainIsADifferenceOfEvidence) {
  const Made made;
  const Evidence evidence(made.rows, made.groups, made.noise, {}, {});
  const Member a = made.member(0, 0.5);
  const Evidence::Given given = evidence.given({a});
  const Gain gain = evidence.gainOf(given, 1);
  ASSERT_GT(gain.size, 0.0);
  EXPECT_NEAR(gain.value, evidence.given({a, made.member(1, gain.size)}).logEvidence - given.logEvidence,
              1e-8);
  for (const double other : {0.5 * gain.size, 2.0 * gain.size})
    EXPECT_LE(evidence.given({a, made.member(1, other)}).logEvidence, given.logEvidence + gain.value + 1e-9);
  EXPECT_NEAR(evidence.gainOf(given, *made.member(1, 1.0).columns).value, gain.value, 1e-8);
  EXPECT_EQ(evidence.gains(evidence.given({})).front().group, 1);
}

TEST(Evidence, ASizeThatIsNotUsualHasItsPrice) {
  Made made;
  const Evidence evidence(made.rows, made.groups, made.noise, {}, {});
  const Evidence::Given given = evidence.given({});
  const Gain usual = evidence.gainOf(given, 1);
  const Evidence::Fit fit = evidence.fit({made.member(1, usual.size)});
  EXPECT_NEAR(usual.coefficient, fit.values[0][0], 1e-8);
  Shape& shape = made.groups.groups[1].shapes[0];
  shape.usual = 1e6 * std::abs(usual.coefficient);
  EXPECT_NEAR(evidence.gainOf(given, 1).value, usual.value, 1e-8) << "an ordinary size costs nothing";
  shape.usual = std::abs(usual.coefficient) / 10.0;
  const Gain unusual = evidence.gainOf(given, 1);
  EXPECT_NEAR(unusual.value, usual.value - 1.5 * std::log1p(100.0), 1e-8);
  EXPECT_EQ(unusual.size, usual.size);
}

TEST(Evidence, RowsHeldOutCountNothing) {
  Made made;
  std::vector<char> held(Made::kRows, 0);
  for (int i = 20; i < 26; ++i) held[i] = 1;
  const Evidence before(made.rows, made.groups, made.noise, {}, {}, &held);
  const double gain = before.gainOf(before.given({}), 1).value;
  for (int i = 20; i < 26; ++i) made.rows.target[i] = 40.0;
  const Evidence after(made.rows, made.groups, made.noise, {}, {}, &held);
  EXPECT_NEAR(after.gainOf(after.given({}), 1).value, gain, 1e-4);
}

TEST(Evidence, OfNothingThereIsHardlyAnyGain) {
  // with a prior of one size the gain exceeds g by chance less often than exp(-g); the best of all sizes
  // little more
  int above = 0, asked = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const Made made(seed + 10);
    const Evidence evidence(made.rows, made.groups, made.noise, {}, {});
    for (const int g : {0, 2}) {
      above += evidence.gainOf(evidence.given({}), g).value > 3.0;
      ++asked;
    }
  }
  EXPECT_LE(above, 0.02 * asked);
}

TEST(Evidence, CoefficientsAreThoseOfTheGaussianPosterior) {
  const Made made;
  const Evidence evidence(made.rows, made.groups, made.noise, {}, {});
  const Member b = made.member(1, 1.5);
  const Evidence::Fit fit = evidence.fit({b});
  Eigen::MatrixXd all(Made::kRows, 4);
  all << made.rows.base, *b.columns;
  const Eigen::MatrixXd inverse = made.covariance().inverse();
  Eigen::MatrixXd m = all.transpose() * inverse * all;
  for (int k = 1; k < 4; ++k) m(k, k) += 1.0 / 2.25;
  const Eigen::VectorXd values = m.ldlt().solve(all.transpose() * inverse * made.rows.target);
  EXPECT_LT((fit.values[0] - values.tail(3)).norm(), 1e-6);
  EXPECT_NEAR(fit.values[0][0], 0.8, 0.5);
}

}  // namespace
