#include "posterior/size_grid.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

constexpr double kSmallest = 0.15, kLargest = 60.0;
constexpr double kLargeProduct = 1e100;  // its square is still a number
constexpr double kSomeRest = 1e-12;      // share of the squares that no cause explains

/// Reflects a symmetric matrix, from row and column `first` on, so that `vector` becomes a multiple of the
/// first axis. @return that multiple.
double reflect(Eigen::Ref<Eigen::MatrixXd> m, Eigen::Ref<Eigen::VectorXd> vector, Eigen::VectorXd& work,
               int first) {
  const auto k = m.rows() - first;
  auto v = vector.tail(k);
  const double norm = v.norm();
  if (k == 1 || v.tail(k - 1).squaredNorm() == 0.0) return v[0];
  const double to = v[0] > 0.0 ? -norm : norm;
  v[0] -= to;
  const double beta = 2.0 / v.squaredNorm();
  auto part = m.bottomRightCorner(k, k);
  work.head(k).noalias() = beta * (part.selfadjointView<Eigen::Lower>() * v);
  work.head(k) -= 0.5 * beta * work.head(k).dot(v) * v;
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = j; i < k; ++i) part(i, j) -= v[i] * work[j] + work[i] * v[j];
  return to;
}

}  // namespace

const Sizes& sizeGrid() {
  static const Sizes grid = Sizes::LinSpaced(kSizes, std::log(kSmallest), std::log(kLargest)).exp().eval();
  return grid;
}

Sizes logBayesFactors(Eigen::Ref<Eigen::MatrixXd> products, Eigen::Ref<Eigen::VectorXd> target, double rest,
                      double freedoms) {
  static const Sizes squares = sizeGrid().square();
  const int k = static_cast<int>(target.size());
  Eigen::VectorXd work(k), below(k), column(k);
  const double along = reflect(products, target, work, 0);
  for (int j = 0; j + 1 < k; ++j) {
    column.tail(k - j - 1) = products.col(j).tail(k - j - 1);
    below[j] = reflect(products, column, work, j + 1);
  }
  Sizes pivot = 1.0 + squares * products(k - 1, k - 1);
  Sizes logs = Sizes::Zero(), product = pivot;
  for (int j = k - 2; j >= 0; --j) {
    const Sizes off = squares * below[j];
    pivot = (1.0 + squares * products(j, j) - off.square() / pivot).max(kSomeRest);
    product *= pivot;
    if (product.maxCoeff() > kLargeProduct) logs += product.log(), product = 1.0;
  }
  logs += product.log();
  const Sizes explained = (squares * along * along / pivot / rest).min(1.0 - kSomeRest);
  return -0.5 * logs - 0.5 * freedoms * (-explained).log1p();
}

}  // namespace mm
