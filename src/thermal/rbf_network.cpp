#include <cmath>
#include <limits>

#include "base/dense.h"
#include "thermal/ridge.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

constexpr double kHalf = 0.69314718055994531;  // exp(-kHalf) = 1/2

Eigen::MatrixXd strengths(const Eigen::MatrixXd& x, const Eigen::MatrixXd& centres, double spread) {
  Eigen::MatrixXd phi(x.rows(), centres.rows());
  for (Eigen::Index c = 0; c < centres.rows(); ++c)
    phi.col(c) =
        (-(x.rowwise() - centres.row(c)).rowwise().squaredNorm() * (kHalf / (spread * spread))).array().exp();
  return phi;
}

/// Weights that meet every sample about the mean of the outputs; the shortest where samples coincide.
Eigen::MatrixXd exactWeights(const Eigen::MatrixXd& x, const Eigen::MatrixXd& centred, double spread) {
  return shortestLeastSquares(strengths(x, x, spread), centred);
}

/// See newRbfNetwork().
class RbfNetwork : public ThermalNetwork {
 public:
  explicit RbfNetwork(const NetworkSettings& settings) : ThermalNetwork(settings) {}

  NetworkKind kind() const override { return NetworkKind::kRbf; }
  int rules() const override { return static_cast<int>(centres_.rows()); }
  void evaluate(const double* x, double* y) const override;

 protected:
  void learn() override;
  void store(NetworkNumbers& numbers) override {
    numbers(spread_);
    numbers(mean_, 1, inputs());
    numbers(scale_, 1, inputs());
    numbers(centres_, -1, inputs());
    numbers(weights_, centres_.rows(), outputs());
    numbers(offset_, 1, outputs());
  }

 private:
  static constexpr int kMostCentres = 300;
  Eigen::RowVectorXd mean_, scale_;  // standardised x = (x - mean) * scale
  Eigen::MatrixXd centres_;          // centres x inputs, standardised
  double spread_ = 1.0;              // distance at which a centre's strength is one half, standardised
  RowMatrix weights_;                // centres x outputs
  Eigen::RowVectorXd offset_;
};

void RbfNetwork::learn() {
  const Eigen::Index n = x_.rows();
  mean_ = x_.colwise().mean();
  scale_ = ((x_.rowwise() - mean_).colwise().squaredNorm() / static_cast<double>(n)).cwiseSqrt();
  for (Eigen::Index i = 0; i < scale_.size(); ++i) scale_(i) = scale_(i) > 0.0 ? 1.0 / scale_(i) : 0.0;
  const std::vector<int> chosen = evenlyChosen(n, kMostCentres);
  const int count = static_cast<int>(chosen.size());
  centres_ = rowsOf((x_.rowwise() - mean_) * scale_.asDiagonal(), chosen);
  const Eigen::MatrixXd y = rowsOf(y_, chosen);

  double best = std::numeric_limits<double>::infinity();
  const std::vector<Fold> folds = blockedFolds(count, std::min(settings_.blocks, count));
  for (double spread = 0.25; spread < 20.0; spread *= 1.5) {
    double squares = 0.0;
    for (const Fold& fold : folds) {
      const Eigen::MatrixXd trainX = rowsOf(centres_, fold.train), trainY = rowsOf(y, fold.train);
      const Eigen::RowVectorXd mean = trainY.colwise().mean();
      const Eigen::MatrixXd weights = exactWeights(trainX, trainY.rowwise() - mean, spread);
      const Eigen::MatrixXd predicted = strengths(rowsOf(centres_, fold.test), trainX, spread) * weights;
      squares += ((predicted.rowwise() + mean) - rowsOf(y, fold.test)).squaredNorm();
    }
    if (squares < best) best = squares, spread_ = spread;
  }
  offset_ = y.colwise().mean();
  weights_ = exactWeights(centres_, y.rowwise() - offset_, spread_);
}

void RbfNetwork::evaluate(const double* x, double* y) const {
  const int p = outputs();
  for (int o = 0; o < p; ++o) y[o] = offset_(o);
  for (Eigen::Index c = 0; c < centres_.rows(); ++c) {
    double square = 0.0;
    for (int i = 0; i < inputs(); ++i) {
      const double d = (x[i] - mean_(i)) * scale_(i) - centres_(c, i);
      square += d * d;
    }
    const double strength = std::exp(-square * kHalf / (spread_ * spread_));
    for (int o = 0; o < p; ++o) y[o] += strength * weights_(c, o);
  }
}

}  // namespace

std::unique_ptr<ThermalNetwork> newRbfNetwork(const NetworkSettings& settings) {
  return std::make_unique<RbfNetwork>(settings);
}

}  // namespace mm
