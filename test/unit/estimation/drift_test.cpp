#include "estimation/drift.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "estimation/noise_fit.h"

using namespace mm;

namespace {

/// The covariance functions as they stand in Rasmussen & Williams, eq. 4.16 and 4.17.
double matern(const DriftTerm& t, double apart) {
  if (!t.smooth) return std::exp(-apart / t.tau);
  const double a = std::sqrt(3.0) * apart / t.tau;
  return (1.0 + a) * std::exp(-a);
}

/// A small session with uneven times, two directions and two drift terms, and its covariance written out.
struct Small {
  std::vector<double> time = {0.0, 1.0, 1.0, 2.5, 7.0, 7.5, 20.0, 21.0, 60.0, 61.0, 62.0, 90.0};
  RowMatrix factors;
  Eigen::VectorXd variance;
  std::vector<DriftTerm> terms = {
      {0, 1.3, 10.0}, {1, 0.7, 2.0}, {0, 0.5, 100.0}, {1, 0.9, 20.0, true}, {0, 1.1, 60.0, true}};

  Small() : factors(12, 2), variance(12) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 12; ++i) {
      factors(i, 0) = normal(random);
      factors(i, 1) = normal(random);
      variance[i] = 0.5 + 0.1 * i;
    }
  }
  Eigen::MatrixXd drift(std::size_t only = 99) const {
    Eigen::MatrixXd v = Eigen::MatrixXd::Zero(12, 12);
    for (std::size_t k = 0; k < terms.size(); ++k)
      if (only == 99 || only == k)
        for (int i = 0; i < 12; ++i)
          for (int j = 0; j < 12; ++j)
            v(i, j) += terms[k].ratio * terms[k].ratio * factors(i, terms[k].direction) *
                       factors(j, terms[k].direction) * matern(terms[k], std::abs(time[i] - time[j]));
    return v;
  }
  Eigen::MatrixXd covariance() const { return drift() + Eigen::MatrixXd(variance.asDiagonal()); }
};

TEST(Drift, WhitensAsTheCholeskyFactorOfTheCovarianceDoes) {
  const Small s;
  const TimeWhitener whitener(s.time, s.factors, s.variance, s.terms);
  RowMatrix m = RowMatrix::Random(14, 3);
  RowMatrix whitened = m;
  whitener.whiten(whitened);
  const Eigen::LLT<Eigen::MatrixXd> llt(s.covariance());
  const Eigen::MatrixXd expected = llt.matrixL().solve(Eigen::MatrixXd(m.topRows(12)));
  EXPECT_LT((whitened.topRows(12) - expected).norm(), 1e-10);
  EXPECT_EQ((whitened.bottomRows(2) - m.bottomRows(2)).norm(), 0.0);  // what has no time is left as it is
  double logDeterminant = 0.0;
  for (int i = 0; i < 12; ++i) logDeterminant += 2.0 * std::log(llt.matrixLLT()(i, i));
  EXPECT_NEAR(whitener.logDeterminant(), logDeterminant, 1e-10);
}

TEST(Drift, ExpectedDriftIsThatOfTheGaussianConditional) {
  const Small s;
  const TimeWhitener whitener(s.time, s.factors, s.variance, s.terms);
  const Eigen::VectorXd r = Eigen::VectorXd::LinSpaced(12, -1.0, 2.0);
  const Eigen::VectorXd solved = s.covariance().ldlt().solve(r);
  EXPECT_LT((whitener.driftIn(r) - s.drift() * solved).norm(), 1e-10);
  const Eigen::MatrixXd byTerm = whitener.driftByTerm(r);
  for (int k = 0; k < 5; ++k)
    EXPECT_LT((byTerm.col(k) - s.drift(static_cast<std::size_t>(k)) * solved).norm(), 1e-10);
}

TEST(Drift, SinceTheFirstRowIsThatOfTheConditionalGivenNothingThere) {
  Small s;
  s.factors.setOnes();  // each direction is seen at the first row
  const TimeWhitener whitener(s.time, s.factors, s.variance, s.terms, true);
  Eigen::MatrixXd covariance = s.variance.asDiagonal();
  for (std::size_t k = 0; k < s.terms.size(); ++k) {
    const Eigen::MatrixXd of = s.drift(k);
    covariance += of - of.col(0) * of.row(0) / of(0, 0);
  }
  RowMatrix m = RowMatrix::Random(12, 2);
  RowMatrix whitened = m;
  whitener.whiten(whitened);
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  EXPECT_LT((whitened - RowMatrix(llt.matrixL().solve(Eigen::MatrixXd(m)))).norm(), 1e-10);
  EXPECT_LT((whitener.covarianceTimes(m) - RowMatrix(covariance * m)).norm(), 1e-10);
  EXPECT_NEAR(whitener.driftIn(Eigen::VectorXd(m.col(0)))[0], 0.0, 1e-10);
}

TEST(Drift, ARowThatIsLeftOutIsPredictedFromItsNeighbours) {
  Small s;
  const Eigen::VectorXd r = Eigen::VectorXd::LinSpaced(12, -1.0, 2.0);
  s.variance[5] = 1e10;
  const TimeWhitener whitener(s.time, s.factors, s.variance, s.terms);
  // the conditional without row 5, written out
  const Eigen::MatrixXd all = s.drift();
  Eigen::MatrixXd covariance(11, 11);
  Eigen::VectorXd cross(11), known(11);
  for (int i = 0, a = 0; i < 12; ++i) {
    if (i == 5) continue;
    cross[a] = all(5, i);
    known[a] = r[i];
    for (int j = 0, b = 0; j < 12; ++j)
      if (j != 5) covariance(a, b++) = all(i, j) + (i == j ? s.variance[i] : 0.0);
    ++a;
  }
  EXPECT_NEAR(whitener.driftIn(r)[5], cross.dot(covariance.ldlt().solve(known)), 1e-6);
}

