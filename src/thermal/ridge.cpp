#include "thermal/ridge.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/dense.h"
#include "base/error.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

/// Linear model y = offset + slopes^T x, its slopes held back by a ridge: minimises
/// |Y - model|^2 + lambda * n * |slopes of the standardised inputs|^2. The offset is not penalised. An input
/// that does not vary gets slope 0.
struct RidgeModel {
  Eigen::VectorXd offset;  // outputs
  Eigen::MatrixXd slopes;  // inputs x outputs, unit of the output per unit of the input
  double lambda = 0.0;

  /// @param x a sample a row, in the unit of the samples that were learned.
  Eigen::MatrixXd evaluate(const Eigen::MatrixXd& x) const {
    return (x * slopes).rowwise() + offset.transpose();
  }
};

/// The decomposition that all penalties share.
struct Decomposition {
  Eigen::RowVectorXd meanX, meanY, deviation;
  Eigen::MatrixXd vectors, projected;  // of the correlation matrix; projected right-hand side
  Eigen::VectorXd values;

  Decomposition(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
    const double n = static_cast<double>(x.rows());
    meanX = x.colwise().mean();
    meanY = y.colwise().mean();
    Eigen::MatrixXd centred = x.rowwise() - meanX;
    deviation = (centred.colwise().squaredNorm() / n).cwiseSqrt();
    for (Eigen::Index i = 0; i < deviation.size(); ++i)
      centred.col(i) *= deviation(i) > 0.0 ? 1.0 / deviation(i) : 0.0;
    const SymmetricEigen solver(centred.transpose() * centred / n);
    vectors = solver.vectors;
    values = solver.values.cwiseMax(0.0);
    projected = vectors.transpose() * (centred.transpose() * (y.rowwise() - meanY)) / n;
  }

  RidgeModel model(double lambda) const {
    RidgeModel m;
    m.lambda = lambda;
    // A direction in which the inputs do not vary beyond rounding says nothing: its slope is 0.
    constexpr double kNotVarying = 1e-13;  // of the largest variance
    const double floor = kNotVarying * std::max(1.0, values.maxCoeff());
    Eigen::VectorXd inverse(values.size());
    for (Eigen::Index i = 0; i < values.size(); ++i)
      inverse(i) = values(i) > floor ? 1.0 / (values(i) + lambda) : 0.0;
    m.slopes = vectors * (inverse.asDiagonal() * projected);
    for (Eigen::Index i = 0; i < deviation.size(); ++i)
      m.slopes.row(i) *= deviation(i) > 0.0 ? 1.0 / deviation(i) : 0.0;
    m.offset = (meanY - meanX * m.slopes).transpose();
    return m;
  }
};

/// See newRidgeNetwork().
class RidgeNetwork : public ThermalNetwork {
 public:
  explicit RidgeNetwork(const NetworkSettings& settings) : ThermalNetwork(settings) {}

  NetworkKind kind() const override { return NetworkKind::kRidge; }
  void evaluate(const double* x, double* y) const override {
    for (int o = 0; o < outputs(); ++o) {
      y[o] = model_.offset(o);
      for (int i = 0; i < inputs(); ++i) y[o] += model_.slopes(i, o) * x[i];
    }
  }

 protected:
  void learn() override {
    const RidgeValidation validation = validateRidge(x_, y_, blockedFolds(samples(), blocks()));
    heldOut_ = validation.rms;
    model_ = Decomposition(x_, y_).model(validation.lambda);
  }
  void store(NetworkNumbers& numbers) override {
    numbers(model_.lambda);
    numbers(heldOut_);
    numbers(model_.offset, outputs(), 1);
    numbers(model_.slopes, inputs(), outputs());
  }

 private:
  RidgeModel model_;
  double heldOut_ = 0.0;  // unit of y
};

}  // namespace

std::unique_ptr<ThermalNetwork> newRidgeNetwork(const NetworkSettings& settings) {
  return std::make_unique<RidgeNetwork>(settings);
}

std::vector<Fold> blockedFolds(int samples, int blocks, int gap) {
  if (blocks < 2 || blocks > samples)
    throw InputError("cross-validation: " + std::to_string(blocks) + " blocks of " + std::to_string(samples) +
                     " samples; give at least 2 blocks and no more than there are samples");
  if (gap < 0)
    throw InputError("cross-validation: the gap is " + std::to_string(gap) + "; it must not be negative");
  std::vector<Fold> folds(static_cast<std::size_t>(blocks));
  for (int b = 0; b < blocks; ++b) {
    const int begin = static_cast<int>(static_cast<long>(samples) * b / blocks);
    const int end = static_cast<int>(static_cast<long>(samples) * (b + 1) / blocks);
    Fold& fold = folds[static_cast<std::size_t>(b)];
    for (int i = 0; i < samples; ++i) {
      if (i >= begin && i < end)
        fold.test.push_back(i);
      else if (i < begin - gap || i >= end + gap)
        fold.train.push_back(i);
    }
    if (fold.train.empty())
      throw InputError("cross-validation: a gap of " + std::to_string(gap) + " leaves nothing to fit of " +
                       std::to_string(samples) + " samples; make it smaller");
  }
  return folds;
}

Eigen::MatrixXd rowsOf(const Eigen::MatrixXd& matrix, const std::vector<int>& rows) {
  return matrix(rows, Eigen::all);
}

std::vector<int> evenlyChosen(Eigen::Index samples, Eigen::Index most) {
  std::vector<int> chosen;
  const Eigen::Index count = std::min(samples, most);
  for (Eigen::Index i = 0; i < count; ++i) chosen.push_back(static_cast<int>(i * samples / count));
  return chosen;
}

RidgeValidation validateRidge(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                              const std::vector<Fold>& folds) {
  std::vector<double> lambdas;
  for (double exponent = -8.0; exponent <= 0.0; exponent += 0.5) lambdas.push_back(std::pow(10.0, exponent));
  const std::size_t count = lambdas.size();
  std::vector<double> sum(count, 0.0);
  double held = 0.0;
  for (const Fold& fold : folds) {
    const Decomposition decomposition(rowsOf(x, fold.train), rowsOf(y, fold.train));
    const Eigen::MatrixXd testX = rowsOf(x, fold.test), testY = rowsOf(y, fold.test);
    held += static_cast<double>(testY.size());
    for (std::size_t l = 0; l < count; ++l)
      sum[l] += (testY - decomposition.model(lambdas[l]).evaluate(testX)).squaredNorm();
  }
  std::size_t best = 0;
  for (std::size_t l = 1; l < count; ++l)
    if (sum[l] < sum[best]) best = l;
  return {lambdas[best], std::sqrt(sum[best] / held)};
}

}  // namespace mm
