#include "benchmark_oracle.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"

namespace mm {

double Oracle::sure() { return std::log(1000.0); }

Oracle::Oracle(const Eigen::MatrixXd& noise) {
  constexpr Eigen::Index kFewest = 8;
  if (noise.cols() < kFewest || noise.rows() == 0)
    throw InputError("the oracle needs at least 8 sessions in which nothing is hidden, not " +
                     std::to_string(noise.cols()) + "; raise --oracle");
  const Eigen::Index count = noise.cols() / 2;
  check_ = noise.rightCols(noise.cols() - count);
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(noise.leftCols(count), Eigen::ComputeThinU);
  const Eigen::VectorXd variance = svd.singularValues().array().square() / static_cast<double>(count);

  // What white noise alone would show as its largest variance in so few sessions (Marchenko and Pastur 1967)
  // separates the strong directions; these come out too large by as much as the rest adds to them (Baik and
  // Silverstein 2006).
  const auto n = static_cast<double>(noise.rows());
  const double ratio = n / static_cast<double>(count), edge = std::pow(1.0 + std::sqrt(ratio), 2);
  Eigen::Index strong = 0;
  double rest = variance.sum();
  white_ = rest / n;
  while (strong + 1 < variance.size() && variance(strong) > edge * white_) {
    rest -= variance(strong++);
    white_ = rest / (n - static_cast<double>(strong));
  }
  strong_ = svd.matrixU().leftCols(strong);
  share_.resize(strong);
  for (Eigen::Index i = 0; i < strong; ++i) {
    const double b = variance(i) / white_ + 1.0 - ratio;
    const double spread = std::max(0.0, b * b - 4.0 * variance(i) / white_);
    share_(i) = 1.0 - 1.0 / std::max(1.0, 0.5 * (b + std::sqrt(spread)));
  }
}

double Oracle::gain(const Eigen::VectorXd& column, const Eigen::VectorXd& residuals) const {
  if (column.size() != rows() || residuals.size() != rows()) return 0.0;
  const Eigen::VectorXd weights =
      column - strong_ * share_.cwiseProduct(strong_.transpose() * column);  // over the white variance
  const double variance = (check_.transpose() * weights).squaredNorm() / static_cast<double>(check_.cols());
  if (!(variance > 0.0)) return 0.0;
  const double sensitivity = weights.dot(column) / std::sqrt(variance),
               found = weights.dot(residuals) / std::sqrt(variance);
  // Largest over the size s of the cause of -ln(1 + s² sensitivity²) / 2 + the gain of the fit.
  const double square = found * found;
  return sensitivity != 0.0 && square > 1.0 ? 0.5 * (square - 1.0 - std::log(square)) : 0.0;
}

}  // namespace mm