/// Rows whose residual is white noise and, if asked, drift by a random walk: not the kernel of the fit.
NoiseRows walking(int n, double walk, unsigned seed, Eigen::VectorXd* truth = nullptr) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  NoiseRows rows;
  rows.factors = RowMatrix::Ones(n, 1);
  rows.target.resize(n);
  rows.base = RowMatrix::Constant(n, 1, 1.0 / std::sqrt(n));
  Eigen::VectorXd drift(n);
  double at = 0.0;
  for (int i = 0; i < n; ++i) {
    rows.time.push_back(6.0 * i);
    drift[i] = at += normal(random);
  }
  drift.array() -= drift.mean();
  drift *= walk / std::sqrt(drift.squaredNorm() / n);
  for (int i = 0; i < n; ++i) rows.target[i] = normal(random) + drift[i];
  if (truth != nullptr) *truth = drift;
  return rows;
}

NoiseModel whiteNoise(int n) {
  NoiseModel noise;
  noise.variance = Eigen::VectorXd::Ones(n);
  return noise;
}

TEST(NoiseFit, EvidenceIsThatOfTheDenseFormula) {
  const NoiseRows rows = walking(60, 1.0, 5);
  NoiseModel noise = whiteNoise(60);
  noise.drift = {{0, 0.8, 50.0}};
  RandomBlock block;
  block.columns = RowMatrix::Random(60, 3);
  block.ratio = 0.6;
  block.fixed = true;
  NoiseFitOptions options;
  options.driftPrice = 0.0;
  const NoiseFitResult fit = NoiseFit(rows, {block}).at(noise, options);
  Eigen::MatrixXd v = Eigen::MatrixXd::Identity(60, 60) + 0.36 * block.columns * block.columns.transpose();
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) v(i, j) += 0.64 * std::exp(-6.0 * std::abs(i - j) / 50.0);
  const Eigen::MatrixXd inverse = v.inverse();
  const Eigen::MatrixXd information = rows.base.transpose() * inverse * rows.base;
  const Eigen::MatrixXd p =
      inverse - inverse * rows.base * information.inverse() * rows.base.transpose() * inverse;
  const double rest = rows.target.dot(p * rows.target);
  const Eigen::LLT<Eigen::MatrixXd> llt(v);
  double logDeterminant = std::log(information(0, 0));
  for (int i = 0; i < 60; ++i) logDeterminant += 2.0 * std::log(llt.matrixLLT()(i, i));
  EXPECT_NEAR(fit.logEvidence, -0.5 * logDeterminant - 0.5 * 59 * std::log(rest / 59), 1e-6);
  EXPECT_NEAR(fit.white, std::sqrt(rest / 59), 1e-8);
}

TEST(NoiseFit, WhiteNoiseHasNoDriftAndAWalkHas) {
  int drifts = 0;
  double white = 0.0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const NoiseRows quiet = walking(200, 0.0, seed);
    drifts += !NoiseFit(quiet, {}).run(whiteNoise(200), {}).noise.drift.empty();
    const NoiseRows rough = walking(200, 1.0, seed);
    const NoiseFitResult fit = NoiseFit(rough, {}).run(whiteNoise(200), {});
    ASSERT_FALSE(fit.noise.drift.empty()) << seed;
    white += fit.white / 40.0;
    // what is taken for drift is the drift
    Eigen::VectorXd truth;
    walking(200, 1.0, seed, &truth);
    const TimeWhitener whitener(rough.time, rough.factors, fit.noise.variance, fit.noise.drift);
    const Eigen::VectorXd drift = whitener.driftIn(rough.target.head(200));
    EXPECT_LT((drift - truth).squaredNorm(), 0.5 * truth.squaredNorm()) << seed;
  }
  EXPECT_LE(drifts, 3);  // at a price of 3 nats one in twenty would be many
  EXPECT_NEAR(white, 1.0, 0.06);
}

/// Each of three axes remembers from reading to reading and wanders besides: a wandering that the noise has
/// no term for would have to be a cause.
TEST(NoiseFit, ManyTermsAreFoundWhereThereAreMany) {
  constexpr int kRows = 900;
  NoiseRows rows;
  rows.factors = RowMatrix::Zero(kRows, 3);
  rows.target.resize(kRows);
  rows.base = RowMatrix::Constant(kRows, 1, 1.0 / std::sqrt(double(kRows)));
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  double fast[3] = {}, slow[3] = {};
  const auto next = [&](double& value, double tau) {
    const double stays = std::exp(-1.0 / tau);
    value = stays * value + std::sqrt(1.0 - stays * stays) * normal(random);
  };
  for (int i = 0; i < kRows; ++i) {
    const int axis = i / 15 % 3;  // stretches along one axis, as of ball after ball
    for (double& value : fast) next(value, 4.0);
    for (double& value : slow) next(value, 150.0);
    rows.time.push_back(i);
    rows.factors(i, axis) = 1.0;
    rows.target[i] = 2.0 * fast[axis] + 3.0 * slow[axis] + normal(random);
  }
  const NoiseFitResult fit = NoiseFit(rows, {}).run(whiteNoise(kRows), {});
  // one term between both may stand for those of an axis
  EXPECT_GE(fit.noise.drift.size(), 5u);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_TRUE(std::any_of(fit.noise.drift.begin(), fit.noise.drift.end(),
                            [&](const DriftTerm& t) { return t.direction == axis && t.tau > 30.0; }))
        << "the slow one of axis " << axis;
}

}  // namespace
